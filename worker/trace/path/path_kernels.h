#pragma once
/* The inner loops over sixteen paths (path_lanes.h). */
#include "proto/pattern_path.h"
#include "proto/runtime/kernels.h"
#include "worker/trace/path/light_choice.h"
#include "worker/trace/path/path.h"

struct path_kernels {
    /* Compute pairs of pattern_path.h. */
    void (*path_pairs)(const struct path_packet *p, uint32_t dimension, float *u, float *v);
    void (*path_pairs_of)(const uint32_t *key, const uint32_t *sample, uint32_t dimension, float *u,
                          float *v);
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
    /* Computes throughputs of the next segments. With roulette (`chance` not NULL), they make up
     * for paths that end: lanes of *stays go on. */
    void (*weigh_segments)(const struct path_packet *p, const struct path_scattering *s,
                           const float *chance, struct lanes3 *throughput,
                           struct lanes_mask *stays);
    void (*lambert_light)(const struct nee_sample *light, const struct surface *s,
                          const float *probability, struct lanes3 *out);
    /* Sees the layers (layers.h) that are on, along `back`. */
    void (*layers_see)(const struct lanes3 *back, struct layers *layers);
    /* Computes what layers send on of traced light samples, as if these were seen, in the layers'
     * lanes. */
    void (*layers_light)(const struct nee_sample *light, const struct path_vertex *v,
                         const float *probability, struct lanes3 *diffuse, struct lanes3 *all);
    /* Scatters paths at layers; `choice` picks the lobe. */
    void (*layers_scatter)(const struct path_vertex *v, const float *choice, const float *u,
                           const float *w, struct path_scattering *s);
    /* Sends the paths of turned lanes that have layers into given directions of the world instead.
     */
    void (*layers_turn)(const struct path_vertex *v, const struct lanes_mask *turned,
                        const struct lanes3 *way, struct path_scattering *s);
    /* Compute pi times the layers' diffuse lobes over white albedo, in directions of the world, and
     * samples (u, w) of the glossy lobes of layers. */
    void (*layers_diffuse)(const struct path_vertex *v, const struct layers *layers,
                           const struct lanes3 *direction, float *weight);
    void (*layers_gloss)(const struct path_vertex *v, const struct layers *layers, const float *u,
                         const float *w, struct layer_gloss *out);
    /* Find where directions of the world are on the sky's map, and the directions of places within
     * its texels. */
    void (*find_sky)(const struct sky *sky, const float *x, const float *y, const float *z,
                     struct sky_view *out);
    void (*place_sky)(const struct sky *sky, const struct sky_texels *texels, const float *u,
                      const float *v, struct lanes3 *direction);
    /* Bound what lights send to surfaces at `origin` that face along `normal`, whatever is in
     * between: all of them, those without extent only if `points`; a rectangle; a node's groups,
     * for one lane, and their sum. */
    void (*weigh_lights)(const struct light_table *table, bool points, const struct lanes3 *origin,
                         const struct lanes3 *normal, struct light_weights *out);
    void (*weigh_rectangle)(const struct light *light, const struct lanes3 *origin,
                            const struct lanes3 *normal, float *weight);
    float (*weigh_node)(const struct emitter_groups *node, const struct lanes3 *origin,
                        const struct lanes3 *normal, int lane, float *weight);
    /* Chooses one light by x in [0, 1), in proportion to that. */
    void (*choose_light)(const struct light_table *table, const struct light_weights *weights,
                         const float *x, struct light_choice *out);
    /* Finds a rectangle's profile where rays that end at `reach` meet it, else 0, and the density
     * per solid angle of its light samples. */
    void (*meet_rectangle)(const struct light *light, const struct path_packet *p,
                           const float *reach, float *profile, float *density);
};

/* One for each instruction set (kernels.h). All compute the same bits. */
extern const struct path_kernels path_kernels_sse42, path_kernels_avx2, path_kernels_avx512;
