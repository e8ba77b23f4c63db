#pragma once
/* Walks of sixteen pixels side by side: where each's tap lies, and what lies there. Pixels of a
 * list mostly follow each other, and walk much the same way: then so do their taps, and a number of
 * all of them is one piece of its plane. */
#include <math.h>

#include "server/reconstruct/shadow_lanes.h"

struct walk_group {
    uint32_t count;     /* pixels; lanes past the end repeat the last */
    int32_t reach_most; /* of all lanes */
    int32_t pixel[SHADOW_LANES], reach[SHADOW_LANES];
    int32_t forward[SHADOW_LANES], minor[SHADOW_LANES]; /* pixels on, a step and aside */
    float slant[SHADOW_LANES];                          /* steps aside, a step */
};

/* One tap of each. */
struct walk_tap {
    int32_t to[SHADOW_LANES];  /* the pixel; its own where there is no tap */
    float share[SHADOW_LANES]; /* 0 where there is none */
};

static inline void walk_group_load(const struct shadow_field *f, uint32_t axis,
                                   const uint32_t *pixels, uint32_t left, struct walk_group *g)
{
    float step[2][SHADOW_LANES];
    g->count = left < SHADOW_LANES ? left : SHADOW_LANES;
    g->reach_most = 0;
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
        const uint32_t pixel = pixels[i < g->count ? i : g->count - 1];
        const struct shadow_walk *w = &f->targets[pixel].walk[axis];
        g->pixel[i] = (int32_t)pixel;
        g->reach[i] = w->reach;
        g->reach_most = w->reach > g->reach_most ? w->reach : g->reach_most;
        step[0][i] = w->step[0];
        step[1][i] = w->step[1];
    }
    const int32_t row = f->width;
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
        const int32_t along_x = fabsf(step[0][i]) >= fabsf(step[1][i]);
        const int32_t major = along_x ? 1 : row;
        const float main = along_x ? step[0][i] : step[1][i];
        g->forward[i] = main < 0.0f ? -major : major;
        g->minor[i] = along_x ? row : 1;
        g->slant[i] = along_x ? step[1][i] : step[0][i];
    }
}

static inline int32_t walk_group_taps(const struct walk_group *g)
{
    return 2 * (2 * g->reach_most + 1);
}

/* Step k's two taps, from -reach_most to reach_most: the walk goes through between two pixels, of
 * which each has a share of it. */
static inline void walk_place(const struct walk_group *g, int32_t k, struct walk_tap out[2])
{
    const int32_t away = k < 0 ? -k : k;
    const float step = (float)k;
    float near[SHADOW_LANES], far[SHADOW_LANES];
    int32_t to_near[SHADOW_LANES], to_far[SHADOW_LANES];
    for (uint32_t i = 0; i < SHADOW_LANES; i++) {
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

/* Lanes of `left`, not 0, whose pixels follow each other as the lanes do; *start is where lane 0's
 * would be. */
static inline __mmask16 walk_run(__m512i to, __mmask16 left, ptrdiff_t *start)
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i from = _mm512_sub_epi32(to, lane);
    const __m128i first = _mm512_castsi512_si128(_mm512_maskz_compress_epi32(left, from));
    *start = _mm_cvtsi128_si32(first);
    return _mm512_mask_cmpeq_epi32_mask(left, from, _mm512_broadcastd_epi32(first));
}

/* out[n][i]: what plane n has at pixel to[i]. */
static inline __attribute__((always_inline)) void walk_fetch(const float *const *planes,
                                                             size_t count,
                                                             const int32_t to[SHADOW_LANES],
                                                             float out[][SHADOW_LANES])
{
    const __m512i pixels = _mm512_loadu_si512(to);
    ptrdiff_t start;
    __mmask16 left = 0xffff, run = walk_run(pixels, left, &start);
    for (size_t n = 0; n < count; n++)
        _mm512_storeu_ps(out[n], _mm512_maskz_loadu_ps(run, planes[n] + start));
    while ((left &= (__mmask16)~run) != 0) {
        run = walk_run(pixels, left, &start);
        for (size_t n = 0; n < count; n++) {
            const __m512 others = _mm512_loadu_ps(out[n]);
            _mm512_storeu_ps(out[n], _mm512_mask_loadu_ps(others, run, planes[n] + start));
        }
    }
}

static inline void walk_mark(const struct walk_tap *tap, uint8_t *marks)
{
    const __m512i to = _mm512_loadu_si512(tap->to);
    const __m128i ones = _mm_set1_epi8(1);
    for (__mmask16 left = 0xffff, run; left != 0; left &= (__mmask16)~run) {
        ptrdiff_t start;
        run = walk_run(to, left, &start);
        _mm_mask_storeu_epi8(marks + start, run, ones);
    }
}

#else

#ifdef __AVX2__

/* The same of eight lanes, of which `left` are set, in a vector's lanes. */
static inline __m256i walk_run(__m256i to, __m256i left, ptrdiff_t *start)
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const uint32_t first =
        (uint32_t)__builtin_ctz((uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(left)));
    const __m256i from = _mm256_sub_epi32(to, lane);
    const __m256i all = _mm256_permutevar8x32_epi32(from, _mm256_set1_epi32((int32_t)first));
    *start = _mm256_cvtsi256_si32(all);
    return _mm256_and_si256(left, _mm256_cmpeq_epi32(from, all));
}

static inline __attribute__((always_inline)) void walk_fetch_eight(const float *const *planes,
                                                                   size_t count, size_t half,
                                                                   const int32_t to[SHADOW_LANES],
                                                                   float out[][SHADOW_LANES])
{
    const __m256i pixels = _mm256_loadu_si256((const __m256i *)(const void *)(to + half));
    ptrdiff_t start;
    __m256i left = _mm256_set1_epi32(-1), run = walk_run(pixels, left, &start);
    if (_mm256_testc_si256(run, left)) { /* all: the common case */
        for (size_t n = 0; n < count; n++)
            _mm256_storeu_ps(out[n] + half, _mm256_loadu_ps(planes[n] + start));
        return;
    }
    for (size_t n = 0; n < count; n++)
        _mm256_storeu_ps(out[n] + half, _mm256_maskload_ps(planes[n] + start, run));
    for (;;) {
        left = _mm256_andnot_si256(run, left);
        if (_mm256_testz_si256(left, left)) break;
        run = walk_run(pixels, left, &start);
        for (size_t n = 0; n < count; n++) {
            const __m256 others = _mm256_loadu_ps(out[n] + half);
            const __m256 more = _mm256_maskload_ps(planes[n] + start, run);
            _mm256_storeu_ps(out[n] + half, _mm256_or_ps(others, more)); /* 0 where they are not */
        }
    }
}

static inline __attribute__((always_inline)) void walk_fetch(const float *const *planes,
                                                             size_t count,
                                                             const int32_t to[SHADOW_LANES],
                                                             float out[][SHADOW_LANES])
{
    walk_fetch_eight(planes, count, 0, to, out);
    walk_fetch_eight(planes, count, SHADOW_LANES / 2, to, out);
}

#else

static inline __attribute__((always_inline)) void walk_fetch(const float *const *planes,
                                                             size_t count,
                                                             const int32_t to[SHADOW_LANES],
                                                             float out[][SHADOW_LANES])
{
    for (uint32_t first = 0; first < SHADOW_LANES; first += 4) {
        const int32_t *at = to + first;
        const int follows = (at[1] == at[0] + 1) & (at[2] == at[0] + 2) & (at[3] == at[0] + 3);
        for (size_t n = 0; n < count; n++) {
            const float *plane = planes[n];
            float four[4] = {plane[at[0]], 0, 0, 0};
            if (follows)
                memcpy(four, plane + at[0], sizeof four);
            else
                for (uint32_t i = 1; i < 4; i++) four[i] = plane[at[i]];
            memcpy(out[n] + first, four, sizeof four);
        }
    }
}

#endif

static inline void walk_mark(const struct walk_tap *tap, uint8_t *marks)
{
    for (uint32_t i = 0; i < SHADOW_LANES; i++) marks[tap->to[i]] = 1;
}

#endif
