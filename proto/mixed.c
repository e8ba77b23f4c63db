#include "proto/mixed.h"

#include <math.h>

#include "proto/samples.h"

/* Of lights' strata and of bounce rays that bring light: what layers have of them changes nothing.
 */
static uint32_t most_strata(const struct plan *plan)
{
    const bool lit = plan->planes & PLANES_BOUNCE_LIGHT;
    const uint32_t bounces = lit ? plan->indirect_strata_per_axis : 0;
    uint32_t l = plan->field_halved ? (bounces + 1) / 2 : bounces; /* a quarter have rays */
    if (plan->paths.spp > 0) return MIXED_SAMPLES_A_PATH * plan->paths.spp;
    for (uint32_t k = 0; k < plan->light_count; k++)
        l = plan->lights[k].strata_per_axis > l ? plan->lights[k].strata_per_axis : l;
    return l * l;
}

uint32_t mixed_samples(const struct plan *plan)
{
    const uint32_t strata = most_strata(plan), least = MIXED_SAMPLES_MIN;
    return strata > least ? (strata + least - 1) / least * least : least;
}

uint32_t mixed_glow_samples(const struct plan *plan)
{
    const uint32_t count = mixed_samples(plan);
    return count > GLOW_SAMPLES_MIN ? count : GLOW_SAMPLES_MIN;
}

uint32_t mixed_values(const struct plan *plan)
{
    return plan->planes & PLANE_BIT(SUB_REFLECTANCE) ? MIXED_VALUES_MAX : MIXED_REFLECTANCE;
}

int mixed_check(const struct sparse_list *list, uint32_t places, struct fault *fault)
{
    for (uint32_t value = 0; value < list->values; value++) {
        const float *v = sparse_list_numbers(list, value);
        for (uint32_t e = 0; e < list->count; e++)
            if (!(v[e] >= 0.0f && v[e] <= 1.0f))
                return fault_set(fault, isfinite(v[e]) ? ERR_RANGE : ERR_NOT_FINITE, "mixed",
                                 "value %u of entry %u is %g", value, e, (double)v[e]);
    }
    return sparse_list_check(list, places, "mixed", fault);
}
