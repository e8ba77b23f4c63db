#include "tests/unit/server/reconstruct/shadow/shadow_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SCENE_FAR 60.0f

static void scene_unit(float v[3])
{
    const float scale = 1.0f / sqrtf(scene_dot(v, v));
    for (int k = 0; k < 3; k++) v[k] *= scale;
}

static void scene_cross(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

void scene_add(struct shadow_scene *s, enum shape shape, const float a[3], const float b[3],
               float radius)
{
    struct solid *o = &s->solids[s->solid_count++];
    float d2 = 0.0f;
    o->shape = shape;
    o->radius = radius;
    for (int k = 0; k < 3; k++) {
        o->a[k] = a[k];
        o->b[k] = b[k];
        o->centre[k] = 0.5f * (a[k] + b[k]);
        d2 += (b[k] - a[k]) * (b[k] - a[k]);
    }
    o->reach = 0.5f * sqrtf(d2) + radius;
}

#define SCENE_SPHERE(s, x, y, z, r)                                                                \
    scene_add(s, SHAPE_SPHERE, (float[]){x, y, z}, (float[]){x, y, z}, r)

#define SCENE_STICK(s, x, y, z, u, v, w, r)                                                        \
    scene_add(s, SHAPE_STICK, (float[]){x, y, z}, (float[]){u, v, w}, r)

static float scene_first(float t0, float t1, float least, float most)
{
    return t0 > least && t0 < most ? t0 : t1 > least && t1 < most ? t1 : -1.0f;
}

static float scene_hit_sphere(const float c[3], float r, const float o[3], const float d[3],
                              float least, float most)
{
    const float w[3] = {o[0] - c[0], o[1] - c[1], o[2] - c[2]};
    const float a = scene_dot(d, d), b = scene_dot(w, d);
    const float root2 = b * b - a * (scene_dot(w, w) - r * r);
    if (root2 < 0.0f) return -1.0f;
    const float root = sqrtf(root2);
    return scene_first((-b - root) / a, (-b + root) / a, least, most);
}

static float scene_hit_box(const struct solid *s, const float o[3], const float d[3], float least,
                           float most)
{
    float near = -1e30f, far = 1e30f;
    for (int k = 0; k < 3; k++) {
        const float inverse = 1.0f / (d[k] != 0.0f ? d[k] : 1e-20f);
        const float a = (s->a[k] - o[k]) * inverse, b = (s->b[k] - o[k]) * inverse;
        const float first = a < b ? a : b, last = a < b ? b : a;
        near = first > near ? first : near;
        far = last < far ? last : far;
    }
    return near > far ? -1.0f : scene_first(near, far, least, most);
}

static float scene_hit_stick(const struct solid *s, const float o[3], const float d[3], float least,
                             float most)
{
    float along[3], w[3];
    for (int k = 0; k < 3; k++) {
        along[k] = s->b[k] - s->a[k];
        w[k] = o[k] - s->a[k];
    }
    const float length2 = scene_dot(along, along), dd = scene_dot(d, d);
    const float ad = scene_dot(along, d), aw = scene_dot(along, w), dw = scene_dot(d, w);
    const float a = length2 * dd - ad * ad, b = length2 * dw - aw * ad;
    const float c = length2 * (scene_dot(w, w) - s->radius * s->radius) - aw * aw;
    const float root2 = b * b - a * c;
    float best = -1.0f;
    if (root2 >= 0.0f && a > 0.0f) {
        const float t = (-b - sqrtf(root2)) / a, at = aw + t * ad;
        if (at > 0.0f && at < length2 && t > least && t < most) best = t;
    }
    for (int end = 0; end < 2; end++) {
        const float t =
            scene_hit_sphere(end ? s->b : s->a, s->radius, o, d, least, best > 0 ? best : most);
        if (t > 0.0f) best = t;
    }
    return best;
}

static float scene_hit(const struct solid *s, const float o[3], const float d[3], float least,
                       float most)
{
    if (s->shape == SHAPE_SPHERE) return scene_hit_sphere(s->a, s->radius, o, d, least, most);
    if (s->shape == SHAPE_BOX) return scene_hit_box(s, o, d, least, most);
    return scene_hit_stick(s, o, d, least, most);
}

static void scene_normal(const struct solid *s, const float p[3], float n[3])
{
    if (s->shape == SHAPE_BOX) {
        int axis = 0;
        float best = 1e30f, side = 1.0f;
        for (int k = 0; k < 3; k++) {
            const float low = fabsf(p[k] - s->a[k]), high = fabsf(p[k] - s->b[k]);
            if (fminf(low, high) >= best) continue;
            best = fminf(low, high);
            axis = k;
            side = low < high ? -1.0f : 1.0f;
        }
        for (int k = 0; k < 3; k++) n[k] = k == axis ? side : 0.0f;
        return;
    }
    float along[3], w[3], at = 0.0f;
    for (int k = 0; k < 3; k++) {
        along[k] = s->b[k] - s->a[k];
        w[k] = p[k] - s->a[k];
    }
    if (s->shape == SHAPE_STICK)
        at = fminf(1.0f, fmaxf(0.0f, scene_dot(along, w) / scene_dot(along, along)));
    for (int k = 0; k < 3; k++) n[k] = w[k] - at * along[k];
    scene_unit(n);
}

float scene_primary(const struct shadow_scene *s, int32_t x, int32_t y, float p[3], float n[3])
{
    float o[3], d[3], depth = SCENE_FAR;
    int hit = -1;
    plan_camera_ray(&s->plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
    if (s->floor && d[2] < 0.0f && -o[2] / d[2] < depth) {
        depth = -o[2] / d[2];
        hit = s->solid_count;
    }
    for (int k = 0; k < s->solid_count; k++) {
        const float t = scene_hit(&s->solids[k], o, d, 1e-3f, depth);
        if (t > 0.0f) {
            depth = t;
            hit = k;
        }
    }
    if (hit < 0) return 0.0f;
    for (int k = 0; k < 3; k++) p[k] = o[k] + depth * d[k];
    if (hit < s->solid_count)
        scene_normal(&s->solids[hit], p, n);
    else
        memcpy(n, (const float[]){0, 0, 1}, 3 * sizeof *n);
    return depth;
}

/* Solids that may stand between p and the light. */
static int scene_candidates(const struct shadow_scene *s, const struct plan_light *light,
                            const float p[3], int *out)
{
    const float radius =
        sqrtf(scene_dot(light->half_u, light->half_u) + scene_dot(light->half_v, light->half_v));
    float axis[3];
    int count = 0;
    for (int k = 0; k < 3; k++) axis[k] = light->position[k] - p[k];
    const float length2 = scene_dot(axis, axis), length = sqrtf(length2);
    for (int i = 0; i < s->solid_count; i++) {
        const struct solid *o = &s->solids[i];
        float w[3], off2 = 0.0f;
        for (int k = 0; k < 3; k++) w[k] = o->centre[k] - p[k];
        const float t = fminf(1.0f, fmaxf(0.0f, scene_dot(w, axis) / length2));
        for (int k = 0; k < 3; k++) off2 += (w[k] - t * axis[k]) * (w[k] - t * axis[k]);
        const float cone = radius * fminf(1.0f, t + 1.5f * o->reach / length);
        if (sqrtf(off2) <= 1.1f * (o->reach + cone) + 1e-3f) out[count++] = i;
    }
    return count;
}

/* Fraction of the way at which the light's point is blocked; 1: it is not. */
static float scene_blocked(const struct shadow_scene *s, const int *candidates, int count,
                           const float o[3], const float d[3])
{
    float t = 0.9999f;
    bool hit = false;
    for (int k = 0; k < count; k++) {
        const float near = scene_hit(&s->solids[candidates[k]], o, d, 1e-4f, t);
        if (near > 0.0f) {
            t = near;
            hit = true;
        }
    }
    if (s->floor && d[2] < 0.0f) {
        const float near = -o[2] / d[2];
        if (near > 1e-4f && near < t) {
            t = near;
            hit = true;
        }
    }
    return hit ? t : 1.0f;
}

float scene_weight(const struct plan_light *light, const float p[3], const float n[3], float u,
                   float v, float d[3])
{
    for (int k = 0; k < 3; k++)
        d[k] = light->position[k] + u * light->half_u[k] + v * light->half_v[k] - p[k];
    const float d2 = scene_dot(d, d), up = scene_dot(d, n), front = -scene_dot(d, light->direction);
    if (!(up > 0.0f && front > 0.0f)) return 0.0f;
    const float profile = light->profile == PROFILE_GAUSSIAN ? expf(-2.0f * (u * u + v * v)) : 1.0f;
    return profile * up / d2 * (front / d2);
}

static float scene_area(const struct plan_light *light)
{
    return 4.0f *
           sqrtf(scene_dot(light->half_u, light->half_u) * scene_dot(light->half_v, light->half_v));
}

void scene_reference(const struct shadow_scene *s, uint32_t k, const float p[3], const float n[3],
                     uint32_t side, uint32_t seed, float *e, float *seen)
{
    const struct plan_light *light = &s->plan.lights[k];
    int candidates[SCENE_SOLIDS];
    const int count = scene_candidates(s, light, p, candidates);
    double sum = 0.0, all = 0.0;
    uint64_t state = seed * UINT64_C(0x9e3779b97f4a7c15) + 1;
    float o[3];
    for (int i = 0; i < 3; i++) o[i] = p[i] + 1e-3f * n[i];
    for (uint32_t i = 0; i < side * side; i++) {
        float j[2], d[3];
        for (int a = 0; a < 2; a++) {
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            j[a] = (float)(state >> 40) * 0x1p-24f;
        }
        const float u = 2.0f * ((float)(i % side) + j[0]) / (float)side - 1.0f;
        const float v = 2.0f * ((float)(i / side) + j[1]) / (float)side - 1.0f;
        const float g = scene_weight(light, p, n, u, v, d);
        if (!(g > 0.0f)) continue;
        all += (double)g;
        if (scene_blocked(s, candidates, count, o, d) >= 1.0f) sum += (double)g;
    }
    *e = (float)(sum / (side * side)) * scene_area(light);
    *seen = all > 0.0 ? (float)(sum / all) : 1.0f;
}

/* One pixel's samples of light k into the patch. */
static void scene_sample(const struct shadow_scene *s, uint32_t k, struct patch *patch, size_t i,
                         int32_t x, int32_t y, const float p[3], const float n[3])
{
    const struct plan_light *light = &s->plan.lights[k];
    struct patch_light *out = &patch->lights[k];
    const uint32_t l = light->strata_per_axis;
    const size_t area = (size_t)rect_area(patch->rect);
    int candidates[SCENE_SOLIDS];
    const int count = scene_candidates(s, light, p, candidates);
    float jitter[2], o[3], sum = 0.0f, least = 1.0f, most = 0.0f;
    pattern_jitter(&s->plan.pattern, x, y, pattern_light_dimension(k, l), jitter);
    for (int a = 0; a < 3; a++) o[a] = p[a] + 1e-3f * n[a];
    for (uint32_t j = 0; j < l * l; j++) {
        float d[3];
        const float u = 2.0f * pattern_axis(jitter[0], l, j % l) - 1.0f;
        const float v = 2.0f * pattern_axis(jitter[1], l, j / l) - 1.0f;
        const float g = scene_weight(light, p, n, u, v, d);
        const float t = g > 0.0f ? scene_blocked(s, candidates, count, o, d) : 1.0f;
        if (t < 1.0f) {
            least = fminf(least, t);
            most = fmaxf(most, t);
        } else {
            sum += g;
            out->visibility[(j >> 3) * area + i] |= (uint8_t)(1u << (j & 7u));
        }
    }
    if (out->irradiance) out->irradiance[i] = sum / (float)(l * l) * scene_area(light);
    least = fmaxf(least, 0x1p-14f);
    most = fmaxf(most, 0x1p-14f);
    out->slope_min[i] = most < 1.0f && least < 1.0f ? least / (1.0f - least) : 0.0f;
    out->slope_max[i] = out->slope_min[i] > 0.0f ? most / (1.0f - most) : 0.0f;
}

struct patch *scene_patch(const struct shadow_scene *s, struct rect rect)
{
    struct patch *patch;
    if (patch_create(&s->plan, rect, &patch)) return NULL;
    size_t i = 0;
    for (uint32_t k = 0; k < s->plan.light_count; k++) {
        const uint32_t l = s->plan.lights[k].strata_per_axis;
        memset(patch->lights[k].visibility, 0, (size_t)rect_area(rect) * ((l * l + 7) / 8));
    }
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x++, i++) {
            float p[3] = {0}, n[3] = {0};
            patch->depth[i] = scene_primary(s, x, y, p, n);
            for (int k = 0; k < 3; k++) patch->normal[k][i] = n[k];
            for (uint32_t k = 0; k < s->plan.light_count; k++)
                scene_sample(s, k, patch, i, x, y, p, n);
        }
    }
    return patch;
}

struct plan_light scene_light(const float position[3], const float direction[3],
                              const float along[3], float half_u, float half_v)
{
    struct plan_light light = {.type = LIGHT_RECTANGLE,
                               .profile = PROFILE_UNIFORM,
                               .color = {1, 1, 1},
                               .power = 1,
                               .strata_per_axis = 3};
    float n[3], u[3], v[3];
    memcpy(n, direction, sizeof n);
    scene_unit(n);
    const float off = scene_dot(along, n);
    for (int k = 0; k < 3; k++) u[k] = along[k] - off * n[k];
    scene_unit(u);
    scene_cross(n, u, v); /* u x v = n */
    for (int k = 0; k < 3; k++) {
        light.position[k] = position[k];
        light.direction[k] = n[k];
        light.half_u[k] = half_u * u[k];
        light.half_v[k] = half_v * v[k];
    }
    return light;
}

void scene_camera(struct plan *plan, const float eye[3], const float target[3], float half_height)
{
    struct plan_camera *c = &plan->camera;
    const float z[3] = {0, 0, 1};
    for (int k = 0; k < 3; k++) {
        c->eye[k] = eye[k];
        c->forward[k] = target[k] - eye[k];
    }
    scene_unit(c->forward);
    scene_cross(c->forward, z, c->right);
    scene_unit(c->right);
    scene_cross(c->right, c->forward, c->up);
    c->half_height = half_height;
    c->half_width = half_height * (float)plan->width_px / (float)plan->height_px;
}

void scene_init(struct shadow_scene *s, int32_t width, int32_t height, float half, uint32_t l)
{
    memset(s, 0, sizeof *s);
    s->floor = true;
    struct plan *plan = &s->plan;
    plan->width_px = width;
    plan->height_px = height;
    plan->tile_px = 32;
    plan->pattern = (struct pattern){7, 0};
    scene_camera(plan, (float[]){0, -11.5f, 9}, (float[]){0, -0.2f, 0.2f}, 0.384f);
    plan->light_count = 1;
    plan->lights[0] = scene_light((float[]){-1.2f, 0.6f, 8}, (float[]){0.15f, -0.1f, -1},
                                  (float[]){0.878f, 0.479f, 0}, half, half);
    plan->lights[0].strata_per_axis = l;
    plan->shadow_filter = SHADOW_FILTER_SHEARED;
    plan->mu = 1.0f;
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL);
    plan->light_planes =
        1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES;
    plan->radiance_scale = 1.0f;
    plan->length_unit = 16.0f;
}

void scene_furnish(struct shadow_scene *s)
{
    SCENE_SPHERE(s, -1.7f, -2.3f, 2.4f, 0.7f);
    SCENE_BOX(s, 1.0f, 0.3f, 1.4f, 2.6f, 1.3f, 1.7f);
    SCENE_BOX(s, 2.7f, -2.6f, 0, 3.5f, -1.8f, 1.2f);
    SCENE_STICK(s, 0.2f, -2.4f, 0, 0.2f, -2.4f, 2.0f, 0.04f);
    SCENE_STICK(s, -0.6f, -3.4f, 0.5f, 1.6f, -3.6f, 0.5f, 0.04f);
    SCENE_STICK(s, -0.6f, -1.0f, 1.0f, 1.2f, -1.4f, 1.0f, 0.04f);
    SCENE_STICK(s, -1.5f, 1.2f, 2.0f, 0.6f, 0.2f, 2.0f, 0.05f);
    SCENE_STICK(s, -4.5f, -3.5f, 0.15f, -2.5f, -4.2f, 0.15f, 0.05f);
    SCENE_STICK(s, -4.5f, -2.2f, 0, -3.6f, -1.2f, 3.2f, 0.05f);
    for (int k = 0; k < 6; k++) {
        const float x = 0.4f + 0.35f * (float)k;
        SCENE_STICK(s, x, 1.6f, 2.4f, x + 0.6f, 4.0f, 2.6f, 0.06f);
    }
    SCENE_SPHERE(s, -3.3f, 2.6f, 0.2f, 1.5f);
    SCENE_STICK(s, -5.2f, 1.9f, 2.6f, -1.9f, 2.3f, 2.4f, 0.07f);
    SCENE_STICK(s, 2.6f, -1.0f, 0.1f, 4.4f, 0.9f, 2.4f, 0.05f);
    SCENE_BOX(s, -0.6f, 2.2f, 0, -0.2f, 4.0f, 0.5f);
    SCENE_SPHERE(s, 4.3f, -0.4f, 0.5f, 0.5f);
}
