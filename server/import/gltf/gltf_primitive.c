#include "server/import/gltf/gltf_primitive.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_accessor.h"
#include "server/import/gltf/gltf_draco.h"
#include "server/import/gltf/gltf_pose.h"
#include "server/import/scene/surface.h"
#include "server/import/scene/tangents.h"

enum { MODE_TRIANGLES = 4, MODE_STRIP = 5, MODE_FAN = 6 };

static int read_attributes(struct gltf *g, const json_t *json, const char *place,
                           struct gltf_geometry *out, struct fault *fault)
{
    const json_t *attributes;
    gltf_place at;
    size_t count = gltf_count(g->root, "accessors");
    const struct {
        const char *key;
        uint32_t *index;
    } rows[] = {{"POSITION", &out->position},
                {"NORMAL", &out->normal},
                {"TANGENT", &out->tangent},
                {"COLOR_0", &out->color}};
    gltf_place_set(at, "%s.attributes", place);
    int rc = gltf_object(json, place, "attributes", &attributes, fault);
    if (rc == 0 && attributes == NULL)
        rc = fault_set(fault, ERR_MISSING, at, "a primitive has attributes");
    for (size_t i = 0; rc == 0 && i < sizeof rows / sizeof *rows; i++)
        rc = gltf_index(attributes, at, rows[i].key, count, rows[i].index, fault);
    if (rc == 0) rc = gltf_index(json, place, "indices", count, &out->indices, fault);
    return rc;
}

/* Reads the two sets of texture coordinates that the material wants. */
static int read_uv_sets(struct gltf *g, const json_t *json, const char *place, uint32_t material,
                        struct gltf_geometry *out, struct fault *fault)
{
    static const uint32_t plain[2] = {0, 1};
    const bool own = material < gltf_count(g->root, "materials");
    const json_t *attributes = json_object_get(json, "attributes");
    size_t count = gltf_count(g->root, "accessors");
    gltf_place at;
    int rc = 0;
    gltf_place_set(at, "%s.attributes", place);
    for (int i = 0; rc == 0 && i < 2; i++) {
        const uint32_t set = own ? g->uv_sets[material][i] : plain[i];
        char key[24];
        if (set == SCENE_NONE) continue;
        snprintf(key, sizeof key, "TEXCOORD_%" PRIu32, set);
        rc = gltf_index(attributes, at, key, count, &out->uv[i], fault);
        if (out->uv[i] != SCENE_NONE) out->uv_number[i] = set;
    }
    return rc;
}

/* Warns where the material reads texture coordinates that the primitive lacks. */
static void check_uvs(struct gltf *g, const struct scene_material *m,
                      const struct gltf_geometry *geometry, const char *place)
{
    struct scene_material copy = *m;
    struct scene_texture_ref *refs[SURFACE_TEXTURES];
    surface_textures(&copy, refs);
    for (int i = 0; i < SURFACE_TEXTURES; i++) {
        if (refs[i]->texture == SCENE_NONE || geometry->uv[refs[i]->uv_set] != SCENE_NONE) continue;
        warnings_add(&g->builder->warnings, place,
                     "its material has textures, but it lacks the texture coordinates");
        return;
    }
}

static bool has_uvs_of(const struct gltf_geometry *geometry, const struct scene_texture_ref *map)
{
    return map->texture != SCENE_NONE && geometry->uv[map->uv_set] != SCENE_NONE;
}

/* The UV set that tangents run along: the normal map's, or the coat's; else, of an anisotropic
 * surface, that of its directions, else the first. SCENE_NONE: no tangents are needed or can be
 * made. */
static uint32_t tangent_set(const struct scene_material *m, const struct gltf_geometry *geometry)
{
    if (has_uvs_of(geometry, &m->normal_texture)) return m->normal_texture.uv_set;
    if (m->clearcoat > 0 && has_uvs_of(geometry, &m->clearcoat_normal_texture))
        return m->clearcoat_normal_texture.uv_set;
    if (!surface_is_anisotropic(m)) return SCENE_NONE;
    if (has_uvs_of(geometry, &m->anisotropy_texture)) return m->anisotropy_texture.uv_set;
    return geometry->uv[0] != SCENE_NONE ? 0 : SCENE_NONE;
}

/* Tangents without normals are to be ignored (glTF 2.0, section 3.7.2.1); those that nothing needs
 * would only keep equal geometries apart. */
static void choose_tangents(struct gltf *g, const struct scene_material *m,
                            struct gltf_geometry *geometry, const char *place)
{
    geometry->tangent_set = tangent_set(m, geometry);
    const bool anisotropic = surface_is_anisotropic(m);
    bool needed = geometry->tangent_set != SCENE_NONE || anisotropic;
    if (!needed || geometry->normal == SCENE_NONE) geometry->tangent = SCENE_NONE;
    if (anisotropic && geometry->tangent_set == SCENE_NONE && geometry->tangent == SCENE_NONE)
        warnings_add(&g->builder->warnings, place,
                     "its material is anisotropic, but it has neither tangents nor texture "
                     "coordinates: the direction is arbitrary");
}

static int read_material(struct gltf *g, const json_t *json, const char *place,
                         struct gltf_primitive *out, struct fault *fault)
{
    int rc = gltf_index(json, place, "material", gltf_count(g->root, "materials"), &out->material,
                        fault);
    if (rc == 0) rc = gltf_variant_material(g, json, place, &out->material, fault);
    out->own_material = out->material;
    if (rc == 0 && out->material == SCENE_NONE)
        rc = gltf_default_material(g, &out->material, fault);
    if (rc == 0) rc = read_uv_sets(g, json, place, out->material, &out->geometry, fault);
    if (rc != 0) return rc;
    const struct scene_material *m = &builder_materials(g->builder)[out->material];
    check_uvs(g, m, &out->geometry, place);
    choose_tangents(g, m, &out->geometry, place);
    if (out->geometry.color == SCENE_NONE) return 0;
    return colored_material_get(&g->colored, g->builder, out->material, &out->material, fault);
}

int gltf_primitive_read(struct gltf *g, uint32_t mesh, uint32_t primitive, uint32_t poser,
                        struct gltf_primitive *out, struct fault *fault)
{
    gltf_place mesh_place, place;
    const json_t *mesh_json, *primitives;
    uint64_t mode = MODE_TRIANGLES;
    memset(out, 0xff, sizeof *out); /* every index SCENE_NONE */
    out->drawn = false;
    int rc = gltf_item(g->root, "meshes", mesh, &mesh_json, mesh_place, fault);
    if (rc == 0) rc = gltf_array(mesh_json, mesh_place, "primitives", &primitives, fault);
    if (rc != 0) return rc;
    gltf_place_set(place, "%s.primitives[%" PRIu32 "]", mesh_place, primitive);
    const json_t *json = json_array_get(primitives, primitive);
    if (!json_is_object(json)) return fault_set(fault, ERR_TYPE, place, "it is not an object");
    rc = gltf_integer(json, place, "mode", MODE_FAN, &mode, fault);
    if (rc == 0) rc = read_attributes(g, json, place, &out->geometry, fault);
    if (rc != 0) return rc;
    out->geometry.mode = (uint32_t)mode;
    if (mode < MODE_TRIANGLES) {
        warnings_add(&g->builder->warnings, place, "points and lines are ignored");
        return 0;
    }
    if (out->geometry.position == SCENE_NONE) {
        warnings_add(&g->builder->warnings, place, "a primitive without positions is ignored");
        return 0;
    }
    out->drawn = true;
    if (gltf_draco_is(json)) {
        out->geometry.draco_mesh = mesh;
        out->geometry.draco_primitive = primitive;
    }
    bool posed = false;
    rc = gltf_pose_moves(g, mesh, primitive, poser, &posed, fault);
    if (posed) {
        out->geometry.posed_mesh = mesh;
        out->geometry.posed_primitive = primitive;
        out->geometry.posed_node = poser;
    }
    return rc == 0 ? read_material(g, json, place, out, fault) : rc;
}

/* Loads an optional attribute, which must have as many elements as there are vertices. */
static int load_attribute(struct gltf *g, const char *key, uint32_t accessor, uint32_t components,
                          uint32_t vertices, float **out, struct fault *fault)
{
    if (accessor == SCENE_NONE) return 0;
    uint32_t count;
    int rc = gltf_vertex_floats(g, key, accessor, &components, &count, out, fault);
    if (rc != 0 || count == vertices) return rc;
    gltf_place place;
    gltf_place_set(place, "accessors[%" PRIu32 "]", accessor);
    return fault_set(fault, ERR_MISMATCH, place,
                     "it has %" PRIu32 " elements for %" PRIu32 " vertices", count, vertices);
}

/* Colours have three components or four; alpha is 1 where they have three. */
static int load_colors(struct gltf *g, uint32_t accessor, uint32_t vertices, float **out,
                       struct fault *fault)
{
    uint32_t components = 0, count;
    float *colors = NULL;
    gltf_place at;
    gltf_place_set(at, "accessors[%" PRIu32 "]", accessor);
    if (accessor == SCENE_NONE) return 0;
    int rc = gltf_vertex_floats(g, "COLOR_0", accessor, &components, &count, &colors, fault);
    const bool fits = components == 3 || components == 4; /* a matrix has more */
    if (rc == 0 && (count != vertices || !fits))
        rc = fault_set(fault, count != vertices ? ERR_MISMATCH : ERR_TYPE, at,
                       "it has %" PRIu32 " colours of %" PRIu32 " components for %" PRIu32
                       " vertices",
                       count, components, vertices);
    if (rc == 0) *out = malloc(((size_t)vertices * 4 + 1) * sizeof **out);
    for (size_t v = 0; rc == 0 && *out != NULL && v < vertices; v++) {
        memcpy(*out + 4 * v, colors + components * v, components * sizeof **out);
        if (components == 3) (*out)[4 * v + 3] = 1;
    }
    if (rc == 0 && *out == NULL) rc = fault_set(fault, ERR_MEMORY, at, "no memory for colours");
    free(colors);
    return rc;
}

static int load_vertices(struct gltf *g, const struct gltf_geometry *geometry, struct mesh *out,
                         struct fault *fault)
{
    uint32_t three = 3;
    int rc = gltf_vertex_floats(g, "POSITION", geometry->position, &three, &out->vertex_count,
                                &out->positions, fault);
    uint32_t n = out->vertex_count;
    if (rc == 0) rc = load_attribute(g, "NORMAL", geometry->normal, 3, n, &out->normals, fault);
    if (rc == 0) rc = load_attribute(g, "TANGENT", geometry->tangent, 4, n, &out->tangents, fault);
    for (int set = 0; rc == 0 && set < 2; set++) {
        char key[24];
        snprintf(key, sizeof key, "TEXCOORD_%" PRIu32, geometry->uv_number[set]);
        rc = load_attribute(g, key, geometry->uv[set], 2, n, &out->uvs[set], fault);
    }
    return rc == 0 ? load_colors(g, geometry->color, n, &out->colors, fault) : rc;
}

/* Corner k of triangle t in an index list of the given mode (glTF 2.0, section 3.7.2.1). */
static size_t corner(uint32_t mode, size_t t, size_t k)
{
    if (mode == MODE_TRIANGLES) return 3 * t + k;
    if (mode == MODE_FAN) return k == 2 ? 0 : t + 1 + k;
    return k == 0 ? t : t % 2 == 0 ? t + k : t + 3 - k;
}

static int load_triangles(struct gltf *g, const struct gltf_geometry *geometry, const char *place,
                          struct mesh *out, struct fault *fault)
{
    uint32_t *indices = NULL, count = out->vertex_count;
    int rc = 0;
    if (g->draco.mesh != NULL) return gltf_draco_triangles(g, out, fault);
    if (geometry->indices != SCENE_NONE)
        rc = gltf_read_indices(g, geometry->indices, &count, &indices, fault);
    if (rc != 0) return rc;
    bool list = geometry->mode == MODE_TRIANGLES;
    out->triangle_count = list ? count / 3 : count < 3 ? 0 : count - 2;
    if ((list && count % 3 != 0) || count < 3)
        warnings_add(&g->builder->warnings, place, "the last triangle is incomplete and ignored");
    out->triangles = malloc(((size_t)out->triangle_count * 3 + 1) * sizeof *out->triangles);
    if (out->triangles == NULL) {
        free(indices);
        return fault_set(fault, ERR_MEMORY, place, "no memory for %" PRIu32 " triangles",
                         out->triangle_count);
    }
    for (size_t t = 0; t < out->triangle_count; t++) {
        for (size_t k = 0; k < 3; k++) {
            size_t at = corner(geometry->mode, t, k);
            out->triangles[3 * t + k] = indices != NULL ? indices[at] : (uint32_t)at;
        }
    }
    free(indices);
    return 0;
}

/* Normals for a normal map and tangents where the file leaves them out. */
static int complete_tangents(const struct gltf_geometry *geometry, const char *place,
                             struct mesh *mesh, struct fault *fault)
{
    if (geometry->tangent_set == SCENE_NONE || mesh->tangents != NULL) return 0;
    int rc = mesh->normals == NULL ? mesh_flatten(mesh, place, fault) : 0;
    if (rc == 0) rc = mesh_make_tangents(mesh, (int)geometry->tangent_set, place, fault);
    return rc;
}

static int begin(struct gltf *g, const struct gltf_geometry *geometry, struct fault *fault)
{
    const json_t *mesh, *primitives;
    gltf_place mesh_place, place;
    if (geometry->draco_mesh == SCENE_NONE) return 0;
    int rc = gltf_item(g->root, "meshes", geometry->draco_mesh, &mesh, mesh_place, fault);
    if (rc == 0) rc = gltf_array(mesh, mesh_place, "primitives", &primitives, fault);
    if (rc != 0) return rc;
    gltf_place_set(place, "%s.primitives[%" PRIu32 "]", mesh_place, geometry->draco_primitive);
    return gltf_draco_begin(g, json_array_get(primitives, geometry->draco_primitive), place, fault);
}

int gltf_geometry_load(struct gltf *g, const struct gltf_geometry *geometry, const char *place,
                       struct mesh *out, struct fault *fault)
{
    *out = (struct mesh){0};
    int rc = begin(g, geometry, fault);
    if (rc == 0) rc = load_vertices(g, geometry, out, fault);
    if (rc == 0) rc = load_triangles(g, geometry, place, out, fault);
    if (rc == 0 && geometry->posed_mesh != SCENE_NONE)
        rc = gltf_pose_apply(g, geometry, place, out, fault);
    gltf_draco_end(g);
    if (rc == 0) rc = mesh_check(out, place, &g->builder->warnings, fault);
    if (rc == 0) rc = mesh_compact(out, fault);
    if (rc == 0) rc = complete_tangents(geometry, place, out, fault);
    if (rc != 0) mesh_fini(out);
    return rc;
}
