#include "server/reconstruct/shadow/receiver.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/receiver_lanes.h"

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
        const double length = sqrt(x * x + y * y + z * z); /* not 0: plan_check */
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

void receiver_sunk(const struct receiver_light *light, const float *const point[3],
                   const float *const normal[3], uint32_t count, float *sunk)
{
    const struct shadow_rectangle *r = &light->rectangle;
    const float *a = r->axis[0], *b = r->axis[1], *c = r->centre;
    for (uint32_t i = 0; i < count; i++) {
        const float nx = normal[0][i], ny = normal[1][i], nz = normal[2][i];
        const float up = receiver_along(c[0] - point[0][i], c[1] - point[1][i], c[2] - point[2][i],
                                        (float[]){nx, ny, nz});
        const float rise = r->half[0] * fabsf(receiver_along(nx, ny, nz, a)) +
                           r->half[1] * fabsf(receiver_along(nx, ny, nz, b));
        const float share = 0.5f * (rise - up) / (rise > 0.0f ? rise : 1.0f);
        sunk[i] = clamp(share, 0.0f, 1.0f);
    }
}

void receiver_steps(const struct receiver_light *light, const struct shadow_pixels *pixels,
                    size_t i, float steps[2][2])
{
    float p[3], n[3];
    for (int k = 0; k < 3; k++) {
        p[k] = pixels->point[k][i];
        n[k] = pixels->normal[k][i];
    }
    for (int axis = 0; axis < 2; axis++) {
        const struct receiver_stepper stepper = receiver_stepper_of(light, axis);
        const struct receiver_aim aim = receiver_aim(&stepper, p[0], p[1], p[2], n[0], n[1], n[2]);
        receiver_step(&stepper, &aim, n[0], n[1], n[2], &steps[axis][0], &steps[axis][1]);
    }
}

/* -- memory: first what is found of every pixel, then what only those with a wedge or a slot have
 */

#define PLACED  13
#define SHEARED 9
#define WHOLE   6

/* The planes one after the other, `stride` numbers each: points first of what is placed, eta first
 * of what is sheared, which is where `clear` and `place_nothing` count from. */
static void lay_out(struct shadow_pixels *p, float *memory, size_t stride)
{
    struct shadow_walk *a = &p->walk[0], *b = &p->walk[1];
    float **const numbers[] = {
        &p->point[0], &p->point[1], &p->point[2], &p->normal[0], &p->normal[1],      &p->normal[2],
        &p->u[0],     &p->u[1],     &p->distance, &p->plane_min, &p->distance_most2, &p->gamma[0],
        &p->gamma[1], &p->eta,      &p->spread,   &a->step[0],   &a->step[1],        &a->falloff,
        &b->step[0],  &b->step[1],  &b->falloff,  &p->width_px};
    int32_t **const whole[] = {&p->slot,       &p->phase, &p->weights[0],
                               &p->weights[1], &a->reach, &b->reach};
    _Static_assert(sizeof numbers == (PLACED + SHEARED) * sizeof *numbers, "a plane each");
    _Static_assert(sizeof whole == WHOLE * sizeof *whole, "a plane each");
    for (size_t k = 0; k < PLACED + SHEARED; k++, memory += stride) *numbers[k] = memory;
    for (size_t k = 0; k < WHOLE; k++, memory += stride) *whole[k] = (int32_t *)(void *)memory;
}

static void fill_float(float *plane, size_t count, float number)
{
    for (size_t i = 0; i < count; i++) plane[i] = number;
}

static void fill_whole(int32_t *plane, size_t count, int32_t number)
{
    for (size_t i = 0; i < count; i++) plane[i] = number;
}

/* No pixel has a wedge or a slot yet, and nothing is shown past the end. */
static void clear(struct shadow_pixels *p, size_t area, size_t stride)
{
    for (size_t k = 0; k < PLACED; k++)
        memset(p->point[0] + k * stride + area, 0, (stride - area) * sizeof *p->point[0]);
    memset(p->eta, 0, (SHEARED + WHOLE) * stride * sizeof *p->eta);
    fill_float(p->spread, stride, SHADOW_NO_SPREAD);
    fill_whole(p->slot, stride, -1);
    for (int k = 0; k < 2; k++) fill_whole(p->weights[k], stride, COVERAGE_WIDEST);
}

/* -- what is found of every pixel */

static void place_run(const struct receiver_light *light, const struct patch *patch,
                      const struct shadow_kernels *kernels, int32_t x, int32_t y, uint32_t count,
                      const struct receivers *out)
{
    const struct shadow_pixels *p = &out->pixels;
    const size_t at = patch_pixel(patch, x, y), to = receivers_pixel(out, x, y);
    float *const points[3] = {p->point[0] + to, p->point[1] + to, p->point[2] + to};
    float *const normals[3] = {p->normal[0] + to, p->normal[1] + to, p->normal[2] + to};
    receiver_row(light, patch, x, y, count, points, normals);
    kernels->place_receivers(light, count, patch->depth + at, to, p);
}

/* `count` pixels from `first` on. */
static void place_nothing(const struct shadow_pixels *p, size_t stride, size_t first, int32_t count)
{
    for (size_t k = 0; count > 0 && k < PLACED; k++)
        memset(p->point[0] + k * stride + first, 0, (size_t)count * sizeof *p->point[0]);
}

int receivers_create(const struct receiver_light *light, const struct patch *patch,
                     const struct shadow_kernels *kernels, struct rect rect, struct receivers *out)
{
    const size_t area = (size_t)rect_area(rect);
    const size_t stride = (area + 2 * SHADOW_PLANE_PAD - 1) / SHADOW_PLANE_PAD * SHADOW_PLANE_PAD;
    *out = (struct receivers){.rect = rect, .scratch = patch->scratch};
    out->memory = scratch_take(out->scratch, (PLACED + SHEARED + WHOLE) * stride * sizeof(float));
    if (!out->memory) return ERR_MEMORY;
    lay_out(&out->pixels, out->memory, stride);
    clear(&out->pixels, area, stride);
    const struct rect seen = rect_intersect(rect, patch->rect);
    const bool none = rect_is_empty(seen);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t row = receivers_pixel(out, rect.x0, y);
        const bool dark = none || y < seen.y0 || y >= seen.y1;
        const int32_t x0 = dark ? rect.x1 : seen.x0, x1 = dark ? rect.x1 : seen.x1;
        place_nothing(&out->pixels, stride, row, x0 - rect.x0);
        for (int32_t x = x0; x < x1; x += ROW_PIXELS) {
            const int32_t left = x1 - x;
            const uint32_t count = (uint32_t)(left < ROW_PIXELS ? left : ROW_PIXELS);
            place_run(light, patch, kernels, x, y, count, out);
        }
        place_nothing(&out->pixels, stride, row + (size_t)(x1 - rect.x0), rect.x1 - x1);
    }
    return 0;
}

void receivers_fini(struct receivers *receivers)
{
    scratch_give(receivers->scratch, receivers->memory);
    *receivers = (struct receivers){0};
}
