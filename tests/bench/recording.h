#pragma once
/* Rays as the worker asked for them, replayed through nothing but Embree calls, for benchmarks.
 * Replayed rays lie ready in cache; copying them there is not timed. */
#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "tests/bench/timing.h"
#include "worker/trace/hit/queries.h"

enum { CHUNK = 2048 };

#define MXCSR_FLUSH 0x8040u

/* Rays of one kind in the order in which they were asked, sixteen lanes a packet; `count` lanes are
 * on. Lanes that are off have a mask of 0. */
struct recording {
    struct RTCRay *rays;
    size_t lanes, count, capacity;
};

struct recorder {
    struct query_recorder base;
    struct recording kinds[QUERY_KIND_COUNT];
};

static inline void fail(const char *text)
{
    fprintf(stderr, "bench_rays: %s\n", text);
    exit(1);
}

static void recording_add(struct recording *r, const struct RTCRay *ray)
{
    if (r->lanes == r->capacity) {
        size_t capacity = r->capacity ? 2 * r->capacity : 65536;
        struct RTCRay *grown = aligned_alloc(64, capacity * sizeof *grown);
        if (!grown) fail("no memory for the recording");
        if (r->lanes) memcpy(grown, r->rays, r->lanes * sizeof *grown);
        free(r->rays);
        r->rays = grown;
        r->capacity = capacity;
    }
    r->rays[r->lanes++] = *ray;
    if (ray->mask) r->count++;
}

static void record(struct query_recorder *self, enum query_kind kind,
                   const struct lanes_mask *valid, const struct RTCRayHit16 *q)
{
    struct recorder *recorder = (struct recorder *)self;
    const struct RTCRay16 *r = &q->ray;
    for (int i = 0; i < LANES; i++) {
        struct RTCRay ray = {.mask = 0};
        if (valid->on[i])
            ray = (struct RTCRay){r->org_x[i], r->org_y[i], r->org_z[i], r->tnear[i],
                                  r->dir_x[i], r->dir_y[i], r->dir_z[i], 0.0f,
                                  r->tfar[i],  r->mask[i],  0,           0};
        recording_add(&recorder->kinds[kind], &ray);
    }
}

/* A chunk of rays in the three layouts that Embree takes. */
struct chunk {
    struct RTCRayHit16 hits16[CHUNK / 16];
    struct RTCRay16 rays16[CHUNK / 16];
    struct RTCRayHit8 hits8[CHUNK / 8];
    struct RTCRay8 rays8[CHUNK / 8];
    struct RTCRayHit hits1[CHUNK];
    struct RTCRay rays1[CHUNK];
    _Alignas(64) int valid[CHUNK];
};

#define FILL(to, lane, ray)                                                                        \
    do {                                                                                           \
        (to).org_x[lane] = (ray).org_x, (to).org_y[lane] = (ray).org_y;                            \
        (to).org_z[lane] = (ray).org_z, (to).tnear[lane] = (ray).tnear;                            \
        (to).dir_x[lane] = (ray).dir_x, (to).dir_y[lane] = (ray).dir_y;                            \
        (to).dir_z[lane] = (ray).dir_z, (to).time[lane] = 0.0f;                                    \
        (to).tfar[lane] = (ray).tfar, (to).mask[lane] = (ray).mask;                                \
        (to).id[lane] = (to).flags[lane] = 0;                                                      \
    } while (0)

enum layout { LAYOUT_ASKED, LAYOUT_16, LAYOUT_8, LAYOUT_STREAM, LAYOUT_COUNT };
static const char *const layout_names[] = {"packets as asked", "packets of 16", "packets of 8",
                                           "streams"};

/* Lays out the rays in c->rays1 as one layout needs them. */
static void chunk_lay_out(struct chunk *c, bool closest, enum layout layout)
{
    for (int i = 0; i < CHUNK; i++) {
        const struct RTCRay *ray = &c->rays1[i];
        c->valid[i] = ray->mask ? -1 : 0;
        if (layout <= LAYOUT_16 && closest) FILL(c->hits16[i / 16].ray, i % 16, *ray);
        if (layout <= LAYOUT_16 && !closest) FILL(c->rays16[i / 16], i % 16, *ray);
        if (layout == LAYOUT_8 && closest) FILL(c->hits8[i / 8].ray, i % 8, *ray);
        if (layout == LAYOUT_8 && !closest) FILL(c->rays8[i / 8], i % 8, *ray);
        if (layout == LAYOUT_STREAM && closest) {
            memset(&c->hits1[i].hit, 0xff, sizeof c->hits1[i].hit);
            c->hits1[i].ray = *ray;
        }
    }
    if (layout <= LAYOUT_16 && closest)
        for (int i = 0; i < CHUNK / 16; i++)
            memset(&c->hits16[i].hit, 0xff, sizeof c->hits16[i].hit);
    if (layout == LAYOUT_8 && closest)
        for (int i = 0; i < CHUNK / 8; i++) memset(&c->hits8[i].hit, 0xff, sizeof c->hits8[i].hit);
}

/* The next chunk of a recording from lane *at on, with the gaps between asked rays or without. How
 * many rays are on; 0 when too few are left. */
static size_t chunk_fill(struct chunk *c, const struct recording *r, bool closest,
                         enum layout layout, size_t *at)
{
    size_t n = 0, on = 0;
    bool gaps = layout == LAYOUT_ASKED;
    for (; n < CHUNK && *at < r->lanes; ++*at)
        if (gaps || r->rays[*at].mask) {
            c->rays1[n++] = r->rays[*at];
            on += r->rays[*at].mask != 0;
        }
    if (n < CHUNK) return 0;
    chunk_lay_out(c, closest, layout);
    return on;
}

static void replay(const struct render_scene *render, struct chunk *c, bool closest, bool coherent,
                   enum layout layout)
{
    RTCScene scene = render->top;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    /* worker/trace/hit/queries.c says why instances go without the hint */
    if (coherent && (closest || !render->has_instances))
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    if (layout <= LAYOUT_16 && closest)
        for (int i = 0; i < CHUNK / 16; i++)
            rtcIntersect16(c->valid + (size_t)16 * (size_t)i, scene, &context, &c->hits16[i]);
    else if (layout <= LAYOUT_16)
        for (int i = 0; i < CHUNK / 16; i++)
            rtcOccluded16(c->valid + (size_t)16 * (size_t)i, scene, &context, &c->rays16[i]);
    else if (layout == LAYOUT_8 && closest)
        for (int i = 0; i < CHUNK / 8; i++)
            rtcIntersect8(c->valid + (size_t)8 * (size_t)i, scene, &context, &c->hits8[i]);
    else if (layout == LAYOUT_8)
        for (int i = 0; i < CHUNK / 8; i++)
            rtcOccluded8(c->valid + (size_t)8 * (size_t)i, scene, &context, &c->rays8[i]);
    else if (closest)
        for (int i = 0; i < CHUNK; i += 1024)
            rtcIntersect1M(scene, &context, &c->hits1[i], 1024, sizeof c->hits1[0]);
    else
        for (int i = 0; i < CHUNK; i += 1024)
            rtcOccluded1M(scene, &context, &c->rays1[i], 1024, sizeof c->rays1[0]);
}

/* How far a recording has been replayed in one layout, and how long Embree alone took for that. */
struct progress {
    size_t lane, rays;
    double cpu_s;
};

/* Replays the next chunk; nothing when too few rays are left. */
static inline void replay_chunk(const struct render_scene *scene, struct chunk *c,
                                const struct recording *r, bool closest, bool coherent,
                                enum layout layout, struct progress *p)
{
    size_t on = chunk_fill(c, r, closest, layout, &p->lane);
    if (on == 0) return;
    unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    double start = cpu_s();
    replay(scene, c, closest, coherent, layout);
    p->cpu_s += cpu_s() - start;
    p->rays += on;
    _mm_setcsr(mode);
}
