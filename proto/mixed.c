#include "proto/mixed.h"

#include <math.h>
#include <stdlib.h>

#include "proto/samples.h"

/* Of lights' strata and of bounce rays. What a layer beside paths has of them changes nothing. */
static uint32_t most_strata(const struct plan *plan)
{
    uint32_t l = plan->indirect_strata_per_axis;
    if (plan->paths.spp > 0) return MIXED_SAMPLES_A_PATH * plan->paths.spp;
    for (uint32_t k = 0; k < plan->light_count; k++)
        l = plan->lights[k].strata_per_axis > l ? plan->lights[k].strata_per_axis : l;
    return l * l;
}

uint32_t mixed_samples(const struct plan *plan)
{
    const uint32_t strata = most_strata(plan), least = MIXED_SAMPLES_LEAST;
    return strata > least ? (strata + least - 1) / least * least : least;
}

uint32_t mixed_glow_samples(const struct plan *plan)
{
    const uint32_t count = mixed_samples(plan);
    return count > GLOW_SAMPLES_LEAST ? count : GLOW_SAMPLES_LEAST;
}

uint32_t mixed_values(const struct plan *plan)
{
    return plan->planes & PLANE_BIT(SUB_REFLECTANCE) ? MIXED_VALUES_MOST : MIXED_REFLECTANCE;
}

int mixed_create(uint32_t values, uint32_t count, struct mixed_list **out)
{
    struct mixed_list *list = calloc(1, sizeof *list);
    if (!list) return ERR_MEMORY;
    list->values = values;
    list->count = count;
    list->words = calloc((size_t)count * (1 + values) + 1, sizeof *list->words);
    if (!list->words) {
        free(list);
        return ERR_MEMORY;
    }
    *out = list;
    return 0;
}

void mixed_destroy(struct mixed_list **list)
{
    if (!*list) return;
    free((*list)->words);
    free(*list);
    *list = NULL;
}

size_t mixed_bytes(const struct mixed_list *list)
{
    return list ? (size_t)list->count * (1 + list->values) * sizeof *list->words : 0;
}

float *mixed_numbers(const struct mixed_list *list, uint32_t value)
{
    return (float *)(void *)(list->words + (size_t)(1 + value) * list->count);
}

static int check_places(const struct mixed_list *list, uint32_t places, struct fault *fault)
{
    for (uint32_t e = 0; e < list->count; e++) {
        const uint32_t place = list->words[e];
        if (place >= places)
            return fault_set(fault, ERR_RANGE, "mixed", "place %u of entry %u is not below %u",
                             place, e, places);
        if (e > 0 && place <= list->words[e - 1])
            return fault_set(fault, ERR_RANGE, "mixed", "place %u of entry %u does not ascend",
                             place, e);
    }
    return 0;
}

int mixed_check(const struct mixed_list *list, uint32_t places, struct fault *fault)
{
    for (uint32_t value = 0; value < list->values; value++) {
        const float *v = mixed_numbers(list, value);
        for (uint32_t e = 0; e < list->count; e++)
            if (!(v[e] >= 0.0f && v[e] <= 1.0f))
                return fault_set(fault, isfinite(v[e]) ? ERR_RANGE : ERR_NOT_FINITE, "mixed",
                                 "value %u of entry %u is %g", value, e, (double)v[e]);
    }
    return check_places(list, places, fault);
}
