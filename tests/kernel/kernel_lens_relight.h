#pragma once
/* Random lens samples for the kernels that light them: where the middle of the lens sees their
 * points, some of them outside of what it sees, what their paths have found, and what they send. */
#include "proto/shared_exponent.h"
#include "server/reconstruct/lighting/lens_relight_kernels.h"
#include "tests/kernel/kernel_field.h"

enum lens_relight_kernel {
    LIT_LENS_PLACE,
    LIT_LENS_OWN,
    LIT_LENS_ADD,
    LIT_LENS_MAX,
    LIT_LENS_KERNEL_COUNT
};

static const char *const lens_relight_kernel_names[LIT_LENS_KERNEL_COUNT] = {
    "light place", "light own", "light add", "light max"};

#define LENS_RELIGHT_NUMBERS 6  /* along, height, left, length, slope, z */
#define LENS_RELIGHT_WORDS   5  /* seeds of three kinds, albedo, light */
#define LENS_RELIGHT_PLANES  13 /* at most are written */

struct lens_relight_case {
    float *number[LENS_RELIGHT_NUMBERS]; /* owned */
    uint32_t *words[LENS_RELIGHT_WORDS]; /* owned */
    uint16_t *code;                      /* owned */
    uint32_t count;
};

static inline void lens_relight_case_init(struct lens_relight_case *out, uint32_t count,
                                          uint64_t seed)
{
    static const float low[] = {0.0f, -1.0f, -1.0f, 0.0f, -24.0f, 0.01f};
    static const float high[] = {1.0f, 1.0f, 0.0f, 1.0f, 24.0f, 9.0f};
    struct random r = {seed};
    *out = (struct lens_relight_case){.count = count};
    for (int k = 0; k < LENS_RELIGHT_NUMBERS; k++)
        out->number[k] = field_numbers(&r, count, low[k], high[k]);
    for (int k = 0; k < LENS_RELIGHT_WORDS; k++)
        out->words[k] = field_memory(count * sizeof *out->words[k]);
    out->code = field_memory(count * sizeof *out->code);
    for (uint32_t i = 0; i < count; i++) {
        float albedo[3], light[3];
        for (int k = 0; k < 3; k++) {
            out->words[k][i] = (uint32_t)random_bits(&r);
            albedo[k] = field_between(&r, 0.0f, 1.0f);
            light[k] = field_once_in(&r, 5) ? 0.0f : field_between(&r, 0.0f, 1e6f);
        }
        out->words[3][i] = shared_exponent_pack(albedo, SHARED_EXPONENT_9);
        out->words[4][i] = shared_exponent_pack(light, SHARED_EXPONENT_8);
        out->code[i] = (uint16_t)random_bits(&r);
    }
}

static inline void lens_relight_case_fini(struct lens_relight_case *c)
{
    for (int k = 0; k < LENS_RELIGHT_NUMBERS; k++) free(c->number[k]);
    for (int k = 0; k < LENS_RELIGHT_WORDS; k++) free(c->words[k]);
    free(c->code);
}

/* What lens_relight_case_run writes. */
static inline size_t lens_relight_case_size(const struct lens_relight_case *k)
{
    return LENS_RELIGHT_PLANES * (size_t)k->count;
}

static inline struct lens_relight_row lens_relight_case_row(const struct lens_relight_case *k,
                                                            float *out)
{
    const size_t n = k->count;
    memcpy(out + 12 * n, k->number[5], n * sizeof *out);
    return (struct lens_relight_row){
        .along = k->number[0],
        .height = k->number[1],
        .left = k->number[2],
        .length = k->number[3],
        .order = k->words[0],
        .u = k->words[1],
        .v = k->words[2],
        .x = 100.0f,
        .y = 7.0f,
        .l = 3,
        .k = 1,
        .sample = 4,
        .a_start = -0.5f,
        .a_step = 0.005f,
        .b_start = 0.5f,
        .b_step = -0.005f,
        .right = {1.0f, 0.0f, 0.0f},
        .up = {0.0f, 1.0f, 0.0f},
        .forward = {0.0f, 0.0f, -1.0f},
        .unit = 2.0f,
        .allowed = 0.0075f,
        .x_low = 104.0f,
        .x_high = 80.0f + (float)n,
        .y_low = -1.0f,
        .y_high = 20.0f,
        .slope = k->number[4],
        .code = k->code,
        .z = out + 12 * n,
        .column = (int32_t *)(void *)out,
        .row = (int32_t *)(void *)(out + n),
        .across = out + 2 * n,
        .down = out + 3 * n,
        .distance = out + 4 * n,
        .off = out + 5 * n,
        .point = {out + 6 * n, out + 7 * n, out + 8 * n},
        .normal = {out + 9 * n, out + 10 * n, out + 11 * n},
    };
}

/* Samples from `first` on. */
static inline void lens_relight_case_run(const struct lens_relight_case *k,
                                         const struct lens_relight_kernels *kernels,
                                         enum lens_relight_kernel kernel, uint32_t first,
                                         float *out)
{
    const uint32_t count = k->count - first;
    const size_t n = k->count;
    if (kernel == LIT_LENS_PLACE) {
        const struct lens_relight_row row = lens_relight_case_row(k, out);
        kernels->place(&row, first, k->count);
    } else if (kernel == LIT_LENS_OWN) {
        kernels->own(k->words[4] + first, 0.25f, count, (float *[3]){out, out + n, out + 2 * n});
    } else if (kernel == LIT_LENS_ADD) {
        for (uint32_t c = 0; c < 3; c++) {
            float *sum = out + c * n;
            memcpy(sum, k->number[3] + first, count * sizeof *sum);
            kernels->add(k->words[3] + first, k->number[5] + first, sum, c, count, sum);
        }
    } else {
        out[0] = kernels->max(k->number[4] + first, count, 1.0f);
    }
}

/* 0 where all bits are the reference's. */
static inline float lens_relight_case_compare(const struct lens_relight_case *k,
                                              const struct lens_relight_kernels *tested,
                                              enum lens_relight_kernel kernel, uint32_t first)
{
    const size_t size = lens_relight_case_size(k);
    float *a = field_memory(size * sizeof *a), *b = field_memory(size * sizeof *b);
    lens_relight_case_run(k, &lens_relight_kernels_sse42, kernel, first, a);
    lens_relight_case_run(k, tested, kernel, first, b);
    const float difference = memcmp(a, b, size * sizeof *a) ? INFINITY : 0.0f;
    free(a);
    free(b);
    return difference;
}
