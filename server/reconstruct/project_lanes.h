#pragma once
/* shadow_kernels' projections: passes 1a and 2a. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow_lanes.h"

/* weight(g + j) (1 + gamma y_j) of the nodes j < r, by linear interpolation between two phases. */
static inline void project_weights(const struct shadow_field *f, uint32_t axis,
                                   const struct shadow_target *t, float g, float *out)
{
    const float per_node = 2.0f / (float)f->scale, gamma = t->gamma[axis];
    const float phase = g * SHADOW_PHASES, whole = floorf(phase), rest = phase - whole;
    const float *below =
        f->weights + ((size_t)t->weights[axis] * (SHADOW_PHASES + 1) + (size_t)whole) * f->window;
    const float *above = below + (whole < SHADOW_PHASES ? f->window : 0);
    for (uint32_t first = 0; first < f->window; first += 8) { /* 0 from r on */
        for (uint32_t j = first; j < first + 8; j++) {
            const float y = 1.0f - (g + (float)j) * per_node;
            const float cover = below[j] + (above[j] - below[j]) * rest;
            out[j] = cover * (1.0f + gamma * y);
        }
    }
}

/* To node j weights[j] share; nodes lie `stride` numbers apart. */
static inline void project_add(uint32_t count, const float *weights, const float *share,
                               uint32_t stride, float *node)
{
    const shadow_four four = *(const shadow_four *)share;
    for (uint32_t j = 0; j < count; j++, node += stride) *(shadow_four *)node += weights[j] * four;
}

static void kernel_project_columns(const struct shadow_field *f, const uint32_t *pixels,
                                   uint32_t count, const float *jitter, const uint32_t *seen)
{
    const uint32_t l = f->strata, lanes = f->lanes, size = shadow_nodes(f) * lanes;
    const float strata_nodes = (float)f->scale / (float)l;
    _Alignas(64) float weights[SHADOW_STRATA_MAX], share[SHADOW_STRATA_MAX + 4];
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_target *t = &f->targets[pixels[k]];
        float *columns = f->columns + (size_t)f->sources[pixels[k]].slot * size;
        memset(columns, 0, size * sizeof *columns);
        for (uint32_t a = 0; a < l; a++) {
            const float at = ((float)a + jitter[k]) * strata_nodes, first = ceilf(at);
            const uint32_t bits = seen[k * l + a];
            float *node = columns + (size_t)first * lanes;
            project_weights(f, 0, t, first - at, weights);
            for (uint32_t b = 0; b < lanes; b += 4) {
                for (uint32_t i = b; i < b + 4; i++) share[i] = (float)(bits >> i & 1u);
            }
            for (uint32_t b = 0; b < lanes; b += 4)
                project_add(f->scale, weights, share + b, lanes, node + b);
        }
    }
}

#define PROJECT_CHUNK 8 /* nodes whose sums stay in registers */
#define PROJECT_PAD   (2 * SHADOW_STRATA_MAX + PROJECT_CHUNK)

/* Weights of node n for cells of one parity at padded[2 * (PAD + n)], twice, zeros around. */
static inline void project_pad(const struct shadow_field *f, const struct shadow_target *t, float g,
                               float padded[4 * PROJECT_PAD])
{
    float weights[SHADOW_STRATA_MAX];
    project_weights(f, 1, t, g, weights);
    for (uint32_t j = 0; j < f->scale; j++)
        padded[2 * (PROJECT_PAD + j)] = padded[2 * (PROJECT_PAD + j) + 1] = weights[j];
}

/* Cells go to nodes as a node's sum over the cells, in order, so that sums stay in registers. */
static void kernel_project_rows(const struct shadow_field *f, const uint32_t *pixels,
                                uint32_t count, const float *cells)
{
    const uint32_t nodes = shadow_nodes(f), used = 2 * f->scale; /* no weight reaches the rest */
    _Alignas(64) float even[4 * PROJECT_PAD] = {0}, odd[4 * PROJECT_PAD] = {0};
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_target *t = &f->targets[pixels[k]];
        const float *cell = cells + (size_t)k * 4 * f->scale;
        float *rows = f->rows + (size_t)f->sources[pixels[k]].slot * nodes * 2;
        project_pad(f, t, 0.75f, even);
        project_pad(f, t, 0.25f, odd);
        memset(rows + (size_t)used * 2, 0, (nodes - used) * 2 * sizeof *rows);
        for (uint32_t n = 0; n < used; n += PROJECT_CHUNK) {
            float sums[2 * PROJECT_CHUNK] = {0};
            for (uint32_t c = 0; c < f->scale; c++) {
                const float *e = even + 2 * (PROJECT_PAD + n - 1 - c);
                const float *o = odd + 2 * (PROJECT_PAD + n - 1 - c);
                const float *pair = cell + 4 * (size_t)c;
                for (uint32_t j = 0; j < PROJECT_CHUNK; j++) {
                    sums[2 * j] += e[2 * j] * pair[0];
                    sums[2 * j + 1] += e[2 * j + 1] * pair[1];
                }
                for (uint32_t j = 0; j < PROJECT_CHUNK; j++) {
                    sums[2 * j] += o[2 * j] * pair[2];
                    sums[2 * j + 1] += o[2 * j + 1] * pair[3];
                }
            }
            const uint32_t left = used - n, most = left < PROJECT_CHUNK ? left : PROJECT_CHUNK;
            memcpy(rows + (size_t)n * 2, sums, most * 2 * sizeof *sums);
        }
    }
}
