#include "server/reconstruct/lighting/lens_row.h"

#include <string.h>

#include "proto/half.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"

#define FLOATS   16
#define WHOLES   5
#define ROUNDING 0.999f

static void carve(struct lens_row *r, float *at, size_t width)
{
    struct lens_relight_row *s = &r->samples;
    float **const floats[FLOATS] = {&r->along,    &r->across,    &r->height,    &r->left,
                                    &r->length,   &s->z,         &s->across,    &s->down,
                                    &s->distance, &s->off,       &s->point[0],  &s->point[1],
                                    &s->point[2], &s->normal[0], &s->normal[1], &s->normal[2]};
    for (size_t k = 0; k < FLOATS; k++) *floats[k] = at + k * width;
    r->order = (uint32_t *)(void *)(at + FLOATS * width);
    r->u = r->order + width;
    r->v = r->u + width;
    s->column = (int32_t *)(void *)(r->v + width);
    s->row = s->column + width;
    s->along = r->along;
    s->height = r->height;
    s->left = r->left;
    s->length = r->length;
    s->order = r->order;
    s->u = r->u;
    s->v = r->v;
}

static void look(const struct lens_row *r, struct rect around, struct lens_relight_row *s)
{
    const struct surface_view *v = &r->view;
    s->a_start = v->a_start;
    s->a_step = v->a_step;
    s->b_start = v->b_start;
    s->b_step = v->b_step;
    memcpy(s->right, v->camera->right, sizeof s->right);
    memcpy(s->up, v->camera->up, sizeof s->up);
    memcpy(s->forward, v->camera->forward, sizeof s->forward);
    s->unit = r->plan->length_unit;
    s->allowed = ROUNDING * SURFACE_PLANE_PX * v->pixel_size;
    s->x_low = (float)around.x0;
    s->x_high = (float)around.x1;
    s->y_low = (float)around.y0;
    s->y_high = (float)around.y1;
    s->l = r->pattern.l;
}

int lens_row_create(const struct plan *plan, const struct patch *patch, size_t width,
                    struct rect around, struct lens_row *out)
{
    *out = (struct lens_row){.plan = plan,
                             .patch = patch,
                             .lens = KERNELS_BEST(lens_kernels),
                             .kernels = KERNELS_BEST(lens_relight_kernels)};
    out->memory = scratch_take(patch->scratch, (FLOATS + WHOLES) * width * sizeof(float));
    if (!out->memory) return ERR_MEMORY;
    carve(out, out->memory, width);
    surface_view_init(&out->view, plan);
    lens_pattern_init(&out->pattern, plan);
    look(out, around, &out->samples);
    return 0;
}

void lens_row_fini(struct lens_row *r)
{
    if (r->memory) scratch_give(r->patch->scratch, r->memory);
}

void lens_row_begin(struct lens_row *r, int32_t x, int32_t y, uint32_t count)
{
    const struct pattern *p = &r->plan->pattern;
    uint32_t *restrict order = r->order, *restrict u = r->u, *restrict v = r->v;
    r->x = x;
    r->y = y;
    r->count = count;
    r->samples.x = (float)x;
    r->samples.y = (float)y;
    lens_pattern_jitters(&r->pattern, x, y, count, r->along, r->across);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t key = path_key(p->seed, p->frame, x + (int32_t)i, y);
        const struct path_seeds seeds = path_seeds_of(key, PATH_PIXEL);
        order[i] = seeds.order;
        u[i] = seeds.u;
        v[i] = seeds.v;
    }
}

void lens_row_line(struct lens_row *r, uint32_t i)
{
    r->line = i;
    r->lens->lines(&r->pattern.aperture, r->pattern.l, i, r->count, r->across, r->height, r->left,
                   r->length);
}

void lens_row_place(struct lens_row *r, uint32_t k, uint32_t begin, uint32_t end)
{
    const struct patch *p = r->patch;
    struct lens_relight_row *s = &r->samples;
    const uint32_t sample = r->line * r->pattern.l + k;
    const size_t at = sample * (size_t)rect_area(p->rect) + patch_pixel(p, r->x, r->y);
    s->k = k;
    s->sample = sample;
    s->slope = p->lens_slope + at;
    s->code = p->lens_normal + at;
    half_to_floats(p->lens_depth + at + begin, s->z + begin, end - begin);
    r->kernels->place(s, begin, end);
}
