#pragma once
/* Sends paths to light that comes through glass or from mirrors.
 *
 * Light samples do not reach lamps in glass and shades, nor a sky behind panes, nor what lenses and
 * mirrors gather, since shadow rays end there. Only paths find such light, by chance, and a picture
 * of few samples shows specks. So from diffuse and rough surfaces some paths are sent towards it:
 * into the sphere of a lamp (glazing.h), to where the sky is bright and seen (sky_guide.h), or to
 * where photons came from (caustics.h). They go through the glass as all paths do, bent by it or
 * scattered. A direction's density is that of all ways of choosing it together (Veach and Guibas
 * 1995, the one-sample model), so the mean of pictures does not change, and no path weighs more
 * than 1 / (1 - GUIDE_SHARE_MAX) times what it did. Directions and places are the world's. */
#include "worker/trace/path/path.h"

/* The largest share of a surface's paths that is sent. */
#define GUIDE_SHARE_MAX 0.6f

/* The maps of photons. */
enum { GUIDE_SKY, GUIDE_LAMPS, GUIDE_CAUSTICS };

/* Of sixteen surfaces. */
struct path_guide {
    _Alignas(LANES_ALIGN) float share[LANES]; /* of their paths that are sent */
    _Alignas(LANES_ALIGN) float sky[LANES];   /* of these to the sky; the rest go to lamps: */
    uint32_t table[LANES];                    /* the sky's behind glass, where that is above 0 */
    float lamps[EMITTER_GROUPS][LANES];
    _Alignas(LANES_ALIGN) float caustic[GUIDE_CAUSTICS][LANES]; /* to lenses and mirrors: */
    const struct photon_leaf *leaf[GUIDE_CAUSTICS][LANES];      /* where that is above 0 */
    struct lanes_mask sent;
    struct lanes3 direction; /* of those */
};

/* Returns whether the context's scene has light behind glass, or gathered by mirrors. */
bool path_guide_is_needed(const struct path_context *c);

/* Finds where to send paths from the surfaces of *v, whose light samples are taken. Returns whether
 * any is to be sent. */
bool path_guide_find(const struct path_context *c, const struct path_vertex *v,
                     struct path_guide *g);

/* Chooses the paths that are sent, by u, and their directions. u and w then are uniform numbers for
 * the others. */
void path_guide_aim(const struct path_context *c, const struct path_packet *p,
                    const struct path_vertex *v, struct path_guide *g, float u[LANES],
                    float w[LANES]);

/* Turns the paths that are sent, and sets the weights and promises of all. */
void path_guide_turn(const struct path_context *c, const struct path_vertex *v,
                     const struct path_guide *g, struct path_scattering *s);
