#pragma once
/* What pixel centres in and around a tile show, for lens samples to tell whether one of them shows
 * the same point: light fields then light the sample, and its path need not look for that light.
 *
 * Centres are traced when first asked for, a block at a time as for any tile, so that the answer
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

/* Around a tile of the context's plan. ERR_MEMORY. */
int centre_gbuffer_init(struct centre_gbuffer *out, const struct path_context *c, struct rect tile);
void centre_gbuffer_fini(struct centre_gbuffer *centres);

/* Which of the camera paths' first surfaces light fields light for sure: the pixel whose middle
 * lies nearest shows the same surface, well within what reconstruction asks for
 * (server/reconstruct/patch/surface.h: half as far off the pixel's plane at most, and normals up to
 * 8 degrees apart, not 10), of depths and slopes as they travel. */
struct glossy_lobes;

/* Of `lobes`, those of these surfaces, only lanes stay on whose lobe fields light, too: the
 * centre's is about as wide, and wide beside the angle in which the surface sees the lens. Light
 * that a lobe sends to a point of the lens then differs from what it sends to the middle by no more
 * than the lobe's own width lets it. */
void centre_gbuffer_match(struct centre_gbuffer *centres, const struct path_packet *p,
                          const struct path_vertex *v, struct glossy_lobes *lobes,
                          struct lanes_mask *lit);
