/* Materials: what glTF's core says of them, how they emit, where they are transparent. */
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_material.h"
#include "server/import/scene/surface.h"

static int read_metallic_roughness(struct gltf *g, const json_t *material, const char *place,
                                   struct scene_material *m, struct fault *fault)
{
    const json_t *json, *info;
    gltf_place at;
    gltf_place_set(at, "%s.pbrMetallicRoughness", place);
    int rc = gltf_object(material, place, "pbrMetallicRoughness", &json, fault);
    if (rc != 0) return rc;
    rc = gltf_floats(json, at, "baseColorFactor", 4, 0, 1, m->base_color, fault);
    if (rc == 0) rc = gltf_float(json, at, "metallicFactor", 0, 1, &m->metallic, fault);
    if (rc == 0) rc = gltf_float(json, at, "roughnessFactor", 0, 1, &m->roughness, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, json, at, "baseColorTexture", true, &m->base_color_texture, &info,
                               fault);
    if (rc == 0)
        rc = gltf_texture_read(g, json, at, "metallicRoughnessTexture", false,
                               &m->metallic_roughness_texture, &info, fault);
    return rc;
}

static int read_normal_map(struct gltf *g, const json_t *json, const char *place,
                           struct scene_material *m, struct fault *fault)
{
    const json_t *info;
    gltf_place at;
    gltf_place_set(at, "%s.normalTexture", place);
    int rc =
        gltf_texture_read(g, json, place, "normalTexture", false, &m->normal_texture, &info, fault);
    if (rc == 0) rc = gltf_float(info, at, "scale", -1e6, 1e6, &m->normal_scale, fault);
    return rc;
}

static int read_emission(struct gltf *g, const json_t *json, const char *place,
                         struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    double factor[3] = {0, 0, 0}, strength = 1;
    int rc = gltf_vector(json, place, "emissiveFactor", 3, 0, 1, factor, NULL, fault);
    if (rc == 0)
        rc = gltf_extension(json, place, "KHR_materials_emissive_strength", &extension, at, fault);
    if (rc == 0)
        rc = gltf_number(extension, at, "emissiveStrength", 0, (double)LIMIT_RADIANCE, &strength,
                         fault);
    if (rc == 0)
        rc = gltf_texture_read(g, json, place, "emissiveTexture", true, &m->emission_texture, &info,
                               fault);
    for (int i = 0; i < 3; i++) m->emission[i] = (float)(factor[i] * strength);
    return rc;
}

static int read_alpha(const json_t *json, const char *place, struct scene_material *m,
                      struct fault *fault)
{
    const char *mode;
    gltf_place at;
    int rc = gltf_text(json, place, "alphaMode", &mode, fault);
    if (rc == 0) rc = gltf_float(json, place, "alphaCutoff", 0, 1e6, &m->alpha_cutoff, fault);
    if (rc != 0 || mode == NULL || strcmp(mode, "OPAQUE") == 0) return rc;
    if (strcmp(mode, "MASK") == 0) {
        m->alpha_mode = ALPHA_MASK;
        return 0;
    }
    if (strcmp(mode, "BLEND") == 0) {
        m->alpha_mode = ALPHA_BLEND;
        return 0;
    }
    gltf_place_set(at, "%s.alphaMode", place);
    return fault_set(fault, ERR_RANGE, at, "\"%.40s\" is not OPAQUE, MASK or BLEND", mode);
}

static int read_flags(const json_t *json, const char *place, struct scene_material *m,
                      struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    bool double_sided = false;
    int rc = gltf_flag(json, place, "doubleSided", &double_sided, fault);
    if (rc == 0) rc = gltf_extension(json, place, "KHR_materials_unlit", &extension, at, fault);
    if (rc != 0) return rc;
    m->flags |= double_sided ? MATERIAL_DOUBLE_SIDED : MATERIAL_CULLED;
    if (extension != NULL) m->flags |= MATERIAL_UNLIT;
    return 0;
}

/* A mesh of the blob has two sets of texture coordinates: a material gets the two that it reads
 * first, in the file's order of sets. Textures of others are left out. */
static void choose_uv_sets(struct gltf *g, struct scene_material *m, const char *place,
                           uint32_t sets[2])
{
    struct scene_texture_ref *refs[SURFACE_TEXTURES];
    surface_textures(m, refs);
    sets[0] = sets[1] = SCENE_NONE;
    for (int i = 0; i < SURFACE_TEXTURES; i++) {
        const uint32_t set = refs[i]->uv_set;
        if (refs[i]->texture == SCENE_NONE || set == sets[0] || set == sets[1]) continue;
        if (sets[0] == SCENE_NONE)
            sets[0] = set;
        else if (sets[1] == SCENE_NONE)
            sets[1] = set;
    }
    if (sets[0] <= 1 && (sets[1] <= 1 || sets[1] == SCENE_NONE)) sets[0] = 0, sets[1] = 1;
    if (sets[0] == SCENE_NONE) sets[0] = 0, sets[1] = 1;
    for (int i = 0; i < SURFACE_TEXTURES; i++) {
        const uint32_t set = refs[i]->uv_set;
        refs[i]->uv_set = set == sets[1];
        if (refs[i]->texture == SCENE_NONE || set == sets[0] || set == sets[1]) continue;
        refs[i]->texture = SCENE_NONE;
        warnings_add(
            &g->builder->warnings, place,
            "it reads more than two sets of texture coordinates; textures of the third are "
            "ignored");
    }
}

static int append_material(struct gltf *g, const struct scene_material *m, struct fault *fault)
{
    void *at;
    int rc = builder_append(g->builder, SCENE_MATERIALS, 1, &at, fault);
    if (rc == 0) memcpy(at, m, sizeof *m);
    return rc;
}

static int read_material(struct gltf *g, size_t index, struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    const char *name;
    struct scene_material m;
    surface_init(&m);
    int rc = gltf_item(g->root, "materials", index, &json, place, fault);
    if (rc == 0) rc = gltf_text(json, place, "name", &name, fault);
    if (rc == 0) rc = builder_name(g->builder, name, &m.name, fault);
    if (rc == 0) rc = read_metallic_roughness(g, json, place, &m, fault);
    if (rc == 0) rc = read_normal_map(g, json, place, &m, fault);
    if (rc == 0) rc = read_emission(g, json, place, &m, fault);
    if (rc == 0) rc = read_alpha(json, place, &m, fault);
    if (rc == 0) rc = gltf_material_extensions_read(g, json, place, &m, fault);
    if (rc == 0) rc = gltf_material_extras_read(g, json, place, &m, fault);
    if (rc == 0) rc = read_flags(json, place, &m, fault);
    if (rc == 0) choose_uv_sets(g, &m, place, g->uv_sets[index]);
    return rc == 0 ? append_material(g, &m, fault) : rc;
}

int gltf_materials_read(struct gltf *g, struct fault *fault)
{
    int rc = 0;
    size_t count = gltf_count(g->root, "materials");
    free(g->uv_sets);
    g->uv_sets = calloc(count + 1, sizeof *g->uv_sets);
    if (g->uv_sets == NULL)
        return fault_set(fault, ERR_MEMORY, "materials", "no memory for %zu materials", count);
    for (size_t i = 0; rc == 0 && i < count; i++) rc = read_material(g, i, fault);
    return rc;
}

int gltf_default_material(struct gltf *g, uint32_t *out, struct fault *fault)
{
    if (g->default_material == SCENE_NONE) {
        struct scene_material m;
        surface_init(&m);
        m.flags = MATERIAL_CULLED;
        uint32_t index = (uint32_t)builder_count(g->builder, SCENE_MATERIALS);
        int rc = append_material(g, &m, fault);
        if (rc != 0) return rc;
        g->default_material = index;
    }
    *out = g->default_material;
    return 0;
}
