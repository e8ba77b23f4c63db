#include "server/import/rgbd/rgbd_model.h"

#include <stdlib.h>

#include "server/import/rgbd/rgbd_fuse.h"
#include "server/import/rgbd/rgbd_parts.h"
#include "server/import/rgbd/rgbd_place.h"

static int append(struct rgbd_model *m, struct rgbd_fused *fused, struct builder *b,
                  struct fault *fault)
{
    const struct affine there = affine_translation(fused->origin);
    const struct affine to_scene = affine_multiply(&m->place, &there);
    m->width = fused->width;
    m->height = fused->height;
    m->all_shine = fused->first_shining == 0;
    m->first = builder_count(b, SCENE_MESHES);
    int rc = mesh_transform(&fused->mesh, &to_scene, "/rgbd", fault);
    if (rc == 0) rc = rgbd_append_mesh(&fused->mesh, fused->first_shining, b, fault);
    m->end = builder_count(b, SCENE_MESHES);
    return rc;
}

static int find_light(struct rgbd_model *m, struct files *files, const struct scene_choice *choice,
                      struct warnings *warnings, struct fault *fault)
{
    m->light = malloc(sizeof *m->light);
    if (m->light == NULL) return fault_set(fault, ERR_MEMORY, "/rgbd", "no memory for its light");
    return rgbd_light_find(&m->document, files, &m->place, choice, m->light, warnings, fault);
}

int rgbd_model_open(struct rgbd_model *m, struct files *files, const struct scene_choice *choice,
                    struct builder *b, struct fault *fault)
{
    struct rgbd_fused fused;
    *m = (struct rgbd_model){.first = 0};
    int rc = rgbd_document_open(&m->document, files, choice->rgbd, fault);
    if (rc == 0) rc = rgbd_place_find(&m->document, files, &m->place, &b->warnings, fault);
    if (rc == 0) rc = find_light(m, files, choice, &b->warnings, fault);
    if (rc == 0) rc = rgbd_fuse(&m->document, files, &fused, &b->warnings, fault);
    if (rc != 0) return rc;
    rc = append(m, &fused, b, fault);
    mesh_fini(&fused.mesh);
    return rc;
}

void rgbd_model_close(struct rgbd_model *m)
{
    rgbd_document_close(&m->document);
    free(m->light);
    m->light = NULL;
}

/* Gives the base's meshes the material that the frame has for them. */
static int color_meshes(const struct rgbd_model *m, struct builder *b, struct fault *fault)
{
    uint32_t name;
    const uint32_t material = (uint32_t)builder_count(b, SCENE_MATERIALS);
    const int rc = rgbd_append_material(b, &name, fault);
    for (uint64_t k = m->first; k < m->end && rc == 0; k++) {
        builder_meshes(b)[k].material = material;
        builder_meshes(b)[k].name = name;
    }
    return rc;
}

int rgbd_model_add_frame(const struct rgbd_model *m, const struct scene_choice *choice,
                         double time_s, struct builder *b, struct fault *fault)
{
    const struct rgbd_document *d = &m->document;
    const double by[3] = {-b->origin[0], -b->origin[1], -b->origin[2]};
    uint32_t frame;
    int rc = rgbd_find_frame(d, time_s, &frame, fault);
    if (rc == 0 && b->base) rc = color_meshes(m, b, fault);
    if (rc == 0) rc = rgbd_place_parts(b, m->first, m->end, m->all_shine, by, fault);
    b->moves = true;
    if (rc != 0) return rc;
    const struct affine to_scene = rgbd_camera_in(d, frame, &m->place, b->origin);
    rc = rgbd_append_camera(d, m->width, m->height, &to_scene, b, fault);
    if (rc == 0) rc = rgbd_set_plate(d, frame, b, fault);
    return rc == 0 ? rgbd_light_add(m->light, choice, b, fault) : rc;
}
