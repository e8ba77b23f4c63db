#include "proto/lone.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#include "proto/samples.h"

#define CHANNELS 3u

static const char *const part_names[LONE_PART_COUNT] = {"direct", "indirect", "indirect_half",
                                                        "glossy", "glossy_half"};

uint32_t lone_parts(const struct plan *plan)
{
    uint32_t parts = 0;
    /* Else paths bring direct light. */
    const bool fields = plan->paths.spp == 0 || plan->paths.without_diffuse_direct;
    if (fields && plan->light_planes != 0) parts |= 1u << LONE_DIRECT;
    if (plan->planes & PLANES_BOUNCE_LIGHT) parts |= 1u << LONE_INDIRECT;
    if (plan->planes & PLANE_BIT(INDIRECT_HALVES)) parts |= 1u << LONE_INDIRECT_HALF;
    if (plan->planes & PLANE_BIT(GLOSSY_MEAN)) parts |= 1u << LONE_GLOSSY;
    if (plan->planes & PLANE_BIT(GLOSSY_HALF)) parts |= 1u << LONE_GLOSSY_HALF;
    return parts;
}

uint32_t lone_words(uint32_t parts)
{
    return 1u + CHANNELS * (uint32_t)__builtin_popcount(parts);
}

int lone_create(uint32_t parts, uint32_t count, struct sparse_list **out)
{
    const int error = sparse_list_create(lone_words(parts) - 1, count, out);
    if (!error) (*out)->parts = parts;
    return error;
}

float *lone_values(const struct sparse_list *list, enum lone_part part, uint32_t channel)
{
    const uint32_t before = list->parts & ((1u << part) - 1u);
    if (!(list->parts >> part & 1u)) return NULL;
    return sparse_list_numbers(list, CHANNELS * (uint32_t)__builtin_popcount(before) + channel);
}

static int check_part(const struct sparse_list *list, enum lone_part part, struct fault *fault)
{
    for (uint32_t c = 0; c < CHANNELS; c++) {
        const float *v = lone_values(list, part, c);
        for (uint32_t e = 0; v && e < list->count; e++) {
            char place[LIMIT_POINTER_BYTES];
            if (v[e] >= 0.0f && v[e] <= LONE_RADIANCE_MAX) continue;
            snprintf(place, sizeof place, "lone.%s[%u]", part_names[part], c);
            return fault_set(fault, isfinite(v[e]) ? ERR_RANGE : ERR_NOT_FINITE, place,
                             "%g at entry %u", (double)v[e], e);
        }
    }
    return 0;
}

int lone_check(const struct sparse_list *list, uint32_t places, struct fault *fault)
{
    int error = sparse_list_check(list, places, "lone", fault);
    for (uint32_t part = 0; part < LONE_PART_COUNT && !error; part++)
        error = check_part(list, part, fault);
    return error;
}
