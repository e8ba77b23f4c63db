#pragma once
/* Active paths, sixteen side by side, and the radiance that they have collected.
 *
 * A batch is up to PATH_SAMPLES samples of the sixteen pixels of a block. After each scattering the
 * paths that go on are packed together, in their order, so that packets stay full while paths end.
 * A path's numbers do not depend on which packet it travels in. */
#include "worker/trace/hit/block.h"
#include "worker/trace/hit/hit.h"
#include "worker/trace/hit/queries.h"

#define PATH_SAMPLES 16
#define PATH_SLOTS   (PATH_SAMPLES * LANES) /* slot = sample of the batch * LANES + pixel's lane */

/* What a path's light belongs to since it has met what the photograph shows
 * (path_photograph.h): nothing but the path; the part with, or without objects. An arriving path
 * is of the latter, and what the segment itself meets is another's. */
enum path_part {
    PATH_PART_NONE = 0,
    PATH_PART_WITH = 1,
    PATH_PART_WITHOUT = 2,
    PATH_PART_ARRIVING = 3
};

/* The next segment of up to sixteen paths: lanes 0 .. count - 1. */
struct path_packet {
    struct RTCRayHit16 rays; /* unit directions; a path's time is that of all its rays */
    struct lanes3 throughput;
    _Alignas(LANES_ALIGN) float pdf[LANES]; /* of the direction, per solid angle, where a light
                                               sample could have found it too; 0: it could not */
    /* How many times as often the path went this way as its surface's lobes would have sent it: a
     * path that was sent to a light (path_guide.h) is worth so much more than its throughput until
     * it comes out of the glass. */
    _Alignas(LANES_ALIGN) float promise[LANES];
    _Alignas(LANES_ALIGN) uint32_t sky_table[LANES]; /* that such a sample of the sky is from */
    _Alignas(LANES_ALIGN) float sky_share[LANES];    /* the probability of such a sample */
    _Alignas(LANES_ALIGN) float lights[LANES]; /* the weight of all lights in the choice of one */
    struct lanes3 from, normal; /* origin and normal of the surface that sent it, by which its light
                                   sample was chosen */
    _Alignas(LANES_ALIGN) uint32_t key[LANES]; /* pattern_path.h: pixel and sample */
    _Alignas(LANES_ALIGN) uint32_t sample[LANES];
    _Alignas(LANES_ALIGN) uint32_t slot[LANES];
    uint8_t colored[LANES];     /* 1: only one colour is on its way, and stands for all three */
    uint8_t part[LANES];        /* enum path_part */
    uint8_t from_object[LANES]; /* 1: a virtual object sent it; only of composites */
    uint32_t count;
};

struct path_pool {
    struct path_packet packets[PATH_SAMPLES];
    uint32_t count; /* paths in all */
};

struct path_rgb {
    _Alignas(LANES_ALIGN) float r[PATH_SLOTS];
    _Alignas(LANES_ALIGN) float g[PATH_SLOTS];
    _Alignas(LANES_ALIGN) float b[PATH_SLOTS];
};

/* What paths have met of the photograph, by slot. */
struct path_shown {
    struct path_rgb throughput;    /* of the path until there */
    struct path_rgb light;         /* throughput * photograph */
    struct path_rgb with, without; /* what the path brings from there on, of throughput 1 */
    bool ends_chain[PATH_SLOTS];   /* what was met ends a chain (chains.h) */
    uint8_t depth[PATH_SLOTS];     /* scatterings before; 0: nothing was met */
};

/* The radiance that the batch's paths have collected, by slot. */
struct path_radiance {
    struct path_rgb emission, direct, indirect;
    struct path_rgb diffuse_direct, diffuse_indirect; /* only when demodulated */
    struct path_rgb share; /* of what comes after the first scattering: its diffuse part over
                              albedo; only when demodulated */
    struct path_rgb kept;  /* of what comes after the first scattering: the part that is no light
                              field's; only when paths leave indirect light to one */
    struct path_rgb albedo;
    struct path_rgb normal; /* shading normal of what the lens sees; only when demodulated */
    struct path_rgb tint;   /* colour of what the lens sees in all lobes but the diffuse one; only
                               for features */
    _Alignas(LANES_ALIGN) float alpha[PATH_SLOTS]; /* its roughness; the same */
    struct path_rgb lobe; /* directional albedo of the glossy lobe whose light fields of the lens
                             bring, too; 0: none */
    uint32_t chain[PATH_SLOTS];    /* Dirac scatterings before the surface that features tell of
                                      (chains.h) */
    bool strayed[PATH_SLOTS];      /* the path left a chain's likelier way */
    uint32_t mirrored[PATH_SLOTS]; /* reflections before the first surface; only where contexts have
                                      mirrors */
    _Alignas(LANES_ALIGN) float own[PATH_SLOTS];    /* 1: brings all the light, also what
                                                       fields beside would */
    _Alignas(LANES_ALIGN) float listed[PATH_SLOTS]; /* path_vertex's, of the first surface */
    _Alignas(LANES_ALIGN) float coverage[PATH_SLOTS];
    _Alignas(LANES_ALIGN) float occlusion[PATH_SLOTS];
    _Alignas(LANES_ALIGN) float distance[PATH_SLOTS]; /* of paths that begin on surfaces, to their
                                                         first hit: > 0; INFINITY: they met nothing;
                                                         0: not traced. Of camera paths, for
                                                         features: 0: they met nothing */
    _Alignas(LANES_ALIGN) float ahead[PATH_SLOTS];    /* how far ahead of the lens its paths meet
                                                         something; the same numbers */
    struct path_shown shown;                          /* last; only with a photograph */
};

/* Sets the fields that no query changes. */
void path_pool_init(struct path_pool *pool);

/* Returns the packet of the next path, and its lane, which the caller fills. */
static inline struct path_packet *path_pool_add(struct path_pool *pool, uint32_t *lane)
{
    struct path_packet *packet = &pool->packets[pool->count / LANES];
    *lane = pool->count++ % LANES;
    packet->count = *lane + 1;
    return packet;
}

/* A path that begins on one of sixteen surfaces. Its pdf is 0, since no light sample was taken that
 * could have found the same direction. */
struct path_start {
    const struct surface *surface;
    const struct lanes3 *direction;
    float weight[3]; /* of what it brings */
    float reach;
    uint32_t key, sample, slot;
};

/* Adds lane i's path to the pool. */
static inline void path_pool_begin(struct path_pool *pool, const struct path_start *s, int i)
{
    uint32_t lane;
    struct path_packet *p = path_pool_add(pool, &lane);
    struct RTCRay16 *r = &p->rays.ray;
    const struct vector start =
        surface_start(s->surface, i, s->direction->x[i], s->direction->y[i], s->direction->z[i]);
    r->org_x[lane] = start.x;
    r->org_y[lane] = start.y;
    r->org_z[lane] = start.z;
    r->dir_x[lane] = s->direction->x[i];
    r->dir_y[lane] = s->direction->y[i];
    r->dir_z[lane] = s->direction->z[i];
    r->tnear[lane] = 0.0f;
    r->tfar[lane] = s->reach;
    r->time[lane] = SHUTTER_MIDDLE_TIME;
    p->throughput.x[lane] = s->weight[0];
    p->throughput.y[lane] = s->weight[1];
    p->throughput.z[lane] = s->weight[2];
    p->pdf[lane] = 0.0f;
    p->promise[lane] = 1.0f;
    p->sky_table[lane] = 0;
    p->sky_share[lane] = p->lights[lane] = 0.0f;
    p->key[lane] = s->key;
    p->sample[lane] = s->sample;
    p->slot[lane] = s->slot;
    p->colored[lane] = 0;
    p->part[lane] = PATH_PART_NONE;
    p->from_object[lane] = 0;
}

static inline uint32_t path_pool_packets(const struct path_pool *pool)
{
    return (pool->count + LANES - 1) / LANES;
}

static inline void path_packet_lanes(const struct path_packet *p, struct lanes_mask *valid)
{
    for (int i = 0; i < LANES; i++) valid->on[i] = -(i < (int)p->count);
}
