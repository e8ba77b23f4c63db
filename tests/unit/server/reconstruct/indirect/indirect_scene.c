#include "tests/unit/server/reconstruct/indirect/indirect_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROOM_SPHERES 2

struct room_box {
    float centre[3], half[3], cosine, sine; /* turned about y */
    float albedo[3];
};

struct room_sphere {
    float centre[3], radius;
    float albedo[3];
};

static const float room_lamp[3] = {0.05f, 1.6f, 0.1f};

static const struct room_box room_boxes[ROOM_BOXES] = {
    {{-0.42f, 0.6f, -0.35f}, {0.28f, 0.6f, 0.28f}, 0.955336f, 0.295520f, {0.72f, 0.72f, 0.72f}},
    {{0.12f, 0.12f, 0.55f}, {0.25f, 0.12f, 0.12f}, 0.939373f, -0.342898f, {0.7f, 0.6f, 0.2f}}};

static const struct room_sphere room_spheres[ROOM_SPHERES] = {
    {{0.45f, 0.38f, -0.05f}, 0.38f, {0.72f, 0.72f, 0.72f}},
    {{-0.62f, 0.16f, 0.55f}, 0.16f, {0.2f, 0.3f, 0.75f}}};

static float room_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float room_hit_sphere(const struct room_sphere *s, const float o[3], const float d[3])
{
    const float q[3] = {o[0] - s->centre[0], o[1] - s->centre[1], o[2] - s->centre[2]};
    const float b = room_dot(q, d), c = room_dot(q, q) - s->radius * s->radius, root2 = b * b - c;
    const float t = root2 > 0.0f ? -b - sqrtf(root2) : 0.0f;
    return t > ROOM_OFF ? t : ROOM_FAR;
}

static void room_turn(const struct room_box *b, float side, const float v[3], float out[3])
{
    out[0] = b->cosine * v[0] + side * b->sine * v[2];
    out[1] = v[1];
    out[2] = b->cosine * v[2] - side * b->sine * v[0];
}

/* The normal is in the box's own axes. */
static float room_hit_box(const struct room_box *b, const float o[3], const float d[3],
                          float normal[3])
{
    const float q[3] = {o[0] - b->centre[0], o[1] - b->centre[1], o[2] - b->centre[2]};
    float from[3], to[3], near = -ROOM_FAR, far = ROOM_FAR;
    int axis = 0;
    room_turn(b, 1.0f, q, from);
    room_turn(b, 1.0f, d, to);
    for (int k = 0; k < 3; k++) {
        const float inverse = 1.0f / (to[k] != 0.0f ? to[k] : 1e-20f);
        const float u = (-b->half[k] - from[k]) * inverse, v = (b->half[k] - from[k]) * inverse;
        const float first = u < v ? u : v, last = u < v ? v : u;
        axis = first > near ? k : axis;
        near = first > near ? first : near;
        far = last < far ? last : far;
    }
    for (int k = 0; k < 3; k++) normal[k] = k != axis ? 0.0f : to[k] > 0.0f ? -1.0f : 1.0f;
    return near <= far && near > ROOM_OFF ? near : ROOM_FAR;
}

/* x in [-1, 1], y in [0, 2], z in [-1, 1], without the wall at z = 1. */
static void room_hit_walls(const float o[3], const float d[3], struct room_hit *h)
{
    static const float low[3] = {-1, 0, -1}, high[3] = {1, 2, 1};
    static const float walls[3][2][3] = {{{0.63f, 0.065f, 0.05f}, {0.14f, 0.45f, 0.09f}},
                                         {{0.3f, 0.3f, 0.35f}, {0.72f, 0.72f, 0.72f}},
                                         {{0.72f, 0.72f, 0.72f}, {0, 0, 0}}};
    int axis = 0;
    h->t = ROOM_FAR;
    for (int k = 0; k < 3; k++) {
        const float t = d[k] != 0.0f ? ((d[k] > 0.0f ? high : low)[k] - o[k]) / d[k] : ROOM_FAR;
        if (t >= h->t) continue;
        h->t = t;
        axis = k;
    }
    const int up = d[axis] > 0.0f;
    if (axis == 2 && up) h->t = ROOM_FAR;
    const float x = o[0] + h->t * d[0], z = o[2] + h->t * d[2];
    const bool light = axis == 1 && !up && (((int)floorf(4 * x) + (int)floorf(4 * z)) & 1) != 0;
    for (int k = 0; k < 3; k++) {
        h->normal[k] = k != axis ? 0.0f : up ? -1.0f : 1.0f;
        h->albedo[k] = light ? 0.75f : walls[axis][up][k];
    }
    h->id = 1;
}

struct room_hit room_trace(const float o[3], const float d[3])
{
    struct room_hit h;
    int solid = -1;
    float normal[3];
    room_hit_walls(o, d, &h);
    for (int i = 0; i < ROOM_BOXES + ROOM_SPHERES; i++) {
        float n[3] = {0};
        const float t = i < ROOM_BOXES ? room_hit_box(&room_boxes[i], o, d, n)
                                       : room_hit_sphere(&room_spheres[i - ROOM_BOXES], o, d);
        if (t >= h.t) continue;
        h.t = t;
        solid = i;
        memcpy(normal, n, sizeof normal);
    }
    for (int k = 0; k < 3; k++) h.point[k] = o[k] + h.t * d[k];
    if (solid < 0) return h;
    h.id = 2 + (uint32_t)solid;
    if (solid < ROOM_BOXES) {
        room_turn(&room_boxes[solid], -1.0f, normal, h.normal);
        memcpy(h.albedo, room_boxes[solid].albedo, sizeof h.albedo);
    } else {
        const struct room_sphere *s = &room_spheres[solid - ROOM_BOXES];
        for (int k = 0; k < 3; k++) h.normal[k] = (h.point[k] - s->centre[k]) / s->radius;
        memcpy(h.albedo, s->albedo, sizeof h.albedo);
    }
    return h;
}

void room_shade(const struct room_hit *h, float radiance[3])
{
    static const float power[3] = {0.572958f, 0.54431f, 0.487014f};
    float to[3], o[3], ignored[3];
    for (int k = 0; k < 3; k++) {
        to[k] = room_lamp[k] - h->point[k];
        o[k] = h->point[k] + ROOM_OFF * h->normal[k];
        radiance[k] = 0.0f;
    }
    const float d2 = room_dot(to, to), distance = sqrtf(d2);
    for (int k = 0; k < 3; k++) to[k] /= distance;
    const float cosine = room_dot(to, h->normal);
    if (!(cosine > 0.0f)) return;
    for (int i = 0; i < ROOM_BOXES; i++)
        if (room_hit_box(&room_boxes[i], o, to, ignored) < distance) return;
    for (int i = 0; i < ROOM_SPHERES; i++)
        if (room_hit_sphere(&room_spheres[i], o, to) < distance) return;
    for (int k = 0; k < 3; k++) radiance[k] = h->albedo[k] * power[k] * cosine / d2;
}

/* Frisvad's frame around the axis towards the camera, as the worker's; the camera looks along -z.
 */
static void room_frame(const float n[3], float t[3], float s[3])
{
    const float a = 1.0f / (1.0f + fmaxf(n[2], -0.9999f)), b = -n[0] * n[1] * a;
    memcpy(t, (const float[3]){1.0f - n[0] * n[0] * a, b, -n[0]}, 3 * sizeof *t);
    memcpy(s, (const float[3]){b, 1.0f - n[1] * n[1] * a, -n[1]}, 3 * sizeof *s);
}

void room_direction(const float at[2], float out[3])
{
    const float a = 2.0f * at[0] - 1.0f, b = 2.0f * at[1] - 1.0f;
    const bool wide = fabsf(a) > fabsf(b);
    const float radius = wide ? a : b, other = wide ? b : a;
    const float angle = radius != 0.0f ? other / radius * 0.785398163f : 0.0f;
    const float c = cosf(angle), s = sinf(angle);
    out[0] = radius * (wide ? c : s);
    out[1] = radius * (wide ? s : c);
    out[2] = sqrtf(fmaxf(1.0f - radius * radius, 0.0f));
}

/* One sample: adds its light, returns its distance. */
static float room_sample(const struct room_hit *at, const float t[3], const float s[3],
                         const float place[2], double sum[3])
{
    float local[3], d[3], o[3], radiance[3];
    room_direction(place, local);
    for (int k = 0; k < 3; k++) {
        d[k] = local[0] * t[k] + local[1] * s[k] + local[2] * at->normal[k];
        o[k] = at->point[k] + ROOM_OFF * at->normal[k];
    }
    const struct room_hit h = room_trace(o, d);
    if (h.t >= ROOM_FAR) return ROOM_FAR;
    room_shade(&h, radiance);
    for (int k = 0; k < 3; k++) sum[k] += (double)radiance[k];
    return h.t;
}

struct room_hit room_primary(const struct plan *plan, int32_t x, int32_t y)
{
    float o[3], d[3];
    plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
    const float in = (o[2] - 1.0f) / -d[2]; /* to the room's open side */
    for (int k = 0; k < 3; k++) o[k] += in * d[k];
    struct room_hit h = room_trace(o, d);
    h.t += in;
    return h;
}

void room_plan(struct plan *plan, int32_t lines, uint32_t filter, uint32_t strata)
{
    memset(plan, 0, sizeof *plan);
    plan->width_px = plan->height_px = lines;
    plan->tile_px = 32;
    plan->pattern = (struct pattern){11, 0};
    plan->camera = (struct plan_camera){.type = CAMERA_PERSPECTIVE,
                                        .eye = {0.03f, 0.97f, 3.4f},
                                        .right = {1, 0, 0},
                                        .up = {0, 1, 0},
                                        .forward = {0, 0, -1},
                                        .half_width = 0.4104f,
                                        .half_height = 0.4104f};
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) |
                   PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(INDIRECT_MEAN);
    plan->bounces = 1;
    plan->indirect_filter = filter;
    plan->indirect_strata_per_axis = strata;
    plan->mu = 1.0f;
    plan->radiance_scale = 1.0f;
    plan->length_unit = 2.0f;
}

/* The samples of pixel (x, y) into pixel i of the patch. */
static void room_pixel(const struct plan *plan, int32_t x, int32_t y, struct patch *patch, size_t i)
{
    const struct room_hit h = room_primary(plan, x, y);
    const uint32_t l = plan->indirect_strata_per_axis;
    float t[3], s[3], jitter[2], nearest = ROOM_FAR;
    double sum[3] = {0};
    patch->depth[i] = h.t;
    patch->id[i] = h.id;
    room_frame(h.normal, t, s);
    pattern_jitter(&plan->pattern, x, y, PATTERN_INDIRECT, jitter);
    for (uint32_t k = 0; k < l * l; k++) {
        float place[2];
        pattern_stratum(jitter, l, k, place);
        nearest = fminf(nearest, fmaxf(room_sample(&h, t, s, place, sum), ROOM_OFF));
    }
    for (int k = 0; k < 3; k++) {
        patch->normal[k][i] = h.normal[k];
        patch->indirect[k][i] = (float)(sum[k] / (double)(l * l));
    }
    patch->bounce_distance_min[i] =
        nearest < ROOM_FAR
            ? half_to_float(half_from_float(nearest / plan->length_unit)) * plan->length_unit
            : BOUNCE_DISTANCE_NONE * plan->length_unit;
}

struct patch *room_patch(const struct plan *plan, struct rect rect)
{
    struct patch *patch;
    if (patch_create(plan, rect, &patch)) return NULL;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x++)
            room_pixel(plan, x, y, patch,
                       (size_t)(y - rect.y0) * (size_t)rect_width(rect) + (size_t)(x - rect.x0));
    }
    return patch;
}

void room_truth(const struct plan *plan, int32_t x, int32_t y, uint32_t side, double out[3])
{
    const struct room_hit h = room_primary(plan, x, y);
    uint64_t state = (uint64_t)(y * plan->width_px + x) * UINT64_C(0x9e3779b97f4a7c15) + 1;
    float t[3], s[3];
    out[0] = out[1] = out[2] = 0.0;
    room_frame(h.normal, t, s);
    for (uint32_t k = 0; k < side * side; k++) {
        float place[2];
        for (int a = 0; a < 2; a++) {
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            const float jitter = (float)(state >> 40) * 0x1p-24f;
            place[a] = pattern_axis(jitter, side, a == 0 ? k % side : k / side);
        }
        room_sample(&h, t, s, place, out);
    }
    for (int k = 0; k < 3; k++) out[k] /= (double)(side * side);
}
