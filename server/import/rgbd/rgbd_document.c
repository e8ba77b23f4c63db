#include "server/import/rgbd/rgbd_document.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AT(member)   offsetof(struct rgbd_document, member)
#define IN(member)   offsetof(struct rgbd_frame, member)
#define FOCAL_MAX_PX 1e6

static int read_f64(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    return json_cursor_number(at, v, m->min, m->max, (double *)(void *)((char *)o + m->offset));
}

static int read_name(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    int rc = json_cursor_expect(at, v, JSON_STRING, "the name of a file");
    if (rc == 0 && json_string_length(v) == 0)
        rc = json_cursor_refuse(at, ERR_RANGE, "it names nothing");
    if (rc == 0) *(const char **)(void *)((char *)o + m->offset) = json_string_value(v);
    return rc;
}

static int read_time(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    ((struct rgbd_frame *)o)->has_time = true;
    return read_f64(at, m, v, o);
}

static int read_array(struct json_cursor *at, const json_t *v, size_t count, double most,
                      double *out)
{
    int rc = json_cursor_expect(at, v, JSON_ARRAY, "an array of numbers");
    if (rc == 0 && json_array_size(v) != count)
        rc = json_cursor_refuse(at, ERR_RANGE, "it has %zu numbers, not %zu", json_array_size(v),
                                count);
    for (size_t i = 0; i < count && rc == 0; i++) {
        const size_t length = json_cursor_enter_index(at, i);
        rc = json_cursor_number(at, json_array_get(v, i), -most, most, &out[i]);
        if (rc == 0) json_cursor_leave(at, length);
    }
    return rc;
}

static int read_pixel(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    (void)m;
    return read_array(at, v, 2, LIMIT_IMAGE_SIDE_PX, ((struct rgbd_document *)o)->place.pixel);
}

static int read_to_scene(struct json_cursor *at, const struct json_member *m, const json_t *v,
                         void *o)
{
    struct rgbd_document *d = o;
    double rows[16], scale;
    (void)m;
    int rc = read_array(at, v, 16, (double)LIMIT_COORDINATE, rows);
    if (rc != 0) return rc;
    d->has_to_scene = true;
    return rgbd_similarity_read(rows, &d->to_scene, &scale)
               ? 0
               : json_cursor_refuse(at, ERR_RANGE,
                                    "it is no rotation, times one scale, and translation");
}

static const struct json_member frame_members[] = {
    {.name = "color", .read = read_name, .offset = IN(color), .required = true},
    {.name = "depth", .read = read_name, .offset = IN(depth), .required = true},
    {.name = "time_s", .read = read_time, .offset = IN(time_s), .min = 0, .max = 1e12},
    {.name = NULL}};

static int read_frame(struct json_cursor *at, const json_t *v, struct rgbd_document *d, uint32_t i)
{
    int rc = json_cursor_members(at, v, frame_members, &d->frames[i]);
    if (rc == 0 && d->frames[i].has_time != d->frames[0].has_time)
        rc = json_cursor_refuse(at, ERR_MISSING, "some frames have a time_s, and others have none");
    return rc;
}

static int read_frames(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    struct rgbd_document *d = o;
    (void)m;
    int rc = json_cursor_expect(at, v, JSON_ARRAY, "an array of frames");
    const size_t count = json_array_size(v);
    if (rc == 0 && count == 0) rc = json_cursor_refuse(at, ERR_RANGE, "it names no frame");
    if (rc == 0 && count > LIMIT_SCENE_FILES)
        rc = json_cursor_refuse(at, ERR_LIMIT, "%zu frames are above the limit of %d", count,
                                LIMIT_SCENE_FILES);
    if (rc == 0 && (d->frames = calloc(count, sizeof *d->frames)) == NULL)
        rc = json_cursor_refuse(at, ERR_MEMORY, "no memory for %zu frames", count);
    for (uint32_t i = 0; rc == 0 && i < count; i++) {
        const size_t length = json_cursor_enter_index(at, i);
        rc = read_frame(at, json_array_get(v, i), d, i);
        if (rc == 0) json_cursor_leave(at, length);
    }
    d->frame_count = (uint32_t)count;
    return rc;
}

#define NUMBER(word, field, least, most, must)                                                     \
    {                                                                                              \
        .name = (word), .read = read_f64, .offset = AT(field), .min = (least), .max = (most),      \
        .required = (must)                                                                         \
    }
#define OBJECT(word, table, must)                                                                  \
    {                                                                                              \
        .name = (word), .read = json_member_object, .members = (table), .required = (must)         \
    }

static const struct json_choice formats[] = {
    {"tum", RGBD_POSES_TUM, NULL}, {"matrices", RGBD_POSES_MATRICES, NULL}, {NULL, 0, NULL}};

static const struct json_member camera_members[] = {
    NUMBER("fx", fx, 1, FOCAL_MAX_PX, true),
    NUMBER("fy", fy, 1, FOCAL_MAX_PX, true),
    NUMBER("cx", cx, -FOCAL_MAX_PX, FOCAL_MAX_PX, true),
    NUMBER("cy", cy, -FOCAL_MAX_PX, FOCAL_MAX_PX, true),
    {.name = NULL}};

static const struct json_member depth_members[] = {NUMBER("scale", scale, 1e-3, 1e9, false),
                                                   NUMBER("near", near_m, 1e-3, 1e6, false),
                                                   NUMBER("far", far_m, 1e-3, 1e6, false),
                                                   {.name = NULL}};

static const struct json_member pose_members[] = {
    {.name = "file", .read = read_name, .offset = AT(poses), .required = true},
    {.name = "format",
     .read = json_member_choice,
     .offset = AT(pose_format),
     .choices = formats,
     .required = true},
    {.name = NULL}};

static const struct json_member place_members[] = {
    {.name = "frame",
     .read = json_member_u32,
     .offset = AT(place.frame),
     .min = 1,
     .max = LIMIT_SCENE_FILES},
    {.name = "pixel", .read = read_pixel, .required = true},
    NUMBER("turn_deg", place.turn_deg, -360, 360, false),
    NUMBER("scale", place.scale, 1e-6, 1e6, false),
    {.name = NULL}};

/* Where there is a place, its frame is the first by default. */
static int read_place(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    ((struct rgbd_document *)o)->place.frame = 1;
    return json_cursor_members(at, v, m->members, o);
}

static const struct json_member members[] = {
    OBJECT("camera", camera_members, true),
    OBJECT("depth", depth_members, false),
    {.name = "frames", .read = read_frames, .required = true},
    OBJECT("poses", pose_members, true),
    NUMBER("fps", fps, 1e-3, 1e3, false),
    {.name = "fuse", .read = json_member_u32, .offset = AT(fuse), .min = 0, .max = 8},
    {.name = "white",
     .read = json_member_f32x3,
     .offset = AT(white),
     .min = 1e-6,
     .max = (double)LIMIT_RADIANCE},
    {.name = "place", .read = read_place, .members = place_members},
    {.name = "to_scene", .read = read_to_scene},
    {.name = NULL}};

static int check(struct json_cursor *at, const struct rgbd_document *d)
{
    if ((d->place.frame > 0) == d->has_to_scene)
        return json_cursor_refuse_member(at, "place", d->has_to_scene ? ERR_EXISTS : ERR_MISSING,
                                         "give either place or to_scene");
    if (d->place.frame > d->frame_count) {
        json_cursor_enter(at, "place");
        return json_cursor_refuse_member(at, "frame", ERR_RANGE, "%u: there are %u frames",
                                         d->place.frame, d->frame_count);
    }
    if (d->frames[0].has_time && d->pose_format == RGBD_POSES_MATRICES) {
        json_cursor_enter(at, "poses");
        return json_cursor_refuse_member(at, "format", ERR_UNSUPPORTED,
                                         "matrices have no times: frames with a time_s need tum");
    }
    if (d->near_m < d->far_m) return 0;
    json_cursor_enter(at, "depth");
    return json_cursor_refuse_member(at, "far", ERR_RANGE, "%.9g is not beyond near, %.9g",
                                     d->far_m, d->near_m);
}

static int read_json(struct rgbd_document *d, const struct file_view *file, struct fault *fault)
{
    struct json_cursor at;
    int rc =
        json_read((const char *)file->data, file->size_bytes, LIMIT_JOB_BYTES, &d->json, fault);
    json_cursor_init(&at, fault);
    json_cursor_enter(&at, "rgbd");
    if (rc != 0) {
        const struct fault inner = *fault;
        return fault_set(fault, rc, at.pointer, "%s%s%s", inner.pointer,
                         inner.pointer[0] ? ": " : "", inner.detail);
    }
    rc = json_cursor_members(&at, d->json, members, d);
    return rc == 0 ? check(&at, d) : rc;
}

int rgbd_file_map(const struct rgbd_document *d, struct files *files, const char *name,
                  const char *place, struct file_view *out, struct fault *fault)
{
    char path[LIMIT_PATH_BYTES];
    int rc = files_resolve(d->name, name, false, path, place, fault);
    return rc == 0 ? files_map(files, path, place, out, fault) : rc;
}

int rgbd_document_open(struct rgbd_document *d, struct files *files, const char *name,
                       struct fault *fault)
{
    struct file_view file;
    *d = (struct rgbd_document){
        .name = name, .scale = 1000, .near_m = 0.1, .far_m = 30, .fps = 24, .fuse = 2};
    d->place.scale = 1;
    int rc = files_map(files, name, "/rgbd", &file, fault);
    if (rc != 0) return rc;
    rc = read_json(d, &file, fault);
    files_unmap(&file);
    if (rc == 0) rc = rgbd_file_map(d, files, d->poses, "/rgbd/poses/file", &file, fault);
    if (rc != 0) return rc;
    rc = rgbd_poses_read(&file, d, fault);
    files_unmap(&file);
    return rc;
}

void rgbd_document_close(struct rgbd_document *d)
{
    json_decref(d->json);
    free(d->frames);
    *d = (struct rgbd_document){0};
}
