/* KHR_materials_variants: which material a primitive has in the variant that is asked for. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "server/import/gltf/gltf.h"

/* "the scene has no variant "x"; it has "a", "b"" as far as they fit. */
static int refuse_name(const json_t *variants, const char *name, const char *place,
                       struct fault *fault)
{
    char known[256] = "none";
    size_t used = 0, i;
    json_t *variant;
    json_array_foreach (variants, i, variant) {
        const char *other = json_string_value(json_object_get(variant, "name"));
        if (used > sizeof known - 40) break;
        used += (size_t)snprintf(known + used, sizeof known - used, "%s\"%.30s\"",
                                 i > 0 ? ", " : "", other != NULL ? other : "");
    }
    return fault_set(fault, ERR_NOT_FOUND, place, "the scene has no variant \"%.100s\"; it has %s",
                     name, known);
}

int gltf_variant_find(struct gltf *g, const char *name, struct fault *fault)
{
    const json_t *extension, *variants;
    gltf_place place;
    g->variant = SCENE_NONE;
    int rc = gltf_extension(g->root, "", "KHR_materials_variants", &extension, place, fault);
    if (rc == 0) rc = gltf_array(extension, place, "variants", &variants, fault);
    if (rc != 0 || name == NULL) return rc;
    for (size_t i = 0; i < json_array_size(variants); i++) {
        const json_t *own = json_object_get(json_array_get(variants, i), "name");
        if (!json_is_string(own) || strcmp(json_string_value(own), name) != 0) continue;
        g->variant = (uint32_t)i;
        return 0;
    }
    return refuse_name(variants, name, "extensions.KHR_materials_variants.variants", fault);
}

static bool holds(const json_t *list, uint32_t index)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *one = json_array_get(list, i);
        if (json_is_integer(one) && json_integer_value(one) == (json_int_t)index) return true;
    }
    return false;
}

int gltf_variant_material(struct gltf *g, const json_t *primitive, const char *place,
                          uint32_t *inout, struct fault *fault)
{
    const json_t *extension, *mappings;
    gltf_place at;
    if (g->variant == SCENE_NONE) return 0;
    int rc = gltf_extension(primitive, place, "KHR_materials_variants", &extension, at, fault);
    if (rc == 0) rc = gltf_array(extension, at, "mappings", &mappings, fault);
    for (size_t i = 0; rc == 0 && i < json_array_size(mappings); i++) {
        const json_t *mapping = json_array_get(mappings, i);
        gltf_place mapping_at;
        gltf_place_set(mapping_at, "%s.mappings[%zu]", at, i);
        if (!holds(json_object_get(mapping, "variants"), g->variant)) continue;
        return gltf_index(mapping, mapping_at, "material", gltf_count(g->root, "materials"), inout,
                          fault);
    }
    return rc;
}
