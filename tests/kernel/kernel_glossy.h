#pragma once
/* Random fields for the kernel of the filter of glossy lobes, made to meet every branch: lobes from
 * mirrors to the roughest, seen from ahead and at grazing angles, several objects, pixels without a
 * lobe, steps off the plane, views from near to nothing met. */
#include <math.h>

#include "server/reconstruct/glossy/glossy_kernels.h"
#include "tests/kernel/kernel_field.h"

/* Each shape along x and along y. */
enum { GLOSSY_KERNEL_COUNT = 2 * GLOSSY_SHAPES };

static const char *const glossy_kernel_names[GLOSSY_KERNEL_COUNT] = {
    "spread x", "spread y", "round x", "round y", "mixed x", "mixed y"};

#define GLOSSY_CASE_REACH    13 /* 16 samples, 512 lines */
#define GLOSSY_CASE_MARGIN   32
#define GLOSSY_CASE_CHANNELS 4
#define GLOSSY_CASE_ARRAYS   26

struct glossy_case {
    struct glossy_field field; /* everything in it owned */
    struct glossy_rule rule;
    float *
        array[GLOSSY_CASE_ARRAYS]; /* vectors, sharpness, nearness, plane, channels, rules, round */
    int32_t *object;
    int32_t width, height; /* without the margin to both sides */
    size_t area;
};

/* A lobe around the mirrored direction of a view along v = (0.6, 0, 0.8) or straight down. */
static inline void glossy_case_lobe(struct random *r, bool wild, size_t i, struct glossy_case *out)
{
    const float bend = wild ? 0.3f : 0.02f, wide = wild ? field_between(r, 0.003f, 1.3f) : 0.06f;
    float n[3] = {field_between(r, -bend, bend), field_between(r, -bend, bend), 1.0f};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + 1.0f);
    const float v[3] = {wild ? 0.96f : 0.6f, 0.0f, wild ? 0.28f : 0.8f};
    float t[3], squared = 0.0f;
    for (int k = 0; k < 3; k++) n[k] /= length;
    const float c = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    for (int k = 0; k < 3; k++) t[k] = v[k] - c * n[k], squared += t[k] * t[k];
    const float sine = sqrtf(squared);
    for (int k = 0; k < 3; k++) t[k] /= sine;
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        out->array[3 + k][i] = n[k];
        out->array[6 + k][i] = 2.0f * c * n[k] - v[k];
        out->array[9 + k][i] = wide * (sine * n[k] + c * t[k]);
        out->array[12 + k][i] = wide * c * (n[a] * t[b] - n[b] * t[a]);
    }
    out->array[15][i] = 0.5f * logf(wide * wide * c);
    out->array[25][i] = wide * wide * c;
}

static inline void glossy_case_pixel(struct random *r, bool wild, int32_t x, int32_t y, size_t i,
                                     struct glossy_case *out)
{
    out->array[0][i] = 0.01f * (float)x;
    out->array[1][i] = 0.01f * (float)y;
    out->array[2][i] = field_between(r, 0.0f, wild ? 0.01f : 0.001f);
    if (wild && field_once_in(r, 40)) out->array[2][i] += 1.0f;
    glossy_case_lobe(r, wild, i, out);
    out->array[16][i] = wild && field_once_in(r, 5) ? 0.0f : field_between(r, 0.1f, 3.0f);
    if (wild && field_once_in(r, 30)) out->array[16][i] = 1e15f;
    out->array[17][i] = 0.02f;
    out->object[i] = wild ? (x / 7 + y / 5) % 4 : 1;
    for (int c = 0; c < GLOSSY_CASE_CHANNELS; c++)
        out->array[18 + c][i] = wild && field_once_in(r, 30) ? 1e12f : field_between(r, 0.0f, 2.0f);
    out->array[22][i] = field_between(r, 2.0f, 40.0f);
    out->array[23][i] = field_between(r, 0.02f, 0.3f);
    out->array[24][i] = field_between(r, 0.5f, 4.0f);
}

static inline void glossy_case_show(struct glossy_case *out, int32_t stride)
{
    float *const *a = out->array;
    out->field = (struct glossy_field){
        .stride = stride,
        .point = {a[0], a[1], a[2]},
        .normal = {a[3], a[4], a[5]},
        .mirror = {a[6], a[7], a[8]},
        .along = {a[9], a[10], a[11]},
        .across = {a[12], a[13], a[14]},
        .round = a[25],
        .sharpness = a[15],
        .nearness = a[16],
        .near_plane = a[17],
        .object = out->object,
    };
}

static inline void glossy_case_init(struct glossy_case *out, int32_t width, int32_t height,
                                    uint64_t seed, bool wild)
{
    struct random r = {seed};
    *out = (struct glossy_case){.width = width, .height = height};
    const int32_t stride =
        (width + 2 * GLOSSY_CASE_MARGIN + SIMD_LANES) / SIMD_LANES * SIMD_LANES + SIMD_LANES;
    out->area = (size_t)stride * (size_t)height;
    for (int k = 0; k < GLOSSY_CASE_ARRAYS; k++)
        out->array[k] = field_memory(out->area * sizeof(float));
    out->object = field_memory(out->area * sizeof *out->object);
    out->rule = (struct glossy_rule){.similarity = 11.3f,
                                     .distance = 0.02f,
                                     .footprint = wild ? 1.02f : 1e6f,
                                     .taper = wild ? 0.4f : 0.0f,
                                     .reach = GLOSSY_CASE_REACH};
    glossy_case_show(out, stride);
    if (seed % 2) { /* pixels' own rules */
        out->field.similarity = out->array[22];
        out->field.distance = out->array[23];
        out->field.footprint = out->array[24];
    }
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            glossy_case_pixel(&r, wild, x, y, (size_t)(y * stride + GLOSSY_CASE_MARGIN + x), out);
}

static inline void glossy_case_fini(struct glossy_case *c)
{
    for (int k = 0; k < GLOSSY_CASE_ARRAYS; k++) free(c->array[k]);
    free(c->object);
}

static inline int32_t glossy_case_rows(int32_t there)
{
    return there < GLOSSY_CASE_REACH ? there : GLOSSY_CASE_REACH;
}

/* The kernel over all rows, from pixel `start` of each on, into `out`: as many arrays as there are
 * channels, one after the other. */
static inline void glossy_case_run(const struct glossy_case *k,
                                   const struct glossy_kernels *kernels, uint32_t kernel,
                                   int32_t start, float *out)
{
    const bool along_x = kernel % 2 == 0;
    const int32_t lanes = (k->width - start + SIMD_LANES - 1) / SIMD_LANES;
    float *to[GLOSSY_CASE_CHANNELS];
    for (int c = 0; c < GLOSSY_CASE_CHANNELS; c++) to[c] = out + (size_t)c * k->area;
    for (int32_t y = 0; y < k->height; y++) {
        const struct glossy_run run = {
            .first = (size_t)(y * k->field.stride + GLOSSY_CASE_MARGIN + start),
            .count = (uint32_t)(lanes * SIMD_LANES),
            .step = along_x ? 1 : k->field.stride,
            .before = along_x ? GLOSSY_CASE_REACH : glossy_case_rows(y),
            .after = along_x ? GLOSSY_CASE_REACH : glossy_case_rows(k->height - 1 - y),
        };
        kernels->spread[kernel / 2](&k->field, &k->rule, &run, GLOSSY_CASE_CHANNELS,
                                    (const float *const *)(k->array + 18), to);
    }
}

/* Greatest difference from the reference, over the greatest number. */
static inline float glossy_case_compare(const struct glossy_case *k,
                                        const struct glossy_kernels *tested, uint32_t kernel,
                                        int32_t start)
{
    const size_t size = GLOSSY_CASE_CHANNELS * k->area;
    float *a = field_memory(size * sizeof *a), *b = field_memory(size * sizeof *b);
    glossy_case_run(k, &glossy_kernels_reference, kernel, start, a);
    glossy_case_run(k, tested, kernel, start, b);
    const float difference = field_difference(a, b, size);
    free(a);
    free(b);
    return difference;
}
