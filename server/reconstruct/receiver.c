#include "server/reconstruct/receiver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PLANE_LEAST_PX   2.0f
#define DISTANCE_MOST_PX 120.0f
#define GRAZING          0.02f /* least cosine towards the light that directions are taken at */
#define GAMMA_MOST       0.95f /* a half-side */
#define FRONT_LEAST      1e-4f /* of distance and size; nearer the light's plane u means nothing */
#define STEP_MOST        1e30f
#define ROW_PIXELS       64

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float clamp(float v, float least, float most)
{
    return v < least ? least : v > most ? most : v;
}

void receiver_light_init(struct receiver_light *light, const struct plan *plan, uint32_t index)
{
    const struct plan_light *p = &plan->lights[index];
    struct shadow_rectangle *r = &light->rectangle;
    light->plan = plan;
    light->index = index;
    light->strata = p->strata_per_axis;
    surface_view_init(&light->view, plan);
    r->profile = p->profile;
    for (int i = 0; i < 2; i++) {
        const float *half = i == 0 ? p->half_u : p->half_v;
        const double x = (double)half[0], y = (double)half[1], z = (double)half[2];
        const double length = sqrt(x * x + y * y + z * z); /* not 0: plan_check.h */
        for (int k = 0; k < 3; k++) r->axis[i][k] = (float)((double)half[k] / length);
        r->half[i] = (float)length;
        light->sigma_y[i] = r->half[i] * (p->profile == PROFILE_GAUSSIAN ? 0.5f : 0.577350269f);
    }
    for (int k = 0; k < 3; k++) {
        r->centre[k] = (float)((double)p->position[k] - (double)plan->camera.eye[k]);
        r->normal[k] = p->direction[k];
    }
    r->area = 4.0f * r->half[0] * r->half[1];
}

void receiver_row(const struct receiver_light *light, const struct patch *patch, int32_t x,
                  int32_t y, uint32_t count, float *const point[3], float *const normal[3])
{
    const size_t width = (size_t)rect_width(patch->rect);
    const size_t first = (size_t)(y - patch->rect.y0) * width + (size_t)(x - patch->rect.x0);
    const float *depth = patch->depth + first;
    surface_points(&light->view, x, y, count, depth, point[0], point[1], point[2]);
    for (int k = 0; k < 3; k++) {
        const float *in = patch->normal[k] + first;
        for (uint32_t i = 0; i < count; i++) normal[k][i] = depth[i] > 0.0f ? in[i] : 0.0f;
    }
}

/* How many pixels the pixel at `point` moves on the screen as it moves along t. */
static void screen_step(const struct surface_view *view, const float point[3], const float t[3],
                        float step[2])
{
    const struct plan_camera *c = view->camera;
    const float along = dot(t, c->forward), inverse = 1.0f / dot(point, c->forward);
    const float moved[2] = {dot(t, c->right), dot(t, c->up)};
    const float at[2] = {dot(point, c->right), dot(point, c->up)};
    const float steps[2] = {view->a_step, view->b_step};
    for (int k = 0; k < 2; k++) {
        /* the point is in front of the eye: it has a depth */
        const float perspective = (moved[k] - at[k] * inverse * along) * inverse;
        const float e = (view->orthographic ? moved[k] : perspective) / steps[k];
        step[k] = fabsf(e) < STEP_MOST ? e : 0.0f;
    }
}

void receiver_steps(const struct receiver_light *light, const struct shadow_source *s,
                    float steps[2][2])
{
    const struct shadow_rectangle *r = &light->rectangle;
    float to[3];
    for (int k = 0; k < 3; k++) to[k] = r->centre[k] - s->point[k];
    const float up = dot(to, s->normal), least = GRAZING * sqrtf(dot(to, to));
    const float guarded = fabsf(up) >= least ? up : up < 0.0f ? -least : least;
    for (int i = 0; i < 2; i++) {
        const float *a = r->axis[i];
        const float lambda = dot(s->normal, a) / guarded; /* lit: not in the light's centre */
        float tangent[3];
        for (int k = 0; k < 3; k++) tangent[k] = a[k] - lambda * to[k];
        screen_step(&light->view, s->point, tangent, steps[i]);
    }
}

/* One lit pixel: what it is to its neighbours, and they to it. */
static void place_receiver(const struct receiver_light *light, float depth, struct shadow_source *s,
                           struct shadow_target *t)
{
    const struct shadow_rectangle *r = &light->rectangle;
    const float pixel = surface_pixel_size(&light->view, depth);
    float to[3];
    for (int k = 0; k < 3; k++) to[k] = r->centre[k] - s->point[k];
    /* Lit: neither is 0. */
    const float front = -dot(to, r->normal), inverse_front = 1.0f / front;
    const float inverse = 1.0f / sqrtf(dot(to, to)), up = dot(to, s->normal) * inverse;
    const float inverse_up = up > GRAZING ? inverse / up : 0.0f;
    t->distance = front;
    t->plane_least = PLANE_LEAST_PX * pixel;
    t->distance_most2 = DISTANCE_MOST_PX * pixel * DISTANCE_MOST_PX * pixel;
    for (int i = 0; i < 2; i++) {
        const float facing = dot(s->normal, r->axis[i]), aside = dot(to, r->axis[i]);
        const float gamma = facing * inverse_up - 4.0f * (aside * inverse) * inverse;
        s->u[i] = -aside * inverse_front;
        t->gamma[i] = clamp(gamma * r->half[i], -GAMMA_MOST, GAMMA_MOST);
    }
}

/* Can any of the light reach it, and from far enough off the light's plane? */
static bool is_lit(const struct shadow_rectangle *r, const float point[3], const float normal[3])
{
    const float to[3] = {r->centre[0] - point[0], r->centre[1] - point[1], r->centre[2] - point[2]};
    const float size = r->half[0] + r->half[1], distance = sqrtf(dot(to, to));
    const float rise =
        r->half[0] * fabsf(dot(r->axis[0], normal)) + r->half[1] * fabsf(dot(r->axis[1], normal));
    const float front = -dot(to, r->normal);
    return dot(to, normal) + rise > 0.0f && front > FRONT_LEAST * (size + distance);
}

static void place_run(const struct receiver_light *light, const struct patch *patch, int32_t x,
                      int32_t y, uint32_t count, struct receivers *out)
{
    float point[3][ROW_PIXELS], normal[3][ROW_PIXELS];
    float *const points[3] = {point[0], point[1], point[2]};
    float *const normals[3] = {normal[0], normal[1], normal[2]};
    const size_t width = (size_t)rect_width(patch->rect);
    const size_t at = (size_t)(y - patch->rect.y0) * width + (size_t)(x - patch->rect.x0);
    const size_t to =
        (size_t)(y - out->rect.y0) * (size_t)rect_width(out->rect) + (size_t)(x - out->rect.x0);
    receiver_row(light, patch, x, y, count, points, normals);
    for (uint32_t i = 0; i < count; i++) {
        struct shadow_source *s = &out->sources[to + i];
        for (int k = 0; k < 3; k++) {
            s->point[k] = point[k][i];
            s->normal[k] = normal[k][i];
        }
        if (is_lit(&light->rectangle, s->point, s->normal))
            place_receiver(light, patch->depth[at + i], s, &out->targets[to + i]);
        else
            memset(s->normal, 0, sizeof s->normal);
    }
}

int receivers_create(const struct receiver_light *light, const struct patch *patch,
                     struct rect rect, struct receivers *out)
{
    const size_t area = (size_t)rect_area(rect);
    *out = (struct receivers){.rect = rect};
    out->memory = aligned_alloc(64, area * (sizeof *out->sources + sizeof *out->targets));
    if (!out->memory) return ERR_MEMORY;
    out->sources = out->memory;
    out->targets = (struct shadow_target *)(out->sources + area);
    memset(out->targets, 0, area * sizeof *out->targets);
    static const struct shadow_source nothing = {.spread = SHADOW_NO_SPREAD, .slot = -1};
    for (size_t i = 0; i < area; i++) out->sources[i] = nothing;
    const struct rect seen = rect_intersect(rect, patch->rect);
    for (int32_t y = seen.y0; y < seen.y1; y++) {
        for (int32_t x = seen.x0; x < seen.x1; x += ROW_PIXELS) {
            const int32_t left = seen.x1 - x;
            place_run(light, patch, x, y, (uint32_t)(left < ROW_PIXELS ? left : ROW_PIXELS), out);
        }
    }
    return 0;
}

void receivers_fini(struct receivers *receivers)
{
    free(receivers->memory);
    *receivers = (struct receivers){0};
}
