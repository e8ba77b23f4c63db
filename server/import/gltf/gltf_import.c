#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "server/import/gltf/gltf.h"
#include "server/import/gltf/gltf_animation.h"
#include "server/import/gltf/gltf_draco.h"
#include "server/import/scene/surface.h"

int gltf_open(struct gltf *g, struct files *files, const char *name,
              const struct scene_choice *choice, const struct file_view *main,
              struct builder *builder, struct fault *fault)
{
    *g = (struct gltf){
        .files = files, .builder = builder, .name = name, .default_material = SCENE_NONE};
    int rc = gltf_document_read(g, main, fault);
    if (rc == 0) rc = gltf_variant_find(g, choice->variant, fault);
    if (rc == 0) rc = gltf_buffers_init(g, fault);
    if (rc == 0) rc = gltf_animations_find(g, choice, fault);
    if (rc == 0) rc = gltf_textures_init(g, fault);
    builder->moves = g->moving.plays;
    if (rc == 0) rc = gltf_moves_find(g, choice->moves, fault);
    return rc;
}

void gltf_close(struct gltf *g)
{
    gltf_draco_end(g);
    colored_materials_fini(&g->colored);
    gltf_nodes_fini(&g->nodes);
    gltf_textures_fini(g);
    gltf_buffers_fini(g);
    gltf_moving_fini(&g->moving);
    gltf_moves_fini(&g->moves);
    free(g->movables);
    free(g->uv_sets);
    json_decref(g->root);
}

int gltf_read_whole(struct gltf *g, const struct scene_choice *choice, struct builder *b,
                    struct fault *fault)
{
    g->phase = GLTF_WHOLE;
    g->builder = b;
    struct warnings kept = b->warnings; /* finding what moves has warned of the same */
    int rc = gltf_animations_apply(g, choice, choice->time_s, fault);
    b->warnings = kept;
    if (rc == 0) rc = gltf_nodes_read(g, fault);
    if (rc == 0) gltf_moves_apply(g);
    if (rc == 0) gltf_origin_choose(g);
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

int gltf_read_base(struct gltf *g, struct builder *b, struct fault *fault)
{
    g->phase = GLTF_BASE;
    g->builder = b;
    int rc = gltf_nodes_read(g, fault);
    if (rc == 0) gltf_origin_choose(g);
    if (rc == 0) gltf_origin_move(g);
    if (rc == 0) rc = gltf_materials_read(g, fault);
    if (rc == 0) rc = gltf_meshes_read(g, fault);
    gltf_movables_sort(g);
    if (rc == 0) rc = gltf_images_decode(g, fault);
    g->base_materials = (uint32_t)builder_count(b, SCENE_MATERIALS);
    return rc;
}

/* Appends the base's material `index` that is not the file's, as what it is made from is now. */
static int append_extra_material(struct gltf *g, uint32_t index, uint32_t origin,
                                 struct fault *fault)
{
    void *at;
    struct scene_material record;
    int rc = builder_append(g->builder, SCENE_MATERIALS, 1, &at, fault);
    if (rc != 0) return rc;
    if (index == g->default_material) {
        surface_init(&record);
    } else {
        record = builder_materials(g->builder)[origin];
        record.flags |= MATERIAL_COLORED;
    }
    memcpy(at, &record, sizeof record);
    return 0;
}

/* The base's materials that are not the file's: the default one, and coloured copies. */
static int append_extra_materials(struct gltf *g, struct fault *fault)
{
    const uint32_t first = (uint32_t)gltf_count(g->root, "materials");
    uint32_t *origins = calloc((size_t)g->base_materials + 1, sizeof *origins);
    if (origins == NULL) return fault_set(fault, ERR_MEMORY, "materials", "no memory for them");
    colored_materials_cut(&g->colored, g->base_materials);
    if (g->default_material != SCENE_NONE && g->default_material >= g->base_materials)
        g->default_material = SCENE_NONE;
    for (uint32_t i = 0; i < g->colored.count; i++)
        if (g->colored.copies[i] != SCENE_NONE) origins[g->colored.copies[i]] = i;
    int rc = 0;
    for (uint32_t i = first; rc == 0 && i < g->base_materials; i++)
        rc = append_extra_material(g, i, origins[i], fault);
    free(origins);
    return rc;
}

int gltf_read_frame(struct gltf *g, const struct scene_choice *choice, double time_s,
                    struct builder *b, struct fault *fault)
{
    g->phase = GLTF_FRAME;
    g->builder = b;
    struct warnings kept = b->warnings; /* the base has warned of the same */
    int rc = gltf_animations_apply(g, choice, time_s, fault);
    if (rc == 0) rc = gltf_nodes_read(g, fault);
    if (rc == 0) gltf_moves_apply(g);
    if (rc == 0) gltf_origin_move(g);
    if (rc == 0) rc = gltf_materials_read(g, fault);
    b->warnings = kept;
    if (rc == 0) rc = append_extra_materials(g, fault);
    if (rc == 0) rc = gltf_meshes_read(g, fault);
    if (rc == 0) rc = gltf_lights_read(g, fault);
    if (rc == 0) rc = gltf_cameras_read(g, fault);
    return rc;
}

int gltf_import(struct files *files, const char *name, const struct scene_choice *choice,
                const struct file_view *main, struct builder *builder, struct fault *fault)
{
    struct gltf g;
    int rc = gltf_open(&g, files, name, choice, main, builder, fault);
    if (rc == 0) rc = gltf_read_whole(&g, choice, builder, fault);
    gltf_close(&g);
    return rc;
}
