#pragma once
/* Turns Embree's hits into surfaces: position, normals, material. */
#include "worker/trace/hit/queries.h"
#include "worker/trace/hit/vector.h"

struct mesh_point;

/* Half a step of the albedo plane: lower albedos are 0 in that plane. */
#define ALBEDO_BLACK (0.5f / 65535.0f)

/* The surfaces that sixteen rays met. Where `hit` is off, distance, id, albedo and emission are 0
 * and the vectors mean nothing. */
struct surface {
    struct lanes3 position;
    struct lanes3 origin;   /* where rays that leave the surface start (offset.h) */
    struct lanes3 plane;    /* geometric normal, unit, facing the ray */
    struct lanes3 lift;     /* added to the origin of rays to below the plane; 0: none go there */
    struct lanes3 facet;    /* what rays leave to the side of: the plane, or where there is a lift
                               the interpolated normal of the vertices (lift_lanes.h) */
    struct lanes3 normal;   /* shading normal, unit, facing the ray and on the facet's side */
    struct lanes3 albedo;   /* of Lambert surfaces; 1 of others: a BSDF says what theirs is */
    struct lanes3 emission; /* radiance towards the ray's origin */
    _Alignas(LANES_ALIGN) float distance[LANES];
    _Alignas(LANES_ALIGN) uint32_t id[LANES]; /* instance index + 1 */
    struct lanes_mask hit;
    struct lanes_mask light;  /* on a mesh that is a light of the plan */
    struct lanes_mask behind; /* the ray came from the side that the winding turns away */
    const struct mesh_view *mesh[LANES]; /* NULL: nothing was hit */
    bool any_bsdf;                       /* some surface is neither Lambert's nor only shines */
    bool any_emission;                   /* one of them may shine */
};

/* Returns where lane i's ray along (x, y, z) starts. */
LANE_INLINE struct vector surface_start(const struct surface *s, int i, float x, float y, float z)
{
    const float above = x * s->plane.x[i] + y * s->plane.y[i] + z * s->plane.z[i];
    return (struct vector){s->origin.x[i] + (above < 0.0f ? s->lift.x[i] : 0.0f),
                           s->origin.y[i] + (above < 0.0f ? s->lift.y[i] : 0.0f),
                           s->origin.z[i] + (above < 0.0f ? s->lift.z[i] : 0.0f)};
}

/* Sets *out to what the closest-hit query of *rays found in the lanes of *valid. Ray directions
 * must be unit. */
void hit_resolve(const struct queries *q, const struct lanes_mask *valid,
                 const struct RTCRayHit16 *rays, struct surface *out);

/* Steps that hit_kernels' resolve_hits takes lane by lane. They set the normal map's normal, the
 * Lambert albedo and the emission (of the emitting side) of a lane whose material has textures, and
 * bring a lane's vectors, and their magnitude, from the mesh's space into the world. */
void hit_shade_textured(const struct mesh_view *mesh, const struct RTCHit16 *hit, int i,
                        struct surface *out);
void hit_bend_normal(const struct mesh_point *p, const float bend[3], int i, struct surface *out);
void hit_to_world(const float m[12], int i, float *magnitude, struct surface *out);
void hit_lift_to_world(const float m[12], int i, struct lanes3 *lift, struct lanes3 *round);

/* Computes the normal of a layer in the world, from one in tangent space; not of unit length. The
 * mesh has tangents. */
void hit_bend_layer(const struct mesh_point *p, const float bend[3], const float m[12], float n[3]);

/* Sets the albedo of surfaces with a BSDF to that of its diffuse lobe. */
void hit_diffuse_albedo(const struct queries *q, const struct RTCRayHit16 *rays, struct surface *s);
