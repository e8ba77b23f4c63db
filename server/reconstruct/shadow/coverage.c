#include "server/reconstruct/shadow/coverage.h"

#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "server/reconstruct/shadow/shadow_kernels.h"

#define LEAST_SCALE   8
#define FINE_CELLS    4 /* a stratum, from which on their rounding does not show */
#define WINDOW_ALIGN  8
#define WEIGHTS_BYTES 64

/* Nodes a light's side. Rows are rounded to 2 r cells: were a stratum a few whole cells, all rows
 * of a pixel would be off by the same part of one, and the jitter between pixels lost: at 64 spp
 * that is worth 20 % of the error, at 256 spp 17 %. */
uint32_t coverage_scale(uint32_t strata)
{
    uint32_t scale = strata > LEAST_SCALE ? strata - 1 : LEAST_SCALE;
    while (2 * scale < FINE_CELLS * strata && 2 * scale % strata == 0) scale++;
    return scale;
}

int coverage_create(uint32_t strata, uint32_t profile, float rho_max, struct coverage *out)
{
    memset(out, 0, sizeof *out);
    out->scale = coverage_scale(strata);
    out->window = (out->scale + WINDOW_ALIGN - 1) / WINDOW_ALIGN * WINDOW_ALIGN;
    out->profile = profile;
    out->rho_max = rho_max;
    size_t bytes = sizeof(float) * COVERAGE_ROWS * (SHADOW_PHASES + 1) * out->window;
    bytes = (bytes + WEIGHTS_BYTES - 1) / WEIGHTS_BYTES * WEIGHTS_BYTES;
    out->weights = aligned_alloc(WEIGHTS_BYTES, bytes);
    return out->weights ? 0 : ERR_MEMORY;
}

void coverage_fini(struct coverage *coverage)
{
    free(coverage->weights);
    coverage->weights = NULL;
}

/* Weights are even in y: eighths of a node from the centre to the edge tell all. */
static void fill_row(struct coverage *c, uint32_t row, float rho, float delta)
{
    float from_centre[SHADOW_PHASES * SHADOW_STRATA_MAX / 2 + 1] = {0};
    const struct coverage_shear shear = coverage_shear_of(rho, delta);
    const uint32_t eighths = c->scale * SHADOW_PHASES / 2;
    for (uint32_t i = 0; i <= eighths; i++) {
        const float y = (float)i / (float)eighths;
        const float profile =
            c->profile == PROFILE_GAUSSIAN ? gaussian_exp_minus(2.0f * y * y) : 1.0f;
        from_centre[i] = profile / coverage_at(&shear, y);
    }
    /* Of mean 1 over the light: sources whose rho differ must count alike. */
    float mean = 0.0f;
    for (uint32_t i = 0; i < eighths; i++) mean += 0.5f * (from_centre[i] + from_centre[i + 1]);
    for (uint32_t i = 0; i <= eighths; i++) from_centre[i] *= (float)eighths / mean;
    float *out = c->weights + (size_t)row * (SHADOW_PHASES + 1) * c->window;
    for (uint32_t p = 0; p <= SHADOW_PHASES; p++, out += c->window) {
        memset(out, 0, c->window * sizeof *out);
        for (uint32_t k = 0; k < c->scale; k++) {
            const int32_t at = (int32_t)eighths - (int32_t)(p + k * SHADOW_PHASES);
            out[k] = from_centre[at < 0 ? -at : at];
        }
    }
}

void coverage_need(struct coverage *c, int32_t row)
{
    if (c->ready[row]) return;
    const int32_t i = row / COVERAGE_STEPS, j = row % COVERAGE_STEPS;
    const float steps = COVERAGE_STEPS - 1, rho = (float)i / steps, root = (float)j / steps;
    fill_row(c, (uint32_t)row, c->rho_max * rho, COVERAGE_DELTA_MAX * root * root);
    c->ready[row] = true;
}
