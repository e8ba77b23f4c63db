#pragma once
/* Scenes of formulas for the sheared filter of indirect light, traced here in the manner of the
 * worker: one ray a pixel, l x l strata of the v-plane by the pattern, one bounce. References have
 * neither pattern nor map in common with what the filter gets. */
#include <stdlib.h>
#include <string.h>

#include "proto/v_plane.h"
#include "tests/random.h"
#include "tests/unit/server/reconstruct/indirect/indirect_scene.h"

enum v_plane_scene_kind {
    V_PLANE_CHECKER, /* a floor below a checkered ceiling that only bounce rays see */
    V_PLANE_ROOM     /* that of indirect_scene.h */
};

struct v_plane_scene {
    struct plan plan;
    enum v_plane_scene_kind kind;
    float height; /* of the ceiling over the floor */
};

static inline float v_plane_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void v_plane_unit(float v[3])
{
    const float scale = 1.0f / sqrtf(v_plane_dot(v, v));
    for (int k = 0; k < 3; k++) v[k] *= scale;
}

static inline void v_plane_cross(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* What arrives along d; returns the distance, 0 for a miss. */
static inline float v_plane_incoming(const struct v_plane_scene *s, const struct room_hit *at,
                                     const float d[3], float radiance[3])
{
    float o[3];
    radiance[0] = radiance[1] = radiance[2] = 0.0f;
    if (s->kind == V_PLANE_CHECKER) {
        const float t = d[2] > 1e-6f ? s->height / d[2] : 0.0f;
        if (!(t > 0.0f)) return 0.0f;
        const float x = 5.0f * (at->point[0] + t * d[0]), y = 5.0f * (at->point[1] + t * d[1]);
        const bool odd = ((int32_t)floorf(x) + (int32_t)floorf(y)) & 1;
        radiance[0] = radiance[1] = radiance[2] = odd ? 1.0f : 0.1f;
        return t;
    }
    for (int k = 0; k < 3; k++) o[k] = at->point[k] + ROOM_OFF * at->normal[k];
    const struct room_hit hit = room_trace(o, d);
    if (hit.t >= ROOM_FAR) return 0.0f;
    room_shade(&hit, radiance);
    return hit.t;
}

/* Tangents of the worker's frame, in the world. */
static inline void v_plane_frame(const struct plan_camera *c, const float normal[3],
                                 float tangent[2][3])
{
    const float n[3] = {v_plane_dot(normal, c->right), v_plane_dot(normal, c->up),
                        -v_plane_dot(normal, c->forward)};
    const float a = 1.0f / fmaxf(1.0f + n[2], 1e-4f), b = -n[0] * n[1] * a;
    const float local[2][3] = {{1.0f - n[0] * n[0] * a, b, -n[0]},
                               {b, 1.0f - n[1] * n[1] * a, -n[1]}};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++)
            tangent[i][k] =
                local[i][0] * c->right[k] + local[i][1] * c->up[k] - local[i][2] * c->forward[k];
}

static inline void v_plane_turned(float frame[2][3], const float n[3], const float local[3],
                                  float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = local[0] * frame[0][k] + local[1] * frame[1][k] + local[2] * n[k];
}

/* What a pixel shows; t is its depth, 0 for nothing. */
static inline struct room_hit v_plane_primary(const struct v_plane_scene *s, int32_t x, int32_t y)
{
    float o[3], d[3];
    if (s->kind == V_PLANE_ROOM) return room_primary(&s->plan, x, y);
    struct room_hit hit = {.normal = {0, 0, 1}, .id = 1};
    plan_camera_ray(&s->plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
    if (!(d[2] < 0.0f)) return (struct room_hit){0};
    hit.t = -o[2] / d[2];
    for (int k = 0; k < 3; k++) hit.point[k] = o[k] + hit.t * d[k];
    return hit;
}

/* One pixel's samples. */
static inline void v_plane_sample(const struct v_plane_scene *s, struct patch *patch, size_t i,
                                  int32_t x, int32_t y, const struct room_hit *at)
{
    const uint32_t l = s->plan.indirect_strata_per_axis;
    const size_t area = (size_t)rect_area(patch->rect);
    float frame[2][3], jitter[2], nearest = BOUNCE_DISTANCE_NONE * s->plan.length_unit;
    v_plane_frame(&s->plan.camera, at->normal, frame);
    pattern_jitter(&s->plan.pattern, x, y, PATTERN_INDIRECT, jitter);
    for (uint32_t j = 0; j < l * l; j++) {
        float side, height, sine, cosine, local[3], d[3], radiance[3];
        v_plane_column(pattern_axis(jitter[0], l, j % l), &side, &height);
        v_plane_row(pattern_axis(jitter[1], l, j / l), &sine, &cosine);
        v_plane_direction(side, height, sine, cosine, local);
        v_plane_turned(frame, at->normal, local, d);
        const float t = v_plane_incoming(s, at, d, radiance);
        for (uint32_t c = 0; c < 3; c++)
            patch->indirect_strata[(4 * j + c) * area + i] = radiance[c];
        patch->indirect_strata[(4 * j + 3) * area + i] = t;
        if (t > 0.0f) nearest = fminf(nearest, t);
    }
    patch->bounce_distance_min[i] = nearest;
}

/* Samples of `rect` at l x l strata. Owned by the caller. */
static inline struct patch *v_plane_patch(struct v_plane_scene *s, struct rect rect, uint32_t l)
{
    struct patch *patch;
    s->plan.indirect_strata_per_axis = l;
    if (patch_create(&s->plan, rect, &patch)) abort();
    size_t i = 0;
    memset(patch->indirect_strata, 0, (size_t)rect_area(rect) * 4 * l * l * sizeof(float));
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x++, i++) {
            const struct room_hit hit = v_plane_primary(s, x, y);
            patch->depth[i] = hit.t;
            patch->id[i] = hit.id;
            patch->bounce_distance_min[i] = 0.0f;
            for (int k = 0; k < 3; k++) patch->normal[k][i] = hit.normal[k];
            if (hit.t > 0.0f) v_plane_sample(s, patch, i, x, y, &hit);
        }
    }
    return patch;
}

/* The true mean over side x side strata with a jitter each. */
static inline void v_plane_reference(const struct v_plane_scene *s, int32_t x, int32_t y,
                                     uint32_t side, float out[3])
{
    struct random r = {(uint64_t)(uint32_t)y << 32 | (uint32_t)x};
    const struct room_hit hit = v_plane_primary(s, x, y);
    float frame[2][3];
    double sum[3] = {0};
    if (!(hit.t > 0.0f)) return;
    v_plane_frame(&s->plan.camera, hit.normal, frame);
    for (uint32_t j = 0; j < side * side; j++) {
        const float place[2] = {((float)(j % side) + random_unit(&r)) / (float)side,
                                ((float)(j / side) + random_unit(&r)) / (float)side};
        float local[3], d[3], radiance[3];
        room_direction(place, local);
        v_plane_turned(frame, hit.normal, local, d);
        v_plane_incoming(s, &hit, d, radiance);
        for (int c = 0; c < 3; c++) sum[c] += (double)radiance[c];
    }
    for (int c = 0; c < 3; c++) out[c] = (float)(sum[c] / (side * side));
}

static inline void v_plane_camera(struct plan *plan, const float eye[3], const float target[3],
                                  float half_height)
{
    struct plan_camera *c = &plan->camera;
    const float z[3] = {0, 0, 1};
    for (int k = 0; k < 3; k++) {
        c->eye[k] = eye[k];
        c->forward[k] = target[k] - eye[k];
    }
    v_plane_unit(c->forward);
    v_plane_cross(c->forward, z, c->right);
    v_plane_unit(c->right);
    v_plane_cross(c->right, c->forward, c->up);
    c->half_height = half_height;
    c->half_width = half_height * (float)plan->width_px / (float)plan->height_px;
}

static inline void v_plane_scene_init(struct v_plane_scene *s, enum v_plane_scene_kind kind,
                                      int32_t width, int32_t height)
{
    struct plan *plan = &s->plan;
    s->kind = kind;
    s->height = 0.1f;
    room_plan(plan, height, INDIRECT_FILTER_SHEARED, 4);
    plan->width_px = width;
    plan->camera.half_width = plan->camera.half_height * (float)width / (float)height;
    if (kind == V_PLANE_CHECKER)
        v_plane_camera(plan, (float[]){0.4f, -2.4f, 1.6f}, (float[]){0, 0, 0}, 0.35f);
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) |
                   PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(INDIRECT_STRATA);
}
