#pragma once
/* A scene ready to trace consists of the blob's arrays, a BVH over them, and materials with their
 * textures looked up. It is built once and then shared read-only by all tracing threads.
 *
 * Every placed mesh keeps the number of its instance. A mesh that is placed once, untransformed,
 * is a geometry of the top scene with geomID = instance index. Every other mesh has a scene of its
 * own, placed by an Embree instance whose instID is the instance index.
 *
 * A base (proto/scene/scene.h) is a scene of trees alone. A frame that stands on it builds only
 * what the base has not: it places the base's top scene as a whole, by an Embree instance of number
 * `ground`, and sub-scenes of the base where they have moved to. */
#include <stdbool.h>

#include "proto/error.h"
#include "proto/scene/scene.h"
#include "worker/scene/glazing.h"
#include "worker/scene/material/material.h"

/* Traits that the shading of sixteen surfaces asks of all of them first. */
enum mesh_trait {
    MESH_SHINES = 1,   /* its material is emissive */
    MESH_REFLECTS = 2, /* otherwise than by Lambert's law */
    MESH_BENT = 4,     /* it has normals other than its facets' */
    MESH_TEXTURED = 8,
    MESH_LAMBERT = 16,
    MESH_ROUND = 32, /* rays start from the surface that its normals describe (lift_lanes.h) */
    MESH_BUMPY = 64  /* it has a normal map: pixels show many normals, of which a field of their
                        centres knows one */
};

/* One mesh as it lies in the blob, with all that a hit or an alpha test needs. */
struct mesh_view {
    const float *positions;    /* float[3] a vertex */
    const uint32_t *triangles; /* uint32_t[3] a triangle */
    const float *normals;      /* float[3] a vertex; NULL: flat */
    const float *tangents;     /* float[4] a vertex; NULL: none, or nothing needs them */
    const float *uvs[2];       /* float[2] a vertex; NULL: no such set */
    const float *colors;       /* float[4] a vertex; NULL: none */
    const struct material *material;
    uint32_t triangle_count;
    uint32_t flags;  /* MESH_ of proto/scene/scene.h */
    uint32_t traits; /* enum mesh_trait */
};

/* What a placed mesh is to a picture that is composed with a photograph; Embree's masks of
 * geometries. */
enum instance_class { INSTANCE_IS_VIRTUAL = 1, INSTANCE_IS_CATCHER = 2, INSTANCE_IS_HOLDOUT = 4 };

static inline enum instance_class instance_class(const struct scene_instance *instance)
{
    if (instance->flags & INSTANCE_HOLDOUT) return INSTANCE_IS_HOLDOUT;
    return instance->flags & INSTANCE_CATCHER ? INSTANCE_IS_CATCHER : INSTANCE_IS_VIRTUAL;
}

struct emitters;
struct lobe_box;
struct lobe_boxes;
struct photon_targets;
struct photons;
struct sky_guides;
struct RTCDeviceTy;
struct RTCSceneTy;

struct render_scene {
    const struct scene *blob;
    struct material_table *materials;
    struct mesh_view *meshes;       /* one a mesh of the blob */
    struct emitters *emitters;      /* NULL: no mesh shines */
    struct sky_guides *guides;      /* grow as skies are asked for */
    struct lobe_boxes *lobes;       /* where surfaces are that have more than a diffuse lobe */
    struct lobe_boxes *virtuals;    /* where virtual objects are; NULL: all are */
    struct RTCSceneTy **sub_scenes; /* one a mesh; NULL where it is a plain geometry */
    struct RTCDeviceTy *device;
    struct RTCSceneTy *top;
    const struct scene_step *
        *steps;                     /* of each instance that moves; NULL: nothing does (movers.h) */
    _Atomic uint64_t *progress;     /* while it is created; borrowed, may be NULL */
    const char *isa;                /* what build_isa() said */
    uint32_t packet_width;          /* rays that this CPU traces at once: 16, 8 or 4 */
    bool has_culled;                /* some mesh has a back that cameras do not see */
    bool has_glass;                 /* some mesh lets light through */
    struct glazing glazing;         /* lamps behind that */
    struct photon_targets *targets; /* its lenses and mirrors; NULL: none */
    struct photons *caustics;       /* of its lamps; NULL: none */
    bool has_instances;             /* whether `top` holds Embree instances, not just geometries */
    const struct render_scene *base; /* borrowed; NULL: none */
    uint32_t ground; /* instID of the base's top scene; RTC_INVALID_GEOMETRY_ID without one */
    struct lobe_box *boxes;   /* of a base: one a mesh */
    uint32_t top_count;       /* of a base: geometries of its top scene */
    uint64_t built_triangles; /* of the trees that were built for it, without the base's */
};

/* Builds the scene with `threads` threads (at least 1) on the instruction set build_isa(). `blob`
 * stays borrowed, and its vertices are used in place: it must outlive the result. *steps (may be
 * NULL) grows with the progress and may be read by other threads. ERR_MEMORY, ERR_UNSUPPORTED
 * (the CPU lacks the instruction set), ERR_LIMIT; *fault says more. */
int render_scene_create(const struct scene *blob, uint32_t threads, _Atomic uint64_t *steps,
                        struct render_scene **out, struct fault *fault);

/* Does the same for a blob that has a base, which outlives the result. */
int render_scene_create_on(const struct scene *blob, const struct render_scene *base,
                           uint32_t threads, _Atomic uint64_t *steps, struct render_scene **out,
                           struct fault *fault);
void render_scene_destroy(struct render_scene **scene);

/* Returns the version of Embree that runs, such as "3.13.5", in static storage. NULL without a
 * device. */
const char *render_embree_version(void);
