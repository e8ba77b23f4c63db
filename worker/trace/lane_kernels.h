#pragma once
/* The inner loops over sixteen lanes, once for each instruction set. All of them compute the same
 * bits: no contraction into fused multiply-adds, no approximate reciprocals. */
#include "proto/kernels.h"
#include "proto/pattern_path.h"
#include "worker/trace/field/lone_finder.h"
#include "worker/trace/hit/geometry.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/hit/texels.h"
#include "worker/trace/light/light.h"
#include "worker/trace/light/shadow_sums.h"
#include "worker/trace/light/strata.h"
#include "worker/trace/path/path.h"

struct lane_kernels {
    /* Rays through positions (px, py) of the image, as plan_camera_ray. */
    void (*camera_rays)(const struct plan *plan, const float *px, const float *py,
                        struct RTCRay16 *rays);

    /* Where anti-aliasing ray k of the block's pixels goes through the image. */
    void (*place_subs)(const struct pattern_pixels *pattern, const struct block *b, uint32_t k,
                       float *px, float *py);

    /* Rays and valid lanes of blocks side by side, the first at (x, y), through pixels' centres;
     * returns how many of them Embree cannot take. */
    uint32_t (*camera_row)(const struct plan *plan, int32_t x, int32_t y, uint32_t count,
                           struct primary_packet *row);

    /* Lanes of *valid that Embree can take stay on; returns how many do not. */
    uint32_t (*sanitise)(const struct RTCRay16 *rays, struct lanes_mask *valid);

    /* hit_resolve. */
    void (*resolve_hits)(const struct queries *q, const struct lanes_mask *valid,
                         const struct RTCRayHit16 *rays, struct surface *out);

    /* Where a texture is read at the mesh's (u, v). */
    void (*place_texels)(const struct texture *t, const float *u, const float *v,
                         struct texel_lanes *out);

    /* Turns raw vectors into what hit.h promises: facet and normal unit and facing the ray, origins
     * off the surface by offset.h of `magnitude`. `flat`: all normals are those of facets. */
    void (*finish_surface)(const struct RTCRay16 *rays, const float *magnitude, bool flat,
                           struct surface *s);

    /* geometry_store, of a block in which something was hit. */
    void (*store_geometry)(const struct block *b, const struct surface *s,
                           const struct geometry_planes *planes);

    /* geometry_store_sub in two steps: depths over the centre's, less 1; then, when these have
     * become halves, all planes. */
    void (*relate_depths)(const struct surface *centre, const struct surface *sub,
                          float length_unit, float *relative);
    void (*store_sub)(const struct block *b, const struct surface *s, const uint16_t *depth,
                      const struct geometry_sub_planes *planes);

    /* octahedron_unpack16 of each lane; and p->alike, p->open and p->settled of lone_finder.h,
     * which returns whether any lane is open. */
    void (*unpack_normals)(const uint32_t *packed, struct lanes3 *out);
    bool (*match_subs)(const struct surface_view *view, const struct lanes_mask *kept,
                       struct lone_pixels *p);

    /* octahedron_pack16 of each lane, or octahedron_pack8: `bits` a coordinate. */
    void (*pack_normals)(const struct lanes3 *normal, uint32_t bits, uint32_t *packed);

    /* Values in [0, 1] as 16-bit unorms; what is outside is clamped. */
    void (*pack_unorms)(const float *v, uint16_t *packed);

    /* One sample a lane of a light; (u, v) in [0, 1)^2 place it on a rectangle. Only lanes of
     * `lanes` are traced; their rays are fit for Embree. */
    void (*sample_light)(const struct light *light, const float *u, const float *v,
                         const struct surface *receiver, const struct lanes_mask *lanes,
                         struct light_packet *out);

    /* What all strata of a rectangle are skipped for, in out->skip; whether that holds in all lanes
     * of `lanes`. */
    bool (*light_hidden)(const struct light *light, const struct surface *receiver,
                         const struct lanes_mask *lanes, struct light_packet *out);

    /* The pixels' jitters, and their l strata along each axis: out->l, column and row. */
    void (*lattice_jitters)(const struct pattern_lattice *lattice, const struct block *b,
                            float *jitter0, float *jitter1);
    void (*place_strata)(const float *jitter0, const float *jitter1, uint32_t l,
                         struct strata *out);

    /* What sample_light makes of strata first .. first + count - 1, a packet each, but for
     * densities, which it leaves alone. Whether all lanes of `lanes` are traced in all of them. */
    bool (*sample_strata)(const struct light *light, const struct strata *strata, uint32_t first,
                          uint32_t count, const struct surface *receiver,
                          const struct lanes_mask *lanes, struct light_packet *batch);

    /* Adds strata first .. first + count - 1 of l x l, whose rays have come back. The first starts
     * the sums, the last makes means of them; visibility goes to bits from first & 7 on. */
    void (*add_strata)(const struct light_packet *batch, uint32_t first, uint32_t count, uint32_t l,
                       struct shadow_sums *sums);

    /* A byte of visibility where something was hit; the next one comes to its place. */
    void (*store_visibility)(const struct block *b, const struct lanes_mask *hit,
                             struct shadow_sums *sums, uint8_t *plane);
    void (*add_slopes)(const struct light_packet *p, struct shadow_sums *sums);

    /* The path tracer's; path_lanes.h says more. Pairs of pattern_path.h: */
    void (*path_pairs)(const struct path_packet *p, uint32_t dimension, float *u, float *v);
    void (*frame_pairs)(uint32_t key, const uint32_t *sample, uint32_t dimension, float *u,
                        float *v);
    void (*ray_keys)(const struct path_packet *p, uint32_t depth, enum path_ray ray,
                     struct RTCRay16 *rays);
    void (*lens_rays)(const struct plan_camera *camera, const float *s, const float *t,
                      struct RTCRay16 *rays);
    void (*tangents)(const struct lanes3 *normal, struct lanes3 *tangent, struct lanes3 *bitangent);
    void (*look_back)(const struct RTCRay16 *rays, struct path_vertex *v); /* v->back */
    void (*lambert_scatter)(const struct surface *s, const float *u, const float *v,
                            struct lanes_mask *valid, struct lanes3 *direction, float *pdf);
    /* Throughputs of the next segments. Where it is a matter of chance (else NULL), they make up
     * for paths that end: lanes of *stays go on. */
    void (*weigh_segments)(const struct path_packet *p, const struct path_scattering *s,
                           const float *chance, struct lanes3 *throughput,
                           struct lanes_mask *stays);
    void (*lambert_light)(const struct path_light *light, const struct surface *s,
                          const float *probability, struct lanes3 *out);
    /* layers.h. What `back` sees of the layers that are on; */
    void (*layers_see)(const struct lanes3 *back, struct layers *layers);
    /* what they send on of light samples that are traced, were these seen: into their lanes; */
    void (*layers_light)(const struct path_light *light, const struct path_vertex *v,
                         const float *probability, struct lanes3 *diffuse, struct lanes3 *all);
    /* where they scatter paths (`choice` picks the lobe); */
    void (*layers_scatter)(const struct path_vertex *v, const float *choice, const float *u,
                           const float *w, struct path_scattering *s);
    /* pi times their diffuse lobes over white albedo, in directions of the world; and samples
     * (u, w) of the glossy lobes of those that are isotropic. */
    void (*layers_diffuse)(const struct path_vertex *v, const struct layers *layers,
                           const struct lanes3 *direction, float *weight);
    void (*layers_gloss)(const struct path_vertex *v, const struct layers *layers, const float *u,
                         const float *w, struct layer_gloss *out);
    /* Where directions of the world are on the sky's map; directions within texels of it. */
    void (*find_sky)(const struct sky *sky, const float *x, const float *y, const float *z,
                     struct sky_view *out);
    void (*place_sky)(const struct sky *sky, const struct sky_texels *texels, const float *u,
                      const float *v, struct lanes3 *direction);
    void (*meet_rectangle)(const struct light *light, const struct path_packet *p,
                           const float *reach, float *factor);
};

/* One for each instruction set (kernels.h). */
extern const struct lane_kernels lane_kernels_sse42, lane_kernels_avx2, lane_kernels_avx512;
