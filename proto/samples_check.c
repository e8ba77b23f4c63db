/* Checks that the numbers of a sample buffer are those that their planes allow. There is one pass
 * over the data: every loop first asks about all elements without branches, and searches only after
 * a fault. */
#include <float.h>
#include <stdbool.h>
#include <stdio.h>

#include "proto/half.h"
#include "proto/samples_layout.h"
#include "proto/shared_exponent.h"

#define HALF_INFINITY  0x7c00u
#define HALF_SIGN      0x8000u
#define HALF_MINUS_ONE 0xbc00u /* SUB_DEPTH_MISS */

/* The first element at fault. */
struct finding {
    size_t index;
    double value;
    int code;
};

static bool half_is_finite(uint16_t h)
{
    return (h & ~HALF_SIGN) < HALF_INFINITY;
}

/* Negative halves have the sign bit and grow in size: those up to `least` are allowed, which is at
 * least minus zero. */
static bool half_is_good(uint16_t h, uint32_t least)
{
    return half_is_finite(h) & (h <= least);
}

static bool check_halves(const uint16_t *v, size_t count, uint32_t least, struct finding *found)
{
    bool good = true;
    for (size_t i = 0; i < count; i++) good &= half_is_good(v[i], least);
    if (good) return true;
    size_t i = 0;
    while (half_is_good(v[i], least)) i++;
    const int code = half_is_finite(v[i]) ? ERR_RANGE : ERR_NOT_FINITE;
    *found = (struct finding){i, (double)half_to_float(v[i]), code};
    return false;
}

static bool check_finite_halves(const uint16_t *v, size_t count, struct finding *found)
{
    bool good = true;
    for (size_t i = 0; i < count; i++) good &= half_is_finite(v[i]);
    if (good) return true;
    size_t i = 0;
    while (half_is_finite(v[i])) i++;
    *found = (struct finding){i, (double)half_to_float(v[i]), ERR_NOT_FINITE};
    return false;
}

static bool float_is_good(float v)
{
    return (v >= 0.0f) & (v <= FLT_MAX); /* neither holds for NaN */
}

static bool check_floats(const float *v, size_t count, struct finding *found)
{
    bool good = true;
    for (size_t i = 0; i < count; i++) good &= float_is_good(v[i]);
    if (good) return true;
    size_t i = 0;
    while (float_is_good(v[i])) i++;
    const bool finite = v[i] >= -FLT_MAX && v[i] <= FLT_MAX;
    *found = (struct finding){i, (double)v[i], finite ? ERR_RANGE : ERR_NOT_FINITE};
    return false;
}

static bool float_is_finite(float v)
{
    return v >= -FLT_MAX && v <= FLT_MAX;
}

static bool check_finite_floats(const float *v, size_t count, struct finding *found)
{
    bool good = true;
    for (size_t i = 0; i < count; i++) good &= float_is_finite(v[i]);
    if (good) return true;
    size_t i = 0;
    while (float_is_finite(v[i])) i++;
    *found = (struct finding){i, (double)v[i], ERR_NOT_FINITE};
    return false;
}

static bool check_ids(const uint32_t *v, size_t count, struct finding *found)
{
    for (size_t i = 0; i < count; i++) {
        if (v[i] <= LIMIT_INSTANCES) continue;
        *found = (struct finding){i, (double)v[i], ERR_RANGE};
        return false;
    }
    return true;
}

/* Exponents beyond the most are of numbers that are not finite. */
static bool check_shared(const uint32_t *v, size_t count, struct finding *found)
{
    const uint32_t most = shared_exponent_max(SHARED_EXPONENT_8);
    for (size_t i = 0; i < count; i++) {
        if (v[i] >> 24 <= most) continue;
        *found = (struct finding){i, (double)(v[i] >> 24), ERR_RANGE};
        return false;
    }
    return true;
}

static bool check_bits(const uint8_t *v, size_t count, uint32_t mask, struct finding *found)
{
    uint32_t all = 0;
    for (size_t i = 0; i < count; i++) all |= v[i];
    if (!(all & ~mask)) return true;
    size_t i = 0;
    while (!(v[i] & ~mask)) i++;
    *found = (struct finding){i, (double)v[i], ERR_RANGE};
    return false;
}

/* Positive halves order like their bits; the sign of a zero is of no account. */
static bool check_order(const uint16_t *low, const uint16_t *high, size_t count,
                        struct finding *found)
{
    for (size_t i = 0; i < count; i++) {
        if ((low[i] & ~HALF_SIGN) <= (high[i] & ~HALF_SIGN)) continue;
        *found = (struct finding){i, (double)half_to_float(low[i]), ERR_RANGE};
        return false;
    }
    return true;
}

static int refuse(const struct samples *s, const char *place, const struct finding *found,
                  struct fault *fault)
{
    const size_t width = (size_t)s->layout.width_px;
    return fault_set(fault, found->code, place, "%g at pixel (%zu, %zu) of the tile", found->value,
                     found->index % width, found->index / width);
}

static bool check_component(const struct samples *s, uint32_t slot, uint32_t c, size_t area,
                            struct finding *found)
{
    const struct samples_plane *plane = samples_plane(slot);
    const void *v = samples_component(s, slot, c);
    const bool last = c + 1 == s->layout.components[slot];
    switch (plane->values) {
    case SAMPLES_ANY:
        return true;
    case SAMPLES_POSITIVE:
        return plane->type == SAMPLES_F32 ? check_floats(v, area, found)
                                          : check_halves(v, area, HALF_SIGN, found);
    case SAMPLES_FINITE:
        return plane->type == SAMPLES_F32 ? check_finite_floats(v, area, found)
                                          : check_finite_halves(v, area, found);
    case SAMPLES_ABOVE_MISS:
        return check_halves(v, area, HALF_MINUS_ONE, found);
    case SAMPLES_ID:
        return check_ids(v, area, found);
    case SAMPLES_SHARED_8:
        return check_shared(v, area, found);
    case SAMPLES_SLOPES:
        return check_halves(v, area, HALF_SIGN, found) &&
               (!last || check_order(samples_component(s, slot, 0), v, area, found));
    case SAMPLES_BITS:
        return !last ||
               check_bits(v, area, samples_visibility_mask(&s->layout, samples_slot_light(slot)),
                          found);
    }
    return true;
}

static int check_plane(const struct samples *s, uint32_t slot, size_t area, struct fault *fault)
{
    if (s->layout.offset[slot] == SAMPLES_ABSENT) return 0;
    for (uint32_t c = 0; c < s->layout.components[slot]; c++) {
        struct finding found;
        char place[LIMIT_POINTER_BYTES];
        const char *name = samples_plane(slot)->name;
        if (check_component(s, slot, c, area, &found)) continue;
        if (slot < PLANE_ID_COUNT)
            snprintf(place, sizeof place, "%s[%u]", name, c);
        else
            snprintf(place, sizeof place, "lights[%u].%s", samples_slot_light(slot), name);
        return refuse(s, place, &found, fault);
    }
    return 0;
}

/* Light of what is no surface has no place. */
static int check_lone_surfaces(const struct samples *s, struct fault *fault)
{
    const uint32_t subs = s->layout.sub_samples;
    if (s->layout.offset[PLANE_SUB_DEPTH] == SAMPLES_ABSENT) return 0;
    for (uint32_t e = 0; e < s->lone->count; e++) {
        const uint32_t place = s->lone->words[e];
        if (samples_u16(s, PLANE_SUB_DEPTH, place % subs)[place / subs] != HALF_MINUS_ONE) continue;
        return fault_set(fault, ERR_RANGE, "lone", "sub-sample %u of entry %u shows no surface",
                         place, e);
    }
    return 0;
}

static int check_lone(const struct samples *s, struct fault *fault)
{
    if (!s->lone) return 0;
    const int error = lone_check(s->lone, samples_lone_places(&s->layout), fault);
    return error ? error : check_lone_surfaces(s, fault);
}

int samples_check(const struct samples *s, struct fault *fault)
{
    const size_t area = (size_t)s->layout.width_px * (size_t)s->layout.height_px;
    int error = 0;
    for (uint32_t i = 0; i < s->layout.slots && !error; i++) error = check_plane(s, i, area, fault);
    if (!error) error = check_lone(s, fault);
    if (error || !s->mixed) return error;
    return mixed_check(s->mixed, samples_mixed_places(&s->layout), fault);
}
