#include "worker/scene/mesh.h"

static uint32_t traits_of(const struct mesh_view *v)
{
    const struct material *m = v->material;
    uint32_t traits = m->emissive ? MESH_SHINES : 0;
    if (!m->lambert && !m->unlit) traits |= MESH_REFLECTS;
    if (m->lambert) traits |= MESH_LAMBERT;
    if (v->normals || v->tangents) traits |= MESH_BENT;
    /* Lamps' densities are their facets', and rays through glass start at the facet's far side. */
    if (v->normals && !m->emissive && !m->transmissive && !m->translucent) traits |= MESH_ROUND;
    if (v->tangents && m->normal_texture.texels) traits |= MESH_BUMPY;
    return m->textured ? traits | MESH_TEXTURED : traits;
}

void mesh_view_init(struct mesh_view *v, const struct scene *scene,
                    const struct material_table *materials, uint32_t index)
{
    const struct scene_mesh *mesh = &scene->meshes[index];
    const struct scene *blob = scene_mesh_home(scene, mesh);
    v->positions = blob->positions + (size_t)3 * mesh->first_vertex;
    v->triangles = blob->triangles + (size_t)3 * mesh->first_triangle;
    v->normals =
        mesh->flags & MESH_HAS_NORMALS ? blob->normals + (size_t)3 * mesh->first_normal : NULL;
    v->material = &materials->materials[mesh->material];
    bool turned =
        v->material->normal_texture.texels || v->material->coat_bent || v->material->anisotropic;
    bool has_tangents = mesh->flags & MESH_HAS_TANGENTS && v->normals;
    v->tangents = has_tangents && turned ? blob->tangents + (size_t)4 * mesh->first_tangent : NULL;
    for (int set = 0; set < 2; set++)
        v->uvs[set] =
            mesh->first_uv[set] == SCENE_NONE ? NULL : blob->uvs + (size_t)2 * mesh->first_uv[set];
    v->colors = mesh->flags & MESH_HAS_COLORS ? blob->colors + (size_t)4 * mesh->first_color : NULL;
    v->triangle_count = mesh->triangle_count;
    v->flags = mesh->flags;
    v->traits = traits_of(v);
}
