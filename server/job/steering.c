#include "server/job/steering.h"

#include <stdio.h>

#include "proto/limits.h"

struct region {
    int32_t x, y, width, height;
};

static const struct json_member region_members[] = {
    {"x", json_member_i32, offsetof(struct region, x), 0, LIMIT_IMAGE_SIDE_PX - 1,
     .required = true},
    {"y", json_member_i32, offsetof(struct region, y), 0, LIMIT_IMAGE_SIDE_PX - 1,
     .required = true},
    {"width", json_member_i32, offsetof(struct region, width), 1, LIMIT_IMAGE_SIDE_PX,
     .required = true},
    {"height", json_member_i32, offsetof(struct region, height), 1, LIMIT_IMAGE_SIDE_PX,
     .required = true},
    {0},
};

static const struct json_member near_members[] = {
    {"x", json_member_i32, offsetof(struct steering, near_x), 0, LIMIT_IMAGE_SIDE_PX - 1,
     .required = true},
    {"y", json_member_i32, offsetof(struct steering, near_y), 0, LIMIT_IMAGE_SIDE_PX - 1,
     .required = true},
    {0},
};

static int read_priority(struct json_cursor *at, const struct json_member *m, const json_t *value,
                         void *object)
{
    struct steering *s = object;
    s->given |= STEERING_PRIORITY;
    return json_member_i32(at, m, value, s);
}

static int read_paused(struct json_cursor *at, const struct json_member *m, const json_t *value,
                       void *object)
{
    struct steering *s = object;
    s->given |= STEERING_PAUSED;
    return json_member_bool(at, m, value, s);
}

static int read_region(struct json_cursor *at, const struct json_member *m, const json_t *value,
                       void *object)
{
    struct steering *s = object;
    struct region r = {0};
    s->given |= STEERING_REGION;
    if (json_is_null(value)) return 0;
    int error = json_cursor_members(at, value, m->members, &r);
    s->region = (struct rect){r.x, r.y, r.x + r.width, r.y + r.height};
    return error;
}

static int read_near(struct json_cursor *at, const struct json_member *m, const json_t *value,
                     void *object)
{
    struct steering *s = object;
    s->given |= STEERING_NEAR;
    if (json_is_null(value)) return 0;
    s->has_near = true;
    return json_cursor_members(at, value, m->members, s);
}

static const struct json_member members[] = {
    {.name = "priority",
     .read = read_priority,
     .offset = offsetof(struct steering, priority),
     .min = -LIMIT_PRIORITY,
     .max = LIMIT_PRIORITY},
    {.name = "paused", .read = read_paused, .offset = offsetof(struct steering, paused)},
    {.name = "region", .read = read_region, .members = region_members},
    {.name = "near", .read = read_near, .members = near_members},
    {0},
};

int steering_read(const char *text, size_t size_bytes, struct steering *out, struct fault *fault)
{
    json_t *root = NULL;
    struct json_cursor at;
    *out = (struct steering){0};
    int error = json_read(text, size_bytes, LIMIT_JOB_BYTES, &root, fault);
    if (error) return error;
    json_cursor_init(&at, fault);
    error = json_cursor_members(&at, root, members, out);
    if (!error && out->given == 0)
        error = json_cursor_refuse(&at, ERR_MISSING, "the document changes nothing");
    json_decref(root);
    return error;
}

/* `end` is beyond what begins at `first`, of an image that many pixels long. */
static int check_span(const char *pointer, const char *extent, int32_t first, int32_t end,
                      int32_t length_px, struct fault *fault)
{
    char place[64];
    if (end <= length_px) return 0;
    const bool outside = first >= length_px;
    snprintf(place, sizeof place, "%s/%s", pointer, extent);
    return fault_set(fault, ERR_RANGE, place, "%s %d is beyond the picture's %d pixels",
                     outside ? "pixel" : "the end at", outside ? first : end, length_px);
}

int steering_check(const struct steering *s, int32_t width_px, int32_t height_px,
                   struct fault *fault)
{
    const struct rect r = s->region;
    int error = 0;
    if (!rect_is_empty(r)) {
        error = check_span("/region", r.x0 < width_px ? "width" : "x", r.x0, r.x1, width_px, fault);
        if (!error)
            error = check_span("/region", r.y0 < height_px ? "height" : "y", r.y0, r.y1, height_px,
                               fault);
    }
    if (!error && s->has_near)
        error = check_span("/near", "x", s->near_x, s->near_x + 1, width_px, fault);
    if (!error && s->has_near)
        error = check_span("/near", "y", s->near_y, s->near_y + 1, height_px, fault);
    return error;
}
