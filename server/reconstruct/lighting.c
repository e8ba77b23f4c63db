#include "server/reconstruct/lighting.h"

#include <stdlib.h>
#include <string.h>

#define INVERSE_PI 0.318309886183790672f

static void add_light(const struct plan_light *light, const float *irradiance, size_t area,
                      float *const direct[3])
{
    for (int c = 0; c < 3; c++) {
        float scale = light->color[c] * INVERSE_PI;
        float *out = direct[c];
        if (!(scale > 0.0f)) continue;
        for (size_t i = 0; i < area; i++) {
            float lit = irradiance[i] * scale;
            out[i] +=
                lit < LIGHTING_MAX ? lit : LIGHTING_MAX; /* also where the product overflows */
        }
    }
}

/* Mean over all samples from the means over the even and the odd ones (samples.h). */
static void add_halves(const struct plan *plan, const struct patch *patch, size_t area,
                       float *const out[3])
{
    uint32_t n = plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    /* With bounces n is at least 1. */
    uint32_t odd_count = n / 2, even_count = n - odd_count;
    float even = (float)even_count / (float)n, odd = (float)odd_count / (float)n;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < area; i++) {
            out[c][i] = patch->indirect_even[c][i] * even + patch->indirect_odd[c][i] * odd;
        }
    }
}

static void add_strata(const struct plan *plan, const struct patch *patch, size_t area,
                       float *const out[3])
{
    uint32_t n = plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    float share = 1.0f / (float)n; /* with bounces n is at least 1 */
    for (int c = 0; c < 3; c++) {
        for (uint32_t s = 0; s < n; s++) {
            const float *in = patch->indirect_strata + (s * 4 + (uint32_t)c) * area;
            for (size_t i = 0; i < area; i++) out[c][i] += in[i];
        }
        for (size_t i = 0; i < area; i++) out[c][i] *= share;
    }
}

static void fill_indirect(const struct plan *plan, const struct patch *patch, size_t area,
                          float *const out[3])
{
    if (patch->indirect[0]) {
        for (int c = 0; c < 3; c++) memcpy(out[c], patch->indirect[c], area * sizeof(float));
    } else if (patch->indirect_even[0]) {
        add_halves(plan, patch, area, out);
    } else if (patch->indirect_strata) {
        add_strata(plan, patch, area, out);
    }
}

static void fill_total(const struct lighting *l, size_t area)
{
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < area; i++) l->total[c][i] = l->direct[c][i] + l->indirect[c][i];
    }
}

int lighting_create(const struct plan *plan, const struct patch *patch, struct lighting *out)
{
    size_t area = (size_t)rect_area(patch->rect);
    float *memory = calloc(area * 9, sizeof *memory);
    *out = (struct lighting){0};
    if (!memory) return ERR_MEMORY;
    out->memory = memory;
    for (size_t c = 0; c < 3; c++) {
        out->direct[c] = memory + c * area;
        out->indirect[c] = memory + (3 + c) * area;
        out->total[c] = memory + (6 + c) * area;
    }
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const float *irradiance = patch->lights[k].irradiance;
        if (irradiance) add_light(&plan->lights[k], irradiance, area, out->direct);
    }
    fill_indirect(plan, patch, area, out->indirect);
    fill_total(out, area);
    return 0;
}

void lighting_fini(struct lighting *lighting)
{
    free(lighting->memory);
    *lighting = (struct lighting){0};
}
