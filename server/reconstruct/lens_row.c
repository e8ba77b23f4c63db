#include "server/reconstruct/lens_row.h"

#include <math.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "proto/samples.h"

#define FLOATS 15
#define SEEDS  (sizeof(struct path_seeds) / sizeof(float))

int lens_row_create(const struct plan *plan, const struct patch *patch, size_t width,
                    struct lens_row *out)
{
    *out = (struct lens_row){.plan = plan, .patch = patch, .kernels = lens_kernels_best()};
    float *at = out->memory =
        scratch_take(patch->scratch, (FLOATS + SEEDS) * width * sizeof(float));
    float **const arrays[FLOATS] = {
        &out->along,    &out->across,   &out->height,    &out->left,      &out->length,
        &out->at[0],    &out->at[1],    &out->z,         &out->distance,  &out->point[0],
        &out->point[1], &out->point[2], &out->normal[0], &out->normal[1], &out->normal[2]};
    if (!at) return ERR_MEMORY;
    for (size_t k = 0; k < FLOATS; k++) *arrays[k] = at + k * width;
    out->seeds = (struct path_seeds *)(void *)(at + FLOATS * width);
    surface_view_init(&out->view, plan);
    lens_pattern_init(&out->pattern, plan);
    return 0;
}

void lens_row_fini(struct lens_row *r)
{
    scratch_give(r->patch->scratch, r->memory);
}

void lens_row_begin(struct lens_row *r, int32_t x, int32_t y, uint32_t count)
{
    const struct pattern *p = &r->plan->pattern;
    r->x = x;
    r->y = y;
    r->count = count;
    lens_pattern_jitters(&r->pattern, x, y, count, r->along, r->across);
    for (uint32_t i = 0; i < count; i++)
        r->seeds[i] = path_seeds_of(path_key(p->seed, p->frame, x + (int32_t)i, y), PATH_PIXEL);
}

void lens_row_line(struct lens_row *r, uint32_t i)
{
    const struct lens_aperture *aperture = &r->pattern.aperture;
    r->line = i;
    if (aperture->bands == 0)
        r->kernels->lines(r->pattern.l, i, r->count, r->across, r->height, r->left, r->length);
    else
        lens_aperture_lines(aperture, r->pattern.l, i, r->count, r->across, r->height, r->left,
                            r->length);
}

/* A sample of pixel position p at lens position u shows what the middle sees at p + slope u. */
static void place_in_picture(const struct lens_row *r, uint32_t k, const float *restrict slope,
                             uint32_t begin, uint32_t end)
{
    const uint32_t l = r->pattern.l, sample = r->line * l + k;
    const struct path_seeds *restrict seeds = r->seeds;
    const float *restrict along = r->along, *restrict height = r->height;
    const float *restrict left = r->left, *restrict length = r->length;
    float *restrict x = r->at[0], *restrict y = r->at[1];
    for (uint32_t i = begin; i < end; i++) {
        float across, down;
        path_seeded_pair(seeds[i], sample, &across, &down);
        x[i] = (float)(r->x + (int32_t)i) + across +
               slope[i] * (left[i] + length[i] * pattern_axis(along[i], l, k));
        y[i] = (float)r->y + down + slope[i] * height[i];
    }
}

static void place_in_world(const struct lens_row *r, uint32_t begin, uint32_t end)
{
    const struct surface_view v = r->view;
    const float *right = v.camera->right, *up = v.camera->up, *forward = v.camera->forward;
    const float *restrict x = r->at[0], *restrict y = r->at[1];
    float *restrict z = r->z, *restrict distance = r->distance;
    float *restrict px = r->point[0], *restrict py = r->point[1], *restrict pz = r->point[2];
    const float unit = r->plan->length_unit;
    for (uint32_t i = begin; i < end; i++) {
        const float a = v.a_start + v.a_step * x[i], b = v.b_start + v.b_step * y[i];
        z[i] *= unit;
        px[i] = z[i] * (a * right[0] + b * up[0] + forward[0]);
        py[i] = z[i] * (a * right[1] + b * up[1] + forward[1]);
        pz[i] = z[i] * (a * right[2] + b * up[2] + forward[2]);
        distance[i] = z[i] * sqrtf(1.0f + a * a + b * b);
    }
}

void lens_row_place(struct lens_row *r, uint32_t k, uint32_t begin, uint32_t end)
{
    const struct patch *p = r->patch;
    const size_t at =
        (r->line * r->pattern.l + k) * (size_t)rect_area(p->rect) + patch_pixel(p, r->x, r->y);
    half_to_floats(p->lens_depth + at + begin, r->z + begin, end - begin);
    place_in_picture(r, k, p->lens_slope + at, begin, end);
    place_in_world(r, begin, end);
    octahedron_unpack8_row(p->lens_normal + at + begin, end - begin, r->normal[0] + begin,
                           r->normal[1] + begin, r->normal[2] + begin);
}
