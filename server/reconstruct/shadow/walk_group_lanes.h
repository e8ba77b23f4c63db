#pragma once
/* Places the taps of sixteen pixels' walks. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/shadow_lanes.h"

struct walk_group {
    uint32_t count;    /* pixels; lanes past the end repeat the last */
    int32_t reach_max; /* of all lanes */
    _Alignas(64) int32_t pixel[SIMD_LANES], reach[SIMD_LANES];
    int32_t forward[SIMD_LANES], minor[SIMD_LANES]; /* pixels on, a step and aside */
    float slant[SIMD_LANES];                        /* steps aside, a step */
};

/* One tap of each pixel. */
struct walk_tap {
    _Alignas(
        64) int32_t to[SIMD_LANES]; /* the tap's pixel; the receiver itself where there is no tap */
    float share[SIMD_LANES];        /* 0 where there is none */
};

static inline void walk_group_load(const struct shadow_field *f, uint32_t axis,
                                   const uint32_t *pixels, uint32_t left, struct walk_group *g)
{
    const struct shadow_walk *walk = &f->pixels->walk[axis];
    const void *const steps[] = {walk->step[0], walk->step[1], walk->reach};
    _Alignas(64) float own[3][SIMD_LANES];
    const int32_t row = f->width;
    g->count = left < SIMD_LANES ? left : SIMD_LANES;
    simd_list(pixels, g->count, g->pixel);
    simd_take(steps, 3, g->pixel, own);
    memcpy(g->reach, own[2], sizeof g->reach);
    g->reach_max = 0;
    for (uint32_t i = 0; i < SIMD_LANES; i++) {
        const int32_t along_x = fabsf(own[0][i]) >= fabsf(own[1][i]);
        const int32_t major = along_x ? 1 : row;
        const float main = along_x ? own[0][i] : own[1][i];
        g->forward[i] = main < 0.0f ? -major : major;
        g->minor[i] = along_x ? row : 1;
        g->slant[i] = along_x ? own[1][i] : own[0][i];
        g->reach_max = g->reach[i] > g->reach_max ? g->reach[i] : g->reach_max;
    }
}

static inline int32_t walk_group_taps(const struct walk_group *g)
{
    return 2 * (2 * g->reach_max + 1);
}

/* Places the two taps of step k, from -reach_max to reach_max. The walk passes between two
 * pixels, which share its weight. */
static inline void walk_place(const struct walk_group *g, int32_t k, struct walk_tap out[2])
{
    const int32_t away = k < 0 ? -k : k;
    const float step = (float)k;
    _Alignas(64) float near[SIMD_LANES], far[SIMD_LANES];
    _Alignas(64) int32_t to_near[SIMD_LANES], to_far[SIMD_LANES];
    for (uint32_t i = 0; i < SIMD_LANES; i++) {
        const float aside = step * g->slant[i], below = floorf(aside), rest = aside - below;
        const int32_t on = k * g->forward[i] + (int32_t)below * g->minor[i];
        const int32_t here = g->pixel[i], there = here + on;
        const int32_t within = away <= g->reach[i];
        near[i] = within ? 1.0f - rest : 0.0f;
        far[i] = within ? rest : 0.0f;
        to_near[i] = near[i] > 0.0f ? there : here;
        to_far[i] = far[i] > 0.0f ? there + g->minor[i] : here;
    }
    memcpy(out[0].share, near, sizeof near);
    memcpy(out[1].share, far, sizeof far);
    memcpy(out[0].to, to_near, sizeof to_near);
    memcpy(out[1].to, to_far, sizeof to_far);
}

#ifdef __AVX512F__

static inline void walk_mark(const int32_t to[SIMD_LANES], uint8_t *marks)
{
    const __m512i pixels = _mm512_loadu_si512(to);
    const __m128i ones = _mm_set1_epi8(1);
    ptrdiff_t start;
    __mmask16 left = 0xffff, run = simd_run(pixels, left, &start);
    if (run == left) { /* the common case */
        _mm_storeu_si128((__m128i *)(void *)(marks + start), ones);
        return;
    }
    for (;;) {
        _mm_mask_storeu_epi8(marks + start, run, ones);
        left &= (__mmask16)~run;
        if (left == 0) return;
        run = simd_run(pixels, left, &start);
    }
}

#else

static inline void walk_mark(const int32_t to[SIMD_LANES], uint8_t *marks)
{
    for (uint32_t half = 0; half < SIMD_LANES; half += 8) {
        const int32_t *own = to + half;
#ifdef __AVX2__
        const __m256i pixels = _mm256_loadu_si256((const __m256i *)(const void *)own);
        const __m256i all = _mm256_set1_epi32(-1);
        ptrdiff_t start;
        if (_mm256_testc_si256(simd_run(pixels, all, &start), all)) {
            memset(marks + start, 1, 8);
            continue;
        }
#endif
        for (uint32_t i = 0; i < 8; i++) marks[own[i]] = 1;
    }
}

#endif
