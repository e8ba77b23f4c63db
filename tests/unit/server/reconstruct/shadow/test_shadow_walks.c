/* Walks of the sheared filter against the sums they stand for (docs/reconstruction.md, Four
 * passes), pixel by pixel and tap by tap, in double: fields as odd as they get, of every number of
 * strata. */
#include <math.h>
#include <string.h>

#include "tests/kernel/field_surface.h"
#include "tests/kernel/kernel_field.h"
#include "tests/unit/unit.h"

#define LINEAR    0.8  /* share of the local linear fit's correction */
#define TOLERANCE 1e-5 /* of a pixel's greatest number */
#define OUT_MAX   (4 * SHADOW_STRATA_MAX)

/* A field and who walks along which axis. */
struct walker {
    const struct shadow_field *field;
    int axis;
    size_t pixel;
};

struct tap {
    size_t pixel;
    double weight, rest; /* how far between two nodes */
    size_t node;
};

/* The nearer or farther pixel of step k; false where the walk does not go there. */
static bool place(const struct walker *w, int k, int farther, size_t *pixel, float *share)
{
    const struct shadow_walk *walk = &w->field->pixels->walk[w->axis];
    const float x = walk->step[0][w->pixel], y = walk->step[1][w->pixel];
    const bool along_x = fabsf(x) >= fabsf(y);
    const float main = along_x ? x : y, aside = (float)k * (along_x ? y : x);
    const int row = w->field->width, major = along_x ? 1 : row, minor = along_x ? row : 1;
    const float rest = aside - floorf(aside);
    const int on = k * (main < 0.0f ? -major : major) + ((int)floorf(aside) + farther) * minor;
    *pixel = (size_t)((ptrdiff_t)w->pixel + on);
    *share = farther ? rest : 1.0f - rest;
    return *share > 0.0f;
}

/* What a tap weighs before it is balanced; false where it does not count. */
static bool meet(const struct walker *w, float share, struct tap *tap)
{
    const struct shadow_field *f = w->field;
    const struct shadow_pixels *p = f->pixels;
    const size_t own = w->pixel, other = tap->pixel;
    float squared;
    if (!field_same_surface(p, own, other, &squared)) return false;
    const float delta = p->distance[own] * (p->u[w->axis][other] - p->u[w->axis][own]);
    /* below 0 of pixels that nobody refuses: SHADOW_NO_SPREAD */
    const float shear = fabsf(p->eta[other] - p->eta[own]) + p->spread[other];
    if (!(fabsf(delta) * shear <= f->refusal[w->axis])) return false;
    const float node = fmaf(-p->eta[own] * delta, f->nodes_per_length[w->axis], (float)f->scale);
    if (!(node >= 0.0f && node <= 2.0f * (float)f->scale)) return false;
    const double exponent = (double)delta * (double)delta * (double)p->walk[w->axis].falloff[own];
    tap->weight = exponent < 87.0 ? (double)share * exp(-exponent) : 0.0;
    tap->node = (size_t)node;
    tap->rest = (double)(node - floorf(node));
    return true;
}

/* Adds a tap's nodes to the cells of its rows. */
static void add_columns(const struct shadow_field *f, const struct tap *tap, double *out)
{
    const size_t l = f->strata, phases = f->phases, each = l * phases / (2 * f->scale);
    const size_t slot = (size_t)f->pixels->slot[tap->pixel];
    const float *node = f->columns + (slot * shadow_nodes(f) + tap->node) * f->lanes;
    for (size_t row = 0; row < l; row++) {
        double *cell = out + 2 * ((row * phases + (size_t)f->pixels->phase[tap->pixel]) / each);
        const float *const next = node + f->lanes;
        cell[0] +=
            tap->weight * ((1 - tap->rest) * (double)node[row] + tap->rest * (double)next[row]);
        cell[1] += tap->weight * ((1 - tap->rest) * (double)node[l] + tap->rest * (double)next[l]);
    }
}

static void add_rows(const struct shadow_field *f, const struct tap *tap, double *out)
{
    const size_t slot = (size_t)f->pixels->slot[tap->pixel];
    const float *node = f->rows + (slot * shadow_nodes(f) + tap->node) * 2;
    for (size_t k = 0; k < 2; k++)
        out[k] +=
            tap->weight * ((1 - tap->rest) * (double)node[k] + tap->rest * (double)node[2 + k]);
}

/* All taps twice: their balance, then their sums. */
static void walk(const struct walker *w, double out[OUT_MAX])
{
    const int reach = w->field->pixels->walk[w->axis].reach[w->pixel];
    double first = 0.0, second = 0.0;
    memset(out, 0, OUT_MAX * sizeof *out);
    for (int turn = 0; turn < 2; turn++) {
        const double slope = second > 0.0 ? LINEAR * first / second : 0.0;
        for (int n = 0; n < 2 * (2 * reach + 1); n++) {
            const int k = n / 2 - reach;
            struct tap tap;
            float share;
            if (!place(w, k, n % 2, &tap.pixel, &share) || !meet(w, share, &tap)) continue;
            if (turn == 0) {
                first += tap.weight * k;
                second += tap.weight * k * k;
                continue;
            }
            tap.weight *= 1.0 - slope * k;
            if (w->axis == 0)
                add_columns(w->field, &tap, out);
            else
                add_rows(w->field, &tap, out);
        }
    }
}

static double worst_of(const struct shadow_kernels *kernels, const struct kernel_field *k, int axis)
{
    struct shadow_field f = k->field;
    f.pixels = &k->shown;
    const size_t each = axis == 0 ? 4 * (size_t)f.scale : 2;
    float *out = field_memory(k->count * each * sizeof *out);
    double worst = 0.0;
    (axis == 0 ? kernels->walk_columns : kernels->walk_rows)(&f, k->pixels + 1, k->count, out);
    for (uint32_t i = 0; i < k->count; i++) {
        const struct walker walker = {&f, axis, k->pixels[1 + i]};
        double right[OUT_MAX];
        walk(&walker, right);
        worst = fmax(worst, field_error(right, out + i * each, each));
    }
    free(out);
    return worst;
}

TEST(taps_add_up)
{
    const struct shadow_kernels *const sets[] = {&shadow_kernels_sse42,
                                                 KERNELS_BEST(shadow_kernels)};
    double worst = 0.0;
    for (uint32_t l = 1; l <= SHADOW_STRATA_MAX; l++) {
        struct kernel_field k;
        field_init(&k, l, 17, 13, 100 + l, true);
        for (int n = 0; n < 4; n++) worst = fmax(worst, worst_of(sets[n / 2], &k, n % 2));
        field_fini(&k);
    }
    print_message("off by %.2g\n", worst);
    assert_true(worst < TOLERANCE);
}
