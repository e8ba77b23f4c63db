#include "server/import/rgbd/rgbd_import.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "server/import/rgbd/depth_map.h"
#include "server/import/rgbd/depth_mesh.h"
#include "server/import/rgbd/rgbd_place.h"
#include "server/import/scene/cameras.h"
#include "server/import/scene/mesh.h"
#include "server/import/scene/surface.h"

#define NAME "rgbd"

/* What part of a picture is as bright as white or brighter. */
#define WHITE_SHARE   0.05
#define DARKEST_WHITE 1e-4f

/* Poses are rotations: their inverse is the transpose. */
static struct affine inverse_of(const struct affine *pose)
{
    struct affine out;
    for (int i = 0; i < 3; i++) {
        double moved = 0;
        for (int j = 0; j < 3; j++) {
            out.m[4 * i + j] = pose->m[4 * j + i];
            moved -= pose->m[4 * j + i] * pose->m[4 * j + 3];
        }
        out.m[4 * i + 3] = moved;
    }
    return out;
}

static struct affine between(const struct affine *from, const struct affine *to)
{
    const struct affine back = inverse_of(to);
    return affine_multiply(&back, from);
}

static int refuse_size(uint32_t frame, const struct depth_map *map, const struct depth_map *first,
                       struct fault *fault)
{
    char place[48];
    snprintf(place, sizeof place, "/rgbd/frames/%u/depth", frame);
    return fault_set(fault, ERR_MISMATCH, place,
                     "it has %d x %d px, the frame beside it %d x %d: they have one camera",
                     map->width, map->height, first->width, first->height);
}

static int fuse_one(const struct rgbd_document *d, struct files *files, uint32_t frame,
                    uint32_t other, struct depth_map *map, struct warnings *warnings,
                    struct fault *fault)
{
    struct depth_map there;
    const struct affine *here = &d->frames[frame].pose, *pose = &d->frames[other].pose;
    const struct affine to = between(here, pose), from = between(pose, here);
    int rc = depth_map_read(d, files, other, false, &there, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(&there);
    if (there.width != map->width || there.height != map->height)
        rc = refuse_size(other, &there, map, fault);
    else
        rc = depth_map_fuse(map, &there, d, &to, &from, fault);
    depth_map_destroy(&there);
    return rc;
}

/* Reads a frame's depth and makes it as good as frames beside it allow. */
static int read_map(const struct rgbd_document *d, struct files *files, uint32_t frame,
                    struct depth_map *out, struct warnings *warnings, struct fault *fault)
{
    int rc = depth_map_read(d, files, frame, true, out, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(out);
    for (uint32_t k = 1; k <= d->fuse && rc == 0; k++) {
        if (frame >= k) rc = fuse_one(d, files, frame, frame - k, out, warnings, fault);
        if (rc == 0 && frame + k < d->frame_count)
            rc = fuse_one(d, files, frame, frame + k, out, warnings, fault);
    }
    if (rc == 0) rc = depth_map_smooth(out, fault);
    if (rc != 0) depth_map_destroy(out);
    return rc;
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Finds the light of white: what few pixels are brighter than, by colour. */
static int find_white(const struct depth_map *m, float white[3], struct fault *fault)
{
    const size_t count = (size_t)m->width * (size_t)m->height;
    float *light = malloc(count * sizeof *light);
    if (light == NULL) return fault_set(fault, ERR_MEMORY, "/rgbd", "no memory for colours");
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++) light[i] = m->color[3 * i + c];
        qsort(light, count, sizeof *light, compare);
        white[c] = fmaxf(light[(size_t)((1 - WHITE_SHARE) * (double)(count - 1))], DARKEST_WHITE);
    }
    free(light);
    return 0;
}

/* Appends a placed part of a mesh: `count` of its triangles from `first` on. */
static int append_part(struct builder *b, const struct scene_mesh *whole, uint32_t first,
                       uint32_t count, uint32_t role, struct fault *fault)
{
    struct scene_mesh part = *whole;
    const struct scene_instance instance = {.mesh = (uint32_t)builder_count(b, SCENE_MESHES),
                                            .flags = INSTANCE_IDENTITY | role,
                                            .name = whole->name,
                                            .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    if (count == 0) return 0;
    part.first_triangle += first;
    part.triangle_count = count;
    int rc = builder_append_record(b, SCENE_MESHES, &part, fault);
    return rc == 0 ? builder_append_record(b, SCENE_INSTANCES, &instance, fault) : rc;
}

/* What shines in the photograph itself is a holdout. */
static int append_mesh(const struct mesh *mesh, uint32_t first_shining, struct builder *b,
                       struct fault *fault)
{
    struct scene_mesh record;
    struct scene_material material;
    surface_init(&material);
    material.metallic = material.specular = 0;
    material.flags = MATERIAL_DOUBLE_SIDED | MATERIAL_COLORED;
    int rc = builder_name(b, NAME, &material.name, fault);
    if (rc == 0) rc = mesh_append(mesh, b, &record, fault);
    if (rc != 0) return rc;
    record.name = material.name;
    record.material = (uint32_t)builder_count(b, SCENE_MATERIALS);
    rc = builder_append_record(b, SCENE_MATERIALS, &material, fault);
    if (rc == 0) rc = append_part(b, &record, 0, first_shining, INSTANCE_CATCHER, fault);
    return rc == 0 ? append_part(b, &record, first_shining, mesh->triangle_count - first_shining,
                                 INSTANCE_HOLDOUT, fault)
                   : rc;
}

static int append_surfaces(const struct rgbd_document *d, const struct depth_map *map,
                           const struct affine *to_scene, struct builder *b, struct fault *fault)
{
    struct mesh mesh;
    uint32_t first_shining;
    float white[3] = {d->white[0], d->white[1], d->white[2]};
    int rc = white[0] > 0 ? 0 : find_white(map, white, fault);
    if (rc == 0) rc = depth_mesh_make(map, d, white, &mesh, &first_shining, fault);
    if (rc != 0) return rc;
    rc = mesh_transform(&mesh, to_scene, "/rgbd", fault);
    if (rc == 0) rc = append_mesh(&mesh, first_shining, b, fault);
    mesh_fini(&mesh);
    return rc;
}

/* OpenCV's cameras look along z with y down, the scene's along -z with y up. */
static int append_camera(const struct rgbd_document *d, const struct depth_map *map,
                         const struct affine *to_scene, struct builder *b, struct fault *fault)
{
    const double width = map->width, height = map->height;
    struct affine turned = *to_scene;
    struct scene_camera camera = {
        .type = CAMERA_PERSPECTIVE,
        .yfov_rad = (float)(2 * atan(height / (2 * d->fy))),
        .half_width = (float)(width / (2 * d->fx)),
        .centre_x = (float)(2 * (d->cx + 0.5) / width - 1),
        .centre_y = (float)(1 - 2 * (d->cy + 0.5) / height),
    };
    for (int i = 0; i < 3; i++) {
        turned.m[4 * i + 1] = -turned.m[4 * i + 1];
        turned.m[4 * i + 2] = -turned.m[4 * i + 2];
    }
    int rc = builder_name(b, NAME, &camera.name, fault);
    if (rc == 0 && !camera_set_frame(&camera, &turned))
        rc = fault_set(fault, ERR_RANGE, "/rgbd/poses", "a camera looks nowhere");
    b->default_camera = (uint32_t)builder_count(b, SCENE_CAMERAS);
    return rc == 0 ? builder_append_record(b, SCENE_CAMERAS, &camera, fault) : rc;
}

/* Names the backplate; a name that would be cut names no file. */
static int set_plate(const struct rgbd_document *d, uint32_t frame, struct builder *b,
                     struct fault *fault)
{
    char plate[LIMIT_PATH_BYTES], place[48];
    snprintf(place, sizeof place, "/rgbd/frames/%u/color", frame);
    int rc = files_resolve(d->name, d->frames[frame].color, false, plate, place, fault);
    if (rc == 0 && strlen(plate) >= LIMIT_NAME_BYTES)
        rc = fault_set(fault, ERR_LIMIT, place, "its path has more than %d bytes",
                       LIMIT_NAME_BYTES - 1);
    return rc == 0 ? builder_name(b, plate, &b->plate, fault) : rc;
}

static int add_frame(const struct rgbd_document *d, struct files *files, uint32_t frame,
                     struct builder *b, struct fault *fault)
{
    struct affine place;
    struct depth_map map;
    int rc = rgbd_place_find(d, files, &place, &b->warnings, fault);
    if (rc == 0) rc = read_map(d, files, frame, &map, &b->warnings, fault);
    if (rc != 0) return rc;
    struct affine to_scene = affine_multiply(&place, &d->frames[frame].pose);
    for (int i = 0; i < 3; i++) to_scene.m[4 * i + 3] -= b->origin[i];
    rc = append_surfaces(d, &map, &to_scene, b, fault);
    if (rc == 0) rc = append_camera(d, &map, &to_scene, b, fault);
    if (rc == 0) rc = set_plate(d, frame, b, fault);
    depth_map_destroy(&map);
    return rc;
}

int rgbd_import(struct files *files, const struct scene_choice *choice, struct builder *b,
                struct fault *fault)
{
    struct rgbd_document d;
    int rc = rgbd_document_open(&d, files, choice->rgbd, fault);
    const double at = rc == 0 ? round(choice->time_s * d.fps) : 0;
    if (rc == 0 && !(at >= 0 && at < d.frame_count))
        rc = fault_set(fault, ERR_NOT_FOUND, "/rgbd/frames",
                       "there is no frame at %.9g s: the last of %u is at %.9g s", choice->time_s,
                       d.frame_count, (d.frame_count - 1) / d.fps);
    if (rc == 0) rc = add_frame(&d, files, (uint32_t)at, b, fault);
    b->moves = true;
    rgbd_document_close(&d);
    return rc;
}
