/* The table of kernels, compiled once for each instruction set: define SHADOW_KERNELS as its name
 * and include this. The same operations in the same order everywhere: pictures do not depend on the
 * CPU. */
#include "server/reconstruct/unoccluded_lanes.h"

#include <math.h>
#include <string.h>

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Do both show one smooth surface, near enough for each other (filters.md section 2)? *squared
 * becomes their distance's square. */
static bool compatible(const struct shadow_source *p, const struct shadow_target *t,
                       const struct shadow_source *q, float *squared)
{
    const float d[3] = {q->point[0] - p->point[0], q->point[1] - p->point[1],
                        q->point[2] - p->point[2]};
    const float off = fabsf(dot(d, p->normal));
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE, d2 = dot(d, d);
    *squared = d2;
    return dot(p->normal, q->normal) >= SHADOW_COS_NORMALS && d2 <= t->distance_most2 &&
           (off <= t->plane_least || off * off <= share * d2);
}

/* A neighbour that counts: the source, its weight, the node its sums are read at. */
struct tap {
    const struct shadow_source *source;
    float weight;
    float node;
};

static void try_tap(const struct shadow_field *f, uint32_t axis, size_t pixel, ptrdiff_t to,
                    float share, struct tap *taps, uint32_t *count)
{
    const struct shadow_source *p = &f->sources[pixel];
    const struct shadow_source *q = &f->sources[(ptrdiff_t)pixel + to];
    const struct shadow_target *t = &f->targets[pixel];
    float squared;
    if (!(share > 0.0f) || !compatible(p, t, q, &squared)) return;
    const float delta = t->distance * (q->u[axis] - p->u[axis]);
    const float shear = fabsf(q->eta - p->eta) + q->spread;
    const float node = (float)f->scale - p->eta * delta * f->nodes_per_length[axis];
    if (!(fabsf(delta) * shear <= f->refusal[axis])) return;
    if (!(node >= 0.0f && node <= (float)(2 * f->scale))) return;
    struct tap *tap = &taps[(*count)++];
    tap->source = q;
    tap->weight = share * gaussian_exp_minus(delta * delta * t->walk[axis].falloff);
    tap->node = node;
}

/* The taps of a walk, from its negative end; the nearer pixel in rows or columns first. */
static uint32_t take_taps(const struct shadow_field *f, uint32_t axis, size_t pixel,
                          struct tap taps[SHADOW_TAPS])
{
    const struct shadow_walk *w = &f->targets[pixel].walk[axis];
    const bool along_x = fabsf(w->step[0]) >= fabsf(w->step[1]);
    const ptrdiff_t major = along_x ? 1 : f->width, minor = along_x ? f->width : 1;
    const ptrdiff_t forward = w->step[along_x ? 0 : 1] < 0.0f ? -major : major;
    const float slant = w->step[along_x ? 1 : 0];
    uint32_t count = 0;
    for (int32_t k = -w->reach; k <= w->reach; k++) {
        const float aside = (float)k * slant, below = floorf(aside), share = aside - below;
        const ptrdiff_t to = k * forward + (ptrdiff_t)below * minor;
        try_tap(f, axis, pixel, to, 1.0f - share, taps, &count);
        try_tap(f, axis, pixel, to + minor, share, taps, &count);
    }
    return count;
}

static void kernel_project_columns(const struct shadow_field *f, const uint32_t *pixels,
                                   uint32_t count, const float *jitter, const uint32_t *seen)
{
    const uint32_t l = f->strata, lanes = f->lanes, size = shadow_nodes(f) * lanes;
    const float strata_nodes = (float)f->scale / (float)l, per_node = 2.0f / (float)f->scale;
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_target *t = &f->targets[pixels[k]];
        float *columns = f->columns + (size_t)f->sources[pixels[k]].slot * size;
        const float *row = f->weights + (size_t)t->weights[0] * (SHADOW_PHASES + 1) * f->window;
        memset(columns, 0, size * sizeof *columns);
        for (uint32_t a = 0; a < l; a++) {
            const float at = ((float)a + jitter[k]) * strata_nodes, first = ceilf(at);
            const float g = first - at, phase = g * SHADOW_PHASES, whole = floorf(phase);
            const float *below = row + (size_t)whole * f->window;
            const float *above = below + (whole < SHADOW_PHASES ? f->window : 0);
            const float rest = phase - whole;
            float *node = columns + (size_t)first * lanes;
            for (uint32_t j = 0; j < f->scale; j++, node += lanes) {
                const float y = 1.0f - (g + (float)j) * per_node;
                const float cover = below[j] + (above[j] - below[j]) * rest;
                const float weight = cover * (1.0f + t->gamma[0] * y);
                for (uint32_t b = 0; b <= l; b++)
                    node[b] += seen[k * l + a] >> b & 1u ? weight : 0.0f;
            }
        }
    }
}

static void kernel_walk_columns(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, float *out)
{
    const uint32_t l = f->strata, lanes = f->lanes, size = shadow_nodes(f) * lanes;
    struct tap taps[SHADOW_TAPS];
    for (uint32_t k = 0; k < count; k++) {
        float *cells = out + (size_t)k * 4 * f->scale;
        const uint32_t n = take_taps(f, 0, pixels[k], taps);
        memset(cells, 0, 4 * f->scale * sizeof *cells);
        for (uint32_t i = 0; i < n; i++) {
            const size_t slot = (size_t)taps[i].source->slot;
            const float below = floorf(taps[i].node), rest = taps[i].node - below;
            const float w0 = taps[i].weight * (1.0f - rest), w1 = taps[i].weight * rest;
            const float *c = f->columns + slot * size + (size_t)below * lanes;
            const uint8_t *cell = f->cells + slot * SHADOW_STRATA_MAX;
            const float whole = w0 * c[l] + w1 * c[lanes + l];
            for (uint32_t b = 0; b < l; b++) {
                cells[2 * cell[b]] += w0 * c[b] + w1 * c[lanes + b];
                cells[2 * cell[b] + 1] += whole;
            }
        }
    }
}

static void kernel_project_rows(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, const float *cells)
{
    const uint32_t size = shadow_nodes(f) * 2;
    const float per_node = 2.0f / (float)f->scale;
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_target *t = &f->targets[pixels[k]];
        float *rows = f->rows + (size_t)f->sources[pixels[k]].slot * size;
        const float *row = f->weights + (size_t)t->weights[1] * (SHADOW_PHASES + 1) * f->window;
        memset(rows, 0, size * sizeof *rows);
        for (uint32_t c = 0; c < 2 * f->scale; c++) {
            const float *cell = cells + (size_t)k * 4 * f->scale + (size_t)c * 2;
            const float *weights = row + (c & 1u ? 2u : 6u) * f->window;
            const float g = c & 1u ? 0.25f : 0.75f;
            float *node = rows + (size_t)(c / 2 + 1) * 2;
            for (uint32_t j = 0; j < f->scale; j++) {
                const float y = 1.0f - (g + (float)j) * per_node;
                const float weight = weights[j] * (1.0f + t->gamma[1] * y);
                node[2 * j] += weight * cell[0];
                node[2 * j + 1] += weight * cell[1];
            }
        }
    }
}

static void kernel_walk_rows(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                             float *out)
{
    const uint32_t size = shadow_nodes(f) * 2;
    struct tap taps[SHADOW_TAPS];
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t n = take_taps(f, 1, pixels[k], taps);
        float numerator = 0.0f, denominator = 0.0f;
        for (uint32_t i = 0; i < n; i++) {
            const float below = floorf(taps[i].node), rest = taps[i].node - below;
            const float w0 = taps[i].weight * (1.0f - rest), w1 = taps[i].weight * rest;
            const float *r = f->rows + (size_t)taps[i].source->slot * size + (size_t)below * 2;
            numerator += w0 * r[0] + w1 * r[2];
            denominator += w0 * r[1] + w1 * r[3];
        }
        out[2 * k] = numerator;
        out[2 * k + 1] = denominator;
    }
}

static void kernel_blur(const struct shadow_field *f, uint32_t axis, const uint32_t *pixels,
                        uint32_t count, float *out)
{
    const ptrdiff_t step = axis == 0 ? 1 : f->width;
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_source *p = &f->sources[pixels[k]];
        const struct shadow_target *t = &f->targets[pixels[k]];
        const int32_t reach = t->walk[axis].reach;
        float sum = 0.0f, weights = 0.0f;
        for (int32_t i = -reach; i <= reach; i++) {
            const struct shadow_source *q = p + i * step;
            float squared;
            if (!compatible(p, t, q, &squared)) continue;
            const float exponent = squared * t->width;
            if (exponent > SHADOW_AXIS_CUT || (i != 0 && squared > q->refusal)) continue;
            const float w = gaussian_exp_minus(exponent);
            sum += w * q->seen;
            weights += w;
        }
        out[k] = weights > 0.0f ? sum / weights : p->seen;
    }
}

static void kernel_sum_slopes(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                              const float *a, const float *b, float *out)
{
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_source *p = &f->sources[pixels[k]];
        float sums[3] = {0};
        for (int32_t i = 0; i < 25; i++) {
            const ptrdiff_t at = (ptrdiff_t)pixels[k] + (i / 5 - 2) * f->width + i % 5 - 2;
            float squared;
            if (a[at] < 0.0f || !compatible(p, &f->targets[pixels[k]], &f->sources[at], &squared))
                continue;
            sums[0] += 1.0f;
            sums[1] += a[at];
            sums[2] += b[at];
        }
        memcpy(out + (size_t)k * 3, sums, sizeof sums);
    }
}

const struct shadow_kernels SHADOW_KERNELS = {
    .unoccluded = kernel_unoccluded,
    .project_columns = kernel_project_columns,
    .walk_columns = kernel_walk_columns,
    .project_rows = kernel_project_rows,
    .walk_rows = kernel_walk_rows,
    .blur = kernel_blur,
    .sum_slopes = kernel_sum_slopes,
};
