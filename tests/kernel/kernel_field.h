#pragma once
/* Random fields for the kernels of the shadow filters, made to meet every branch: surfaces that end
 * and bend, pixels that show nothing, have no wedge, walk nowhere, refuse or are refused. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/plan.h"
#include "server/reconstruct/shadow/coverage.h"
#include "server/reconstruct/shadow/edge.h"
#include "server/reconstruct/shadow/shadow_kernels.h"
#include "server/reconstruct/shadow/strata.h"
#include "tests/kernel/reference.h"
#include "tests/random.h"

enum kernel {
    KERNEL_UNOCCLUDED,
    KERNEL_PLACE_RECEIVERS,
    KERNEL_SHEAR_RECEIVERS,
    KERNEL_MARK_WALKS,
    KERNEL_PROJECT_COLUMNS,
    KERNEL_WALK_COLUMNS,
    KERNEL_PROJECT_ROWS,
    KERNEL_WALK_ROWS,
    KERNEL_BLUR_X,
    KERNEL_BLUR_Y,
    KERNEL_ESTIMATE,
    KERNEL_FILTER_EDGES,
    KERNEL_SUM_SLOPES,
    KERNEL_COUNT,
};

extern const char *const kernel_names[KERNEL_COUNT];

#define FIELD_FLOATS 22 /* of a pixel: struct shadow_pixels; then what is whole */
#define FIELD_PIXEL  28
#define FIELD_PLANES 3 /* of struct shadow_blur beside pixels but its reach: seen first */

struct kernel_field {
    struct shadow_field field; /* everything in it owned */
    /* The latter are written; each is one piece of memory that starts with points. */
    struct shadow_pixels shown, placed, sheared;
    float *weights;
    struct plan plan;
    struct receiver_light light;
    float *planes[FIELD_PLANES];
    int32_t *reach;
    uint32_t *bits;
    uint32_t *pixels, count; /* those that have room to walk and are lit */
    uint32_t slots;
    /* One number too long: input starts off any alignment. */
    float *jitter[2], *cells, *a, *b, *most, *least, *sigma_px, *depth, *point[3], *normal[3];
    uint32_t *seen;
};

static inline float field_between(struct random *r, float least, float most)
{
    return least + (most - least) * random_unit(r);
}

static inline bool field_once_in(struct random *r, int n)
{
    return random_unit(r) * (float)n < 1.0f;
}

void *field_memory(size_t bytes);
float *field_numbers(struct random *r, size_t count, float least, float most);

/* Planes of `stride` numbers in one piece of memory, in an order of our own. */
void field_pixels(struct shadow_pixels *p, size_t stride);

/* A field of width x height pixels beyond the margin. */
void field_init(struct kernel_field *out, uint32_t l, int32_t width, int32_t height, uint64_t seed,
                bool wild);

void field_fini(struct kernel_field *k);

/* ---- kernel_run.c ---- */

/* Numbers that `kernel` writes for `count` pixels, or for all slots. */
size_t field_output(const struct kernel_field *k, enum kernel kernel, uint32_t count);

static inline size_t field_stride(const struct kernel_field *k)
{
    return (size_t)k->field.width * (size_t)k->field.height + SHADOW_PLANE_PAD;
}

/* The kernel over `count` pixels from number `first` on, into `out`. */
void field_run(const struct kernel_field *k, const struct shadow_kernels *kernels,
               enum kernel kernel, uint32_t first, uint32_t count, float *out);

/* How far a kernel that rounds products may be off. Some have none to round; edges' windows are
 * chosen by angles that small tensors hardly tell. */
float field_rounding(enum kernel kernel);

float field_difference(const float *a, const float *b, size_t count);

/* The same of one kernel over `count` pixels from `first` on. */
float field_compare(const struct kernel_field *k, const struct shadow_kernels *tested,
                    enum kernel kernel, uint32_t first, uint32_t count);
