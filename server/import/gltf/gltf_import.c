#include <stdlib.h>

#include "proto/json.h"
#include "server/import/gltf/gltf.h"
#include "server/import/gltf/gltf_animation.h"
#include "server/import/gltf/gltf_draco.h"

static int import_document(struct gltf *g, const struct scene_choice *choice,
                           const struct file_view *main, struct fault *fault)
{
    int rc = gltf_document_read(g, main, fault);
    if (rc == 0) rc = gltf_variant_find(g, choice->variant, fault);
    if (rc == 0) rc = gltf_buffers_init(g, fault);
    if (rc == 0) rc = gltf_animations_apply(g, choice, fault);
    if (rc == 0) rc = gltf_textures_init(g, fault);
    if (rc == 0) rc = gltf_nodes_read(g, fault);
    if (rc == 0) gltf_origin_move(g);
    if (rc == 0) rc = gltf_materials_read(g, fault);
    if (rc == 0) rc = gltf_meshes_read(g, fault);
    if (rc == 0 && builder_count(g->builder, SCENE_TRIANGLES) == 0)
        rc = fault_set(fault, ERR_MISSING, "scene", "the scene has no triangles");
    if (rc == 0) rc = gltf_images_decode(g, fault); /* the costly part, once the rest is sound */
    if (rc == 0) rc = gltf_lights_read(g, fault);
    if (rc == 0) rc = gltf_cameras_read(g, fault);
    return rc;
}

int gltf_import(struct files *files, const char *name, const struct scene_choice *choice,
                const struct file_view *main, struct builder *builder, struct fault *fault)
{
    struct gltf g = {
        .files = files, .builder = builder, .name = name, .default_material = SCENE_NONE};
    int rc = import_document(&g, choice, main, fault);
    gltf_draco_end(&g);
    colored_materials_fini(&g.colored);
    gltf_nodes_fini(&g.nodes);
    gltf_textures_fini(&g);
    gltf_buffers_fini(&g);
    free(g.uv_sets);
    json_decref(g.root);
    return rc;
}
