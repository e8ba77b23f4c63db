#include "server/reconstruct/receiver.h"

#include <math.h>

#include "server/reconstruct/receiver_lanes.h"

#define ROW_PIXELS 64

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
    const size_t first = patch_pixel(patch, x, y);
    const float *depth = patch->depth + first;
    surface_points(&light->view, x, y, count, depth, point[0], point[1], point[2]);
    for (int k = 0; k < 3; k++) {
        const float *in = patch->normal[k] + first;
        for (uint32_t i = 0; i < count; i++) normal[k][i] = depth[i] > 0.0f ? in[i] : 0.0f;
    }
}

void receiver_steps(const struct receiver_light *light, const struct shadow_source *s,
                    float steps[2][2])
{
    const float *p = s->point, *n = s->normal;
    for (int i = 0; i < 2; i++) {
        const struct receiver_stepper stepper = receiver_stepper_of(light, i);
        receiver_step(&stepper, p[0], p[1], p[2], n[0], n[1], n[2], &steps[i][0], &steps[i][1]);
    }
}

static void place_run(const struct receiver_light *light, const struct patch *patch,
                      const struct shadow_kernels *kernels, int32_t x, int32_t y, uint32_t count,
                      struct receivers *out)
{
    float point[3][ROW_PIXELS], normal[3][ROW_PIXELS];
    float *const points[3] = {point[0], point[1], point[2]};
    float *const normals[3] = {normal[0], normal[1], normal[2]};
    const float *const p[3] = {point[0], point[1], point[2]};
    const float *const n[3] = {normal[0], normal[1], normal[2]};
    const size_t at = patch_pixel(patch, x, y), to = receivers_pixel(out, x, y);
    receiver_row(light, patch, x, y, count, points, normals);
    kernels->place_receivers(light, count, patch->depth + at, p, n, out->sources + to,
                             out->targets + to);
}

/* Pixels `from` to `to` of row y. */
static void place_nothing(struct receivers *out, int32_t from, int32_t to, int32_t y)
{
    static const struct shadow_source source = RECEIVER_NO_SOURCE;
    static const struct shadow_target target = RECEIVER_NO_TARGET;
    const size_t row = (size_t)(y - out->rect.y0) * (size_t)rect_width(out->rect);
    for (int32_t x = from; x < to; x++) {
        out->sources[row + (size_t)(x - out->rect.x0)] = source;
        out->targets[row + (size_t)(x - out->rect.x0)] = target;
    }
}

int receivers_create(const struct receiver_light *light, const struct patch *patch,
                     const struct shadow_kernels *kernels, struct rect rect, struct receivers *out)
{
    const size_t area = (size_t)rect_area(rect);
    *out = (struct receivers){.rect = rect, .scratch = patch->scratch};
    out->memory = scratch_take(out->scratch, area * (sizeof *out->sources + sizeof *out->targets));
    if (!out->memory) return ERR_MEMORY;
    out->sources = out->memory;
    out->targets = (struct shadow_target *)(out->sources + area);
    const struct rect seen = rect_intersect(rect, patch->rect);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        if (rect_is_empty(seen) || y < seen.y0 || y >= seen.y1) {
            place_nothing(out, rect.x0, rect.x1, y);
            continue;
        }
        place_nothing(out, rect.x0, seen.x0, y);
        for (int32_t x = seen.x0; x < seen.x1; x += ROW_PIXELS) {
            const int32_t left = seen.x1 - x;
            const uint32_t count = (uint32_t)(left < ROW_PIXELS ? left : ROW_PIXELS);
            place_run(light, patch, kernels, x, y, count, out);
        }
        place_nothing(out, seen.x1, rect.x1, y);
    }
    return 0;
}

void receivers_fini(struct receivers *receivers)
{
    scratch_give(receivers->scratch, receivers->memory);
    *receivers = (struct receivers){0};
}
