#include "server/import/image/panorama.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* The largest half float. */
#define HALF_MAX 65504.0f

int panorama_create(struct panorama *p, int64_t width_px, int64_t height_px, const char *name,
                    struct fault *fault)
{
    *p = (struct panorama){0};
    if (width_px < 1 || height_px < 1 || width_px > LIMIT_ENVIRONMENT_SIDE_PX ||
        height_px > LIMIT_ENVIRONMENT_SIDE_PX || width_px * height_px > LIMIT_ENVIRONMENT_PIXELS)
        return fault_set(fault, ERR_LIMIT, name,
                         "%lld x %lld px; an environment map or a backplate has 1 to %u px on each "
                         "side, and %u px at most",
                         (long long)width_px, (long long)height_px, LIMIT_ENVIRONMENT_SIDE_PX,
                         LIMIT_ENVIRONMENT_PIXELS);
    p->texels = calloc((size_t)(width_px * height_px), 3 * sizeof *p->texels);
    if (p->texels == NULL)
        return fault_set(fault, ERR_MEMORY, name, "no memory for %lld x %lld px",
                         (long long)width_px, (long long)height_px);
    p->width_px = (uint32_t)width_px;
    p->height_px = (uint32_t)height_px;
    return 0;
}

void panorama_destroy(struct panorama *p)
{
    free(p->texels);
    *p = (struct panorama){0};
}

/* ---- repairs ---- */

enum repair { REPAIR_NAN, REPAIR_NEGATIVE, REPAIR_INFINITE, REPAIR_LARGE, REPAIR_COUNT };

static const char *const sentences[REPAIR_COUNT] = {
    [REPAIR_NAN] = "what is no number is taken as 0",
    [REPAIR_NEGATIVE] = "negative radiance is taken as 0",
    [REPAIR_INFINITE] = "infinite radiance is taken as 65504",
    [REPAIR_LARGE] = "radiance above the limit of 1e12 is taken as that",
};

struct repairs {
    uint64_t count[REPAIR_COUNT];
    size_t first[REPAIR_COUNT]; /* index of a float */
};

static float repaired(float v, enum repair *why)
{
    *why = isnan(v)   ? REPAIR_NAN
           : v < 0.0f ? REPAIR_NEGATIVE
           : isinf(v) ? REPAIR_INFINITE
                      : REPAIR_LARGE;
    return *why == REPAIR_INFINITE ? HALF_MAX : *why == REPAIR_LARGE ? LIMIT_RADIANCE : 0.0f;
}

static void warn(const struct panorama *p, const struct repairs *repairs, enum repair why,
                 struct warnings *warnings)
{
    char place[64];
    const size_t texel = repairs->first[why] / 3;
    snprintf(place, sizeof place, "texels[%zu][%zu].%c", texel / p->width_px, texel % p->width_px,
             "RGB"[repairs->first[why] % 3]);
    const uint32_t before = warnings->count;
    warnings_add(warnings, place, "%s", sentences[why]);
    if (warnings->count > before) warnings->list[before].more = repairs->count[why] - 1;
}

void panorama_repair(struct panorama *p, struct warnings *warnings)
{
    struct repairs repairs = {0};
    const size_t count = 3 * (size_t)p->width_px * p->height_px;
    for (size_t i = 0; i < count; i++) {
        enum repair why;
        if (p->texels[i] >= 0.0f && p->texels[i] <= LIMIT_RADIANCE) continue;
        p->texels[i] = repaired(p->texels[i], &why);
        if (repairs.count[why]++ == 0) repairs.first[why] = i;
    }
    for (enum repair why = 0; why < REPAIR_COUNT; why++)
        if (repairs.count[why] > 0) warn(p, &repairs, why, warnings);
}
