#pragma once
/* The path tracer: what one batch of samples of a block brings back.
 *
 *   camera ray -> surface -> [light sample + shadow ray] -> scatter -> surface -> ...
 *
 * At every surface one point of one light is tried (light_choice.h) and one direction is scattered
 * into; where both could have found the same light, they are weighted by the power heuristic (Veach
 * and Guibas 1995, "Optimally combining sampling techniques", section 5.1, exponent 2). Lights
 * without extent and the Dirac lobes of mirrors and clear glass know one way only. What arrives
 * after one scattering is direct light, after more indirect.
 *
 * Rectangles of the plan shine on scattered rays whether or not geometry stands for them: they are
 * met analytically, and emission of geometry that stands for one is not counted again. The camera
 * sees geometry only. */
#include <stdatomic.h>

#include "worker/scene/light_table.h"
#include "worker/scene/photograph.h"
#include "worker/shade/bsdf.h"
#include "worker/trace/hit/hit.h"
#include "worker/trace/light/light.h"
#include "worker/trace/light/sky.h"
#include "worker/trace/path/layers.h"
#include "worker/trace/path/mirrors.h"
#include "worker/trace/path/path_pool.h"

struct centre_gbuffer;
struct light_kernels;
struct path_kernels;
struct path_record;

/* What paths leave out at the first surface, because light fields bring it. */
enum path_skip {
    SKIP_DIFFUSE = 1,          /* what diffuse lobes send on, and emission that the camera sees */
    SKIP_DIFFUSE_INDIRECT = 2, /* indirect light of diffuse lobes */
    SKIP_GLOSSY_INDIRECT = 4,  /* that of glossy lobes; beside SKIP_DIFFUSE_INDIRECT */
    SKIP_GLOSSY_OF_LENS = 8,   /* that of glossy lobes whose reflectance is path_radiance.lobe */
    SKIP_SOFT_SKY = 16,        /* the soft share of the sky, through a lens; beside
                                  SKIP_DIFFUSE_INDIRECT */
    SKIP_SKY_FIELD = 64,       /* the same beside fields without a lens */
    SKIP_LISTED = 32 /* direct light of the plan's lights on diffuse lobes, and surfaces that
                        the camera sees shine */
};

/* What all paths of a tile share. */
struct path_context {
    struct queries *queries;
    const struct light_kernels *light_kernels;
    const struct path_kernels *kernels;
    const struct light_table *lights;
    const struct sky *sky;
    const struct plan *plan;
    const struct photograph *photograph; /* that objects see; NULL: none */
    struct counters *counters;
    bool demodulate;         /* the plan wants the diffuse planes */
    float turn_least;        /* struct bsdf's, of surfaces that the camera sees */
    bool guided;             /* some light comes through glass or from mirrors (path_guide.h) */
    bool blended;            /* some surface is there by chance: rays need keys */
    bool has_emission;       /* rays can meet emission: of surfaces, rectangles or the sky */
    bool has_other_emission; /* rays from surfaces that fields light can meet emission that fields
                                do not bring */
    bool lights_only;        /* the plan's lights are all that emits */
    uint32_t skip;           /* bits of enum path_skip */
    bool lens;               /* camera paths are those of the lens's light field */
    struct centre_gbuffer *centres; /* what light fields light of the lens's paths; or NULL */
    uint32_t edge_digits;           /* of the plan, where paths are of pixels at edges; else 0 */
    bool seen_only;                 /* paths end at what the camera sees */
    bool chains;     /* features are of what mirrors and clear glass show (chains.h) */
    bool features;   /* depths and normals of first surfaces are noted */
    bool field;      /* paths begin on surfaces, scattered once: the field of indirect light */
    uint32_t strata; /* l of the field's bounce rays */
    const uint8_t *strata_map; /* l of each pixel (plan_pass); NULL: `strata` */
    const uint8_t *lobes;      /* the same for rays of glossy lobes; NULL: `strata` */
    uint32_t pass;             /* each pass has random numbers of its own */
    bool mirrors; /* paths may have been reflected by flat mirrors (mirrors.h), which are counted */
    _Atomic uint64_t *progress; /* grows within blocks of many samples; may be NULL */
    const _Atomic bool *stop;   /* once true, blocks are left incomplete; may be NULL */
    struct path_record *record; /* of the only path on its way; NULL except in a replay */
};

/* Returns the pattern of the context's pass. Later passes have random numbers of another seed. */
static inline struct pattern path_pass_pattern(const struct path_context *c)
{
    struct pattern out = c->plan->pattern;
    if (c->pass > 0) out.seed ^= c->pass * 0x9e3779b97f4a7c15u;
    return out;
}

/* Weights of all that a light sample may choose, but the environment: bounds of what each sends to
 * sixteen surfaces. */
struct light_weights {
    _Alignas(LANES_ALIGN) float of[LIGHT_CHOICES][LANES]; /* of those that there are */
    _Alignas(LANES_ALIGN) float total[LANES];
};

/* One surface of sixteen paths, or of sixteen pixels. */
struct path_vertex {
    uint32_t depth;           /* scatterings before it */
    struct lanes_mask active; /* paths that are still on their way */
    struct surface surface;
    struct mirrors mirrors;    /* of camera rays, where the context looks through mirrors */
    struct lanes_mask lambert; /* active lanes that are pure Lambert; the others have a bsdf */
    /* Only of first surfaces where contexts leave light of the plan's lights: where fields bring
     * that of the diffuse lobe, and the share of these lights' power that counts where a light is
     * chosen. */
    struct lanes_mask left;
    _Alignas(LANES_ALIGN) float listed[LANES];
    bool any_lambert, any_general;
    _Alignas(LANES_ALIGN) uint32_t sky_table[LANES]; /* of the sky's guide; only with a map */
    struct light_weights weights;                    /* where there is a choice of lights */
    _Alignas(LANES_ALIGN) float sky_share[LANES];    /* probability of the map's; the same */
    struct lanes_mask last; /* ends here: its light sample stands for all direct light */
    struct bsdf bsdf[LANES];
    struct layers layers;             /* of lanes with a bsdf, once a path is about to go on */
    struct lanes3 tangent, bitangent; /* of lanes with a bsdf */
    struct lanes3 back; /* towards the path's origin, in the shading frame; of lanes with a bsdf */
    const struct path_vertex
        *far;    /* translucent lanes as light from behind finds them (path_far_find);
                    NULL: there are none. Only of vertices of paths */
    bool is_far; /* it is such a one: frame and bsdf are the near side's */
};

/* Turn a vector of the world into the shading frame of lane i, which has a bsdf, and back. */
static inline void path_to_frame(const struct path_vertex *v, int i, const float d[3], float out[3])
{
    const struct lanes3 *t = &v->tangent, *b = &v->bitangent, *n = &v->surface.normal;
    out[0] = d[0] * t->x[i] + d[1] * t->y[i] + d[2] * t->z[i];
    out[1] = d[0] * b->x[i] + d[1] * b->y[i] + d[2] * b->z[i];
    out[2] = d[0] * n->x[i] + d[1] * n->y[i] + d[2] * n->z[i];
}

static inline void path_from_frame(const struct path_vertex *v, int i, const float w[3],
                                   float out[3])
{
    const struct lanes3 *t = &v->tangent, *b = &v->bitangent, *n = &v->surface.normal;
    out[0] = w[0] * t->x[i] + w[1] * b->x[i] + w[2] * n->x[i];
    out[1] = w[0] * t->y[i] + w[1] * b->y[i] + w[2] * n->y[i];
    out[2] = w[0] * t->z[i] + w[1] * b->z[i] + w[2] * n->z[i];
}

/* The next segment of sixteen paths. */
struct path_scattering {
    struct lanes_mask on;
    struct lanes3 direction;
    struct lanes3 weight;
    struct lanes_mask through;                  /* to the other side of the surface */
    _Alignas(LANES_ALIGN) float pdf[LANES];     /* of the surface's lobes alone */
    _Alignas(LANES_ALIGN) float promise[LANES]; /* path_packet's */
    /* What weights are made of: struct bsdf_sample's. */
    _Alignas(LANES_ALIGN) float diffuse[LANES];
    struct lanes3 specular;
};

/* A light sample of sixteen vertices. */
struct nee_sample {
    struct light_packet packet, candidate;
    struct lanes3 color; /* radiance or intensity, over the probability of the choice */
};

/* Scratch of one thread. */
struct path_scratch {
    struct path_pool pools[2];
    struct path_pool real[2]; /* paths of PATH_PART_WITHOUT */
    struct path_radiance radiance;
    struct path_vertex vertex, far;
    struct nee_sample light[2];
    struct RTCRayHit16 occlusion;
};

void path_scratch_init(struct path_scratch *s);

/* Where paths of the light field begin: after the first scattering. */
#define PATH_FIELD_DEPTH 1

/* Traces samples first .. first + count - 1, count <= PATH_SAMPLES, of the block's kept pixels into
 * s->radiance. Slots of other pixels are zero. */
void path_trace(const struct path_context *c, const struct block *b, uint32_t first, uint32_t count,
                struct path_scratch *s);

/* Traces the camera paths in s->pools[0] to their ends, into s->radiance, which begins empty. Those
 * of the lens's light field set `ahead`. */
void path_trace_camera(const struct path_context *c, struct path_scratch *s);

/* Forgets the light field's first `count` samples: `indirect` and `distance`. */
void path_radiance_clear_field(struct path_radiance *h, uint32_t count);

/* Notes how often the surfaces are mirrored that the field's first `count` samples leave. */
void path_radiance_mirrors(struct path_radiance *h, uint32_t count, const struct path_vertex *from);

/* Traces the paths in s->pools[0], which have been scattered PATH_FIELD_DEPTH times, to their ends;
 * c->field holds. Adds what they bring to `indirect` of the radiance and sets `distance`. Emission
 * at the first hit is scattered only once, so it is no indirect light. It counts where nothing else
 * would bring it: on surfaces that no light stands for, under a plan without paths. */
void path_trace_field(const struct path_context *c, struct path_scratch *s);

/* Sets `distance` of the light field's first rays, which have come back. */
void path_note_reach(const struct path_packet *p, const struct lanes_mask *valid,
                     struct path_radiance *h);

/* Finds what the surfaces in the lanes of v->active do to light: which are pure Lambert, the
 * others' BSDF and shading frame, and their diffuse albedo in v->surface. `rays` met the
 * surface. */
void path_resolve(const struct path_context *c, const struct RTCRayHit16 *rays,
                  struct path_vertex *v);

/* Returns whether lane i has a bsdf that transmits one colour at a time. */
static inline bool path_is_dispersed(const struct path_vertex *v, int i)
{
    return v->active.on[i] && !v->lambert.on[i] && v->bsdf[i].dispersed;
}

/* Finds the far sides of translucent surfaces. Light that falls on them comes out on the near side,
 * where the path is, so light samples are taken there as well. Sets *far to the translucent lanes
 * of *v, seen from behind: there normals face away from the path, and rays start behind the
 * surface. Returns whether there are any. */
bool path_far_find(const struct path_vertex *v, struct path_vertex *far);

/* The largest chance of going on, so that even a path through white surfaces ends at last. */
#define PATH_ROULETTE_MAX 0.98f

/* Reports progress between batches of a block's samples, which may be many seconds' work. False:
 * stop. */
static inline bool path_goes_on(const struct path_context *c)
{
    if (c->progress) atomic_fetch_add_explicit(c->progress, 1, memory_order_relaxed);
    return !c->stop || !atomic_load_explicit(c->stop, memory_order_relaxed);
}

/* The steps, in their order; each works on one packet. */

/* Adds a camera path of a pixel to the pool. The caller aims its ray. */
void path_begin(uint32_t key, uint32_t sample, uint32_t slot, struct path_pool *pool);

/* Returns where the plan's pixel filter puts u in [0, 1), from the pixel's edge. Paths are spread
 * by the filter and all weigh the same, so that none contributes to two pixels. */
float path_pixel_offset(const struct plan *plan, float u);

/* Adds camera paths through the pixels and the lens to the pool. */
void path_camera(const struct path_context *c, const struct block *b, uint32_t first,
                 uint32_t count, struct path_pool *pool);

/* Returns how far ahead of the lens the surface lies that camera path i of the packet meets. All
 * callers get the same bits. */
float path_ahead(const struct path_context *c, const struct path_packet *p,
                 const struct path_vertex *v, uint32_t i);

/* Notes what the contexts' readers want of surfaces that camera paths meet, which are resolved:
 * features for filters, and colours of layers. */
void path_note(const struct path_context *c, const struct path_packet *p,
               const struct path_vertex *v, struct path_radiance *h);

/* Multiplies a slot's colour by lane i's tint. */
void path_dim(struct path_rgb *color, uint32_t slot, const struct lanes3 *tint, uint32_t i);

/* Adds the emission of what the rays met: environment, rectangles, surfaces. */
void path_emission_add(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, struct path_radiance *h);

/* Adds one light sample of every active path, and sets v->sky_table, weights and sky_share. Camera
 * paths' first surfaces choose it among several. */
void path_nee_add(const struct path_context *c, const struct path_packet *p, struct path_vertex *v,
                  struct nee_sample light[2], struct path_radiance *h);

/* Scatters the active paths, whose next segments go to `next`. */
void path_scatter(const struct path_context *c, const struct path_packet *p,
                  const struct path_vertex *v, struct path_radiance *h, struct path_pool *next);

/* Adds a contribution to direct or indirect light, by the number of its scatterings (> 0), and the
 * share of it that the first scattering sent on diffusely. Light samples of the first surface,
 * which no scattering precedes, bring their own diffuse part: their share is still zero. */
void path_radiance_add(const struct path_context *c, struct path_radiance *h, uint32_t scatterings,
                       uint32_t slot, const float value[3]);

/* Does the same for the packet's lanes in *on. */
void path_radiance_add_lanes(const struct path_context *c, struct path_radiance *h,
                             uint32_t scatterings, const struct path_packet *p,
                             const struct lanes_mask *on, const struct lanes3 *value);
