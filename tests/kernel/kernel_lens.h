#pragma once
/* Random samples and cells for the kernels of the filter of lens samples: looking at a layer
 * through apertures whose edge taps lie on, and placing samples, in the layer or beyond it, in
 * cells of any size. */
#include "server/reconstruct/lens/lens_kernels.h"
#include "tests/kernel/kernel_field.h"

enum lens_kernel {
    LENS_GATHER,
    LENS_ADD,
    LENS_ADD_BEYOND,
    LENS_ADD_FIXED,
    LENS_ADD_FIXED_BEYOND,
    LENS_KERNEL_COUNT
};

static const char *const lens_kernel_names[LENS_KERNEL_COUNT] = {
    "lens look", "lens add", "lens add beyond", "lens add fixed", "lens fixed, far"};

#define LENS_CASE_TAPS   113 /* a disc of six cells' radius */
#define LENS_CASE_MARGIN 16
#define LENS_CASE_ARRAYS 10

struct lens_case {
    struct lens_gather gather;
    struct lens_tap taps[LENS_CASE_TAPS];
    struct lens_splat splat;
    float *plane[LENS_CELL_PLANES], *array[LENS_CASE_ARRAYS]; /* owned */
    int32_t width, height, stride;                            /* width: without the margins */
    size_t area;
};

static inline void lens_case_taps(struct random *r, struct lens_case *out)
{
    for (int t = 0; t < LENS_CASE_TAPS; t++) {
        out->taps[t].at = (t / 12 - 5) * out->stride + t % 12 - 6;
        out->taps[t].distance = field_between(r, 0.0f, 6.0f);
    }
    out->gather = (struct lens_gather){
        .taps = out->taps, .inner = {20, 29, 70, 100}, .end = {29, 57, 85, LENS_CASE_TAPS}};
    for (int k = 0; k < LENS_CELL_PLANES; k++) out->gather.plane[k] = out->plane[k];
}

static inline void lens_case_place(int32_t level, struct lens_case *out)
{
    float *const *a = out->array;
    out->splat = (struct lens_splat){
        .slope = a[0],
        .along = a[1],
        .left = a[2],
        .chord = a[3],
        .height = a[4],
        .pass = a[5],
        .known = a[6],
        .light = {a[7], a[8], a[9]},
        .stratum = 1.0f,
        .strata_inverse = 1.0f / 3.0f,
        .x = 1000,
        .row_phase = level > 0 ? 1.0f : 0.0f,
        .fine = level < 0 ? -level : 0,
        .coarse = level > 0 ? level : 0,
        .cells = level < 0 ? (float)(1 << -level) : 1.0f / (float)(1 << level),
        .low = 3.0f,
        .close = 2.25f,
        .high = 8.0f,
        .column = level < 0 ? 1005 << -level : 1005 >> level,
        .row = -5,
        .columns = level < 0 ? out->width << -level : out->width,
        .rows = 9,
        .stride = out->stride << 2,
        .phase_step = out->stride,
        .spare = 9 * (out->stride << 2),
    };
}

/* level: of cells, as lens_cell_level has them. */
static inline void lens_case_init(struct lens_case *out, int32_t width, int32_t height,
                                  uint64_t seed, int32_t level)
{
    static const float low[] = {-12, 0, -1, 0, -1, -4, -1, 0, 0, 0};
    static const float high[] = {12, 1, 0, 2, 1, 4, 1, 1, 1, 1};
    struct random r = {seed};
    *out = (struct lens_case){.width = width, .height = height};
    out->stride = (width + 2 * LENS_CASE_MARGIN + SIMD_LANES) / SIMD_LANES * SIMD_LANES;
    out->area = (size_t)out->stride * (size_t)(height + LENS_CASE_MARGIN);
    for (int k = 0; k < LENS_CELL_PLANES; k++) {
        out->plane[k] = field_memory(out->area * sizeof(float));
        for (size_t i = 0; i < out->area; i++)
            out->plane[k][i] = field_between(&r, 0.0f, k == LENS_CELL_REACH ? 6.0f : 1.0f);
    }
    for (int k = 0; k < LENS_CASE_ARRAYS; k++) {
        out->array[k] = field_memory(out->area * sizeof(float));
        for (size_t i = 0; i < out->area; i++)
            out->array[k][i] = field_between(&r, low[k], high[k]);
    }
    lens_case_taps(&r, out);
    lens_case_place(level, out);
}

static inline void lens_case_fini(struct lens_case *c)
{
    for (int k = 0; k < LENS_CELL_PLANES; k++) free(c->plane[k]);
    for (int k = 0; k < LENS_CASE_ARRAYS; k++) free(c->array[k]);
}

/* What lens_case_run writes, and cells that take anything. */
static inline size_t lens_case_size(const struct lens_case *k, enum lens_kernel kernel)
{
    return kernel == LENS_GATHER ? LENS_GROUPS * LENS_SUMS * k->area
                                 : LENS_CELL_SUMS * (size_t)(k->splat.spare + SIMD_LANES);
}

static inline void lens_case_run(const struct lens_case *k, const struct lens_kernels *kernels,
                                 enum lens_kernel kernel, float *out)
{
    const uint32_t lanes = (uint32_t)(k->width / SIMD_LANES * SIMD_LANES);
    struct lens_splat splat = k->splat;
    splat.beyond = kernel == LENS_ADD_BEYOND || kernel == LENS_ADD_FIXED_BEYOND;
    splat.fixed = kernel == LENS_ADD_FIXED || kernel == LENS_ADD_FIXED_BEYOND;
    if (kernel != LENS_GATHER) memset(out, 0, lens_case_size(k, kernel) * sizeof *out);
    for (int32_t y = 0; y < k->height; y++) {
        const size_t row = (size_t)(y * k->stride);
        const float **const arrays[] = {
            &splat.slope, &splat.along, &splat.left,     &splat.chord,    &splat.height,
            &splat.pass,  &splat.known, &splat.light[0], &splat.light[1], &splat.light[2]};
        if (kernel == LENS_GATHER) {
            kernels->gather(&k->gather, row + 8 * (size_t)k->stride + LENS_CASE_MARGIN, lanes,
                            out + row, k->area);
            continue;
        }
        for (int i = 0; i < LENS_CASE_ARRAYS; i++) *arrays[i] = k->array[i] + row;
        kernels->add(&splat, (uint32_t)k->width, out);
    }
}

/* Greatest difference from the reference; cells are the same or they are not. */
static inline float lens_case_compare(const struct lens_case *k, const struct lens_kernels *tested,
                                      enum lens_kernel kernel)
{
    const size_t size = lens_case_size(k, kernel);
    const size_t cells = LENS_CELL_SUMS * (size_t)k->splat.spare;
    float *a = field_memory(size * sizeof *a), *b = field_memory(size * sizeof *b);
    lens_case_run(k, &lens_kernels_sse42, kernel, a);
    lens_case_run(k, tested, kernel, b);
    const float difference = kernel == LENS_GATHER             ? field_difference(a, b, size)
                             : memcmp(a, b, cells * sizeof *a) ? INFINITY
                                                               : 0.0f;
    free(a);
    free(b);
    return difference;
}
