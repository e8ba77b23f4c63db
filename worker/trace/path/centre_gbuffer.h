#pragma once
/* The G-buffer of pixel centres in and around a tile. A lens sample whose point a pixel centre
 * shows is lit by that pixel's light fields, and its path need not bring that light.
 *
 * Centres are traced at the first lookup, in the same blocks as for any tile, so that the result
 * does not depend on the tile. */
#include "worker/trace/path/path.h"

struct centre_gbuffer {
    struct rect cells;             /* blocks: image pixels over LANES_ACROSS */
    bool *traced;                  /* of each cell */
    struct gbuffer_pixel *centres; /* of each cell LANES */
    struct path_context context;   /* of pixel centres */
    struct RTCRayHit16 rays;
    struct path_vertex vertex;
    struct block block;
    void *memory; /* owned */
};

/* Creates an empty G-buffer around a tile of the context's plan. ERR_MEMORY. */
int centre_gbuffer_init(struct centre_gbuffer *out, const struct path_context *c, struct rect tile);
void centre_gbuffer_fini(struct centre_gbuffer *centres);

struct glossy_lobes;

/* Sets the lanes of *lit whose first surface is lit by light fields for sure. The nearest pixel
 * centre must show the same surface, by depths and slopes as they are sent. The bounds are tighter
 * than those of reconstruction (proto/surface_match.h): half the distance from the pixel's plane,
 * and normals up to 8 degrees apart instead of 10.
 *
 * Clears the lanes of `lobes` whose glossy lobe the fields do not light. The centre's lobe must be
 * about as wide, and wide beside the angle in which the surface sees the lens. Light that the lobe
 * sends to a point of the lens then differs from that to the centre by no more than the width of
 * the lobe allows. */
void centre_gbuffer_match(struct centre_gbuffer *centres, const struct path_packet *p,
                          const struct path_vertex *v, struct glossy_lobes *lobes,
                          struct lanes_mask *lit);
