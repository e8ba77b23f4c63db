#pragma once
/* Random fields for the kernels of the filters of indirect light, made to meet every branch:
 * surfaces that end, bend and belong to several objects, pixels where nothing was measured, widths
 * from none to wider than the field. */
#include "server/reconstruct/indirect/indirect_kernels.h"
#include "tests/kernel/kernel_field.h"

enum indirect_kernel {
    INDIRECT_MEAN_X,
    INDIRECT_MEAN_Y,
    INDIRECT_LINE_X,
    INDIRECT_LINE_Y,
    INDIRECT_NEARNESS,
    INDIRECT_KERNEL_COUNT
};

static const char *const indirect_kernel_names[INDIRECT_KERNEL_COUNT] = {
    "mean x", "mean y", "line x", "line y", "nearness"};

#define INDIRECT_CASE_REACH    19 /* rule A, 16 samples, 512 lines */
#define INDIRECT_CASE_MARGIN   32
#define INDIRECT_CASE_CHANNELS 3

struct indirect_case {
    struct indirect_field field; /* everything in it owned */
    float *point[3], *normal[3], *falloff, *off, *nearness, *in[INDIRECT_CASE_CHANNELS];
    int32_t *object;
    int32_t width, height; /* without the margin to both sides */
    size_t area;
};

static inline void indirect_case_pixel(struct random *r, bool wild, int32_t x, int32_t y, size_t i,
                                       struct indirect_case *out)
{
    const float bend = wild ? 0.2f : 0.02f;
    float n[3] = {field_between(r, -bend, bend), field_between(r, -bend, bend), 1.0f};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + 1.0f);
    const bool measured = !wild || !field_once_in(r, 9);
    const float at[3] = {0.01f * (float)x, 0.01f * (float)y,
                         field_between(r, 0.0f, wild ? 0.01f : 0.001f)};
    for (int k = 0; k < 3; k++) {
        out->point[k][i] = at[k];
        out->normal[k][i] = measured ? n[k] / length : 0.0f;
    }
    if (wild && field_once_in(r, 40)) out->point[2][i] += 1.0f;
    out->object[i] = wild ? 1 + (x / 7 + y / 5) % 3 : 1;
    out->falloff[i] = wild ? field_between(r, 5.0f, 2000.0f) : 100.0f;
    if (wild && field_once_in(r, 20)) out->falloff[i] = 1e30f;
    if (wild && field_once_in(r, 20)) out->falloff[i] = 1e-3f;
    if (!measured) out->falloff[i] = 0.0f;
    out->off[i] = wild ? field_between(r, 0.0f, 0.02f) : 0.02f;
    out->nearness[i] = !measured || (wild && field_once_in(r, 5)) ? 0.0f : field_between(r, 1, 9);
    for (int c = 0; c < INDIRECT_CASE_CHANNELS; c++)
        out->in[c][i] = wild && field_once_in(r, 30) ? 1e12f : field_between(r, 0.0f, 2.0f);
}

static inline void indirect_case_init(struct indirect_case *out, int32_t width, int32_t height,
                                      uint64_t seed, bool wild)
{
    struct random r = {seed};
    *out = (struct indirect_case){.width = width, .height = height};
    const int32_t stride =
        (width + 2 * INDIRECT_CASE_MARGIN + SIMD_LANES) / SIMD_LANES * SIMD_LANES + SIMD_LANES;
    out->area = (size_t)stride * (size_t)height;
    float **const arrays[] = {&out->point[0],  &out->point[1],  &out->point[2], &out->normal[0],
                              &out->normal[1], &out->normal[2], &out->falloff,  &out->off,
                              &out->nearness,  &out->in[0],     &out->in[1],    &out->in[2]};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        *arrays[k] = field_memory(out->area * sizeof(float));
    out->object = field_memory(out->area * sizeof *out->object);
    out->field = (struct indirect_field){
        .stride = stride,
        .point = {out->point[0], out->point[1], out->point[2]},
        .normal = {out->normal[0], out->normal[1], out->normal[2]},
        .object = out->object,
        .falloff = out->falloff,
        .off = out->off,
    };
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            indirect_case_pixel(&r, wild, x, y, (size_t)(y * stride + INDIRECT_CASE_MARGIN + x),
                                out);
}

static inline void indirect_case_fini(struct indirect_case *c)
{
    void *const all[] = {c->point[0],  c->point[1], c->point[2], c->normal[0], c->normal[1],
                         c->normal[2], c->falloff,  c->off,      c->nearness,  c->in[0],
                         c->in[1],     c->in[2],    c->object};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

static inline int32_t indirect_case_rows(int32_t there, int32_t reach)
{
    return there < reach ? there : reach;
}

/* The kernel over all rows, from pixel `start` of each on, into `out`: as many arrays as there are
 * channels, one after the other. */
static inline void indirect_case_run(const struct indirect_case *k,
                                     const struct indirect_kernels *kernels,
                                     enum indirect_kernel kernel, int32_t start, float *out)
{
    const bool along_x = kernel == INDIRECT_MEAN_X || kernel == INDIRECT_LINE_X;
    const int32_t reach = kernel == INDIRECT_NEARNESS ? 2 : INDIRECT_CASE_REACH;
    const int32_t lanes = (k->width - start + SIMD_LANES - 1) / SIMD_LANES;
    const float *const in[INDIRECT_CASE_CHANNELS] = {k->in[0], k->in[1], k->in[2]};
    float *const to[INDIRECT_CASE_CHANNELS] = {out, out + k->area, out + 2 * k->area};
    for (int32_t y = 0; y < k->height; y++) {
        const struct indirect_run run = {
            .first = (size_t)(y * k->field.stride + INDIRECT_CASE_MARGIN + start),
            .count = (uint32_t)(lanes * SIMD_LANES),
            .step = along_x ? 1 : k->field.stride,
            .before = along_x ? reach : indirect_case_rows(y, reach),
            .after = along_x ? reach : indirect_case_rows(k->height - 1 - y, reach),
        };
        if (kernel == INDIRECT_NEARNESS)
            kernels->nearness(&k->field, &run, k->nearness, out);
        else if (kernel == INDIRECT_MEAN_X || kernel == INDIRECT_MEAN_Y)
            kernels->mean(&k->field, &run, INDIRECT_CASE_CHANNELS, in, to);
        else
            kernels->line(&k->field, &run, INDIRECT_CASE_CHANNELS, in, to);
    }
}

/* Greatest difference from the reference, over the greatest number. */
static inline float indirect_case_compare(const struct indirect_case *k,
                                          const struct indirect_kernels *tested,
                                          enum indirect_kernel kernel, int32_t start)
{
    const size_t size = INDIRECT_CASE_CHANNELS * k->area;
    float *a = field_memory(size * sizeof *a), *b = field_memory(size * sizeof *b);
    indirect_case_run(k, &indirect_kernels_reference, kernel, start, a);
    indirect_case_run(k, tested, kernel, start, b);
    const float difference = field_difference(a, b, size);
    free(a);
    free(b);
    return difference;
}
