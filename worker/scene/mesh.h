#pragma once
/* Reads a placed mesh at a barycentric position. */
#include "worker/scene/render_scene.h"

/* Sets the view of a mesh of a scene, which stays borrowed, as do the materials. */
void mesh_view_init(struct mesh_view *v, const struct scene *scene,
                    const struct material_table *materials, uint32_t index);

/* A point (1-u-v) v0 + u v1 + v v2 of a triangle. */
struct mesh_point {
    const struct mesh_view *mesh;
    const uint32_t *corners; /* three vertex indexes */
    float weights[3];
};

static inline struct mesh_point mesh_point_at(const struct mesh_view *mesh, uint32_t triangle,
                                              float u, float v)
{
    return (struct mesh_point){
        .mesh = mesh,
        .corners = mesh->triangles + (size_t)3 * triangle,
        .weights = {1.0f - u - v, u, v},
    };
}

/* Returns one component of a vertex attribute with `stride` floats a vertex. */
static inline float mesh_interpolate(const struct mesh_point *p, const float *attribute,
                                     size_t stride, size_t component)
{
    return p->weights[0] * attribute[p->corners[0] * stride + component] +
           p->weights[1] * attribute[p->corners[1] * stride + component] +
           p->weights[2] * attribute[p->corners[2] * stride + component];
}

/* Sets both UV sets, with zeros for a set that the mesh lacks, and the colour, with ones where it
 * has none. */
static inline void mesh_uv(const struct mesh_point *p, struct material_uv *out)
{
    for (int set = 0; set < 2; set++)
        for (size_t c = 0; c < 2; c++)
            out->set[set][c] =
                p->mesh->uvs[set] ? mesh_interpolate(p, p->mesh->uvs[set], 2, c) : 0.0f;
    for (size_t c = 0; c < 4; c++)
        out->color[c] = p->mesh->colors ? mesh_interpolate(p, p->mesh->colors, 4, c) : 1.0f;
}
