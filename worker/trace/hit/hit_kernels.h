#pragma once
/* The inner loops over sixteen rays and what they meet. */
#include "proto/runtime/kernels.h"
#include "worker/trace/hit/geometry.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/hit/texels.h"

struct hit_kernels {
    /* Sets rays through positions (px, py) of the image, as plan_camera_ray does. */
    void (*camera_rays)(const struct plan *plan, const float *px, const float *py,
                        struct RTCRay16 *rays);

    /* Computes where anti-aliasing ray k of the block's pixels goes through the image. */
    void (*place_subs)(const struct pattern_pixels *pattern, const struct block *b, uint32_t k,
                       float *px, float *py);

    /* Sets rays through pixels' centres, and the valid lanes, of blocks side by side, the first at
     * (x, y). Returns how many rays Embree cannot take. */
    uint32_t (*camera_row)(const struct plan *plan, int32_t x, int32_t y, uint32_t count,
                           struct primary_packet *row);

    /* Clears the lanes of *valid that Embree cannot take, and returns their number. */
    uint32_t (*sanitise)(const struct RTCRay16 *rays, struct lanes_mask *valid);

    /* Does hit_resolve. */
    void (*resolve_hits)(const struct queries *q, const struct lanes_mask *valid,
                         const struct RTCRayHit16 *rays, struct surface *out);

    /* Computes where a texture is read at the mesh's (u, v). */
    void (*place_texels)(const struct texture *t, const float *u, const float *v,
                         struct texel_lanes *out);

    /* Turns raw vectors into what hit.h promises: facet and normal unit and facing the ray, origins
     * off the surface by offset.h of `magnitude`. `flat`: all normals are those of facets. */
    void (*finish_surface)(const struct RTCRay16 *rays, const float *magnitude, bool flat,
                           struct surface *s);

    /* Does geometry_store for a block in which something was hit. */
    void (*store_geometry)(const struct block *b, const struct surface *s,
                           const struct geometry_planes *planes);

    /* Do geometry_store_sub in two steps: depths over the centre's, less 1; then, when these have
     * become halves, all planes. */
    void (*relate_depths)(const struct surface *centre, const struct surface *sub,
                          float length_unit, float *relative);
    void (*store_sub)(const struct block *b, const struct surface *s, const uint16_t *depth,
                      const struct geometry_sub_planes *planes);

    /* Does octahedron_pack16, or octahedron_pack8, for each lane: `bits` a coordinate. */
    void (*pack_normals)(const struct lanes3 *normal, uint32_t bits, uint32_t *packed);

    /* Packs values in [0, 1] as 16-bit unorms; values outside are clamped. */
    void (*pack_unorms)(const float *v, uint16_t *packed);
};

/* One for each instruction set (kernels.h). All compute the same bits: no contraction into fused
 * multiply-adds, no approximate reciprocals. */
extern const struct hit_kernels hit_kernels_sse42, hit_kernels_avx2, hit_kernels_avx512;
