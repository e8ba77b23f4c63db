#pragma once
/* The queries to Embree while tracing, sixteen rays at a time. A ray's id is the key of its random
 * numbers at blended surfaces (worker/scene/alpha.h); 0: none.
 *
 * Embree aborts on rays that are not finite or start beyond 1e18. Every packet goes through
 * queries_sanitise first, or comes from light_kernels' sample_light, which checks its rays. */
#include <embree3/rtcore.h>

#include "worker/scene/render_scene.h"
#include "worker/shade/lanes.h"
#include "worker/trace/hit/query_view.h"

enum query_kind {
    QUERY_CAMERA = 0,  /* closest hit that the camera sees (back_faces.h), coherent */
    QUERY_SHADOW = 1,  /* anything in between? coherent */
    QUERY_BLOCKER = 2, /* closest blocker's distance, coherent */
    QUERY_BOUNCE = 3,  /* closest hit, incoherent */
    QUERY_BOUNCE_SHADOW = 4,
    QUERY_KIND_COUNT = 5
};

/* Sees every packet before it is traced, for benchmarks that replay them. */
struct query_recorder {
    void (*record)(struct query_recorder *self, enum query_kind kind,
                   const struct lanes_mask *valid, const struct RTCRayHit16 *rays);
};

struct hit_kernels;

struct queries {
    const struct render_scene *scene;
    const struct hit_kernels *kernels;
    struct query_recorder *recorder; /* NULL: nothing is recorded */
    const struct query_view *view;   /* NULL: rays meet all, and the camera sees it */
    uint64_t rejected;               /* rays switched off because they were not finite */
    struct RTCRayHit8 narrow8;       /* scratch for CPUs without packets of sixteen */
    struct RTCRayHit4 narrow4;
};

/* Sets queries without a scene and without a recorder. */
void queries_init(struct queries *q);

/* Sets the fields that no query changes. */
void queries_init_rays(struct RTCRayHit16 *rays);

/* Clears the lanes of *valid whose ray Embree cannot take, and counts them. */
void queries_sanitise(struct queries *q, struct lanes_mask *valid, const struct RTCRay16 *rays);

/* Finds closest hits in the lanes of *valid, which must be fit; rays->ray.tfar becomes the distance
 * and rays->hit is filled, geomID RTC_INVALID_GEOMETRY_ID on a miss and in other lanes. */
void queries_closest(struct queries *q, enum query_kind kind, const struct lanes_mask *valid,
                     struct RTCRayHit16 *rays);

/* Sets rays->ray.tfar to -infinity where geometry lies between tnear and tfar. rays->hit is left
 * alone. The lanes of *valid must be fit. */
void queries_occluded(struct queries *q, enum query_kind kind, const struct lanes_mask *valid,
                      struct RTCRayHit16 *rays);
