#include "server/import/scene/roles.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "proto/json.h"
#include "server/import/scene/mesh.h"
#include "server/import/scene/surface.h"

/* Half the ground's side over the scene's radius: a ball of that radius covers a thousandth of the
 * sky there. */
#define GROUND_RADII 32.0

/* What it reflects; only virtual objects see it. */
#define GROUND_ALBEDO 0.5f

static bool is_called(const struct builder *b, const struct scene_instance *instance,
                      const char *name)
{
    const char *names = (const char *)b->sections[SCENE_NAMES].data;
    const struct scene_mesh *mesh = &builder_meshes(b)[instance->mesh];
    const struct scene_material *material = &builder_materials(b)[mesh->material];
    return strcmp(names + instance->name, name) == 0 || strcmp(names + material->name, name) == 0;
}

/* Gives all instances of a name a role. `place` is the name's in the job document. */
static int apply_name(struct builder *b, const char *given, uint32_t role, bool whole,
                      const char *place, struct fault *fault)
{
    const uint32_t roles = INSTANCE_CATCHER | INSTANCE_HOLDOUT;
    char name[LIMIT_NAME_BYTES];
    bool found = false;
    snprintf(name, sizeof name, "%s", given);
    text_make_printable(name);
    for (uint64_t i = 0; i < builder_count(b, SCENE_INSTANCES); i++) {
        struct scene_instance *instance = &builder_instances(b)[i];
        if (!is_called(b, instance, name)) continue;
        found = true;
        if (instance->flags & roles & ~role)
            return fault_set(fault, ERR_EXISTS, place, "\"%s\" is a catcher and a holdout", name);
        instance->flags |= role;
    }
    if (found || !whole) return 0;
    return fault_set(fault, ERR_NOT_FOUND, place, "the scene has no node or material \"%s\"", name);
}

static int apply_list(struct builder *b, const char *list, uint32_t role, bool whole,
                      const char *member, struct fault *fault)
{
    json_t *names;
    char place[64];
    size_t i;
    json_t *one;
    int rc = json_read(list, strlen(list), LIMIT_JOB_BYTES, &names, fault);
    if (rc != 0) return rc;
    json_array_foreach (names, i, one) {
        snprintf(place, sizeof place, "/%s/%zu", member, i);
        const char *name = json_string_value(one);
        if (rc == 0 && name != NULL) rc = apply_name(b, name, role, whole, place, fault);
    }
    json_decref(names);
    return rc;
}

int roles_apply(struct builder *b, const struct scene_choice *choice, bool whole,
                struct fault *fault)
{
    if (choice->catchers == NULL) return 0;
    b->is_composite = true;
    int rc = apply_list(b, choice->catchers, INSTANCE_CATCHER, whole, "catchers", fault);
    if (rc == 0 && choice->holdouts != NULL)
        rc = apply_list(b, choice->holdouts, INSTANCE_HOLDOUT, whole, "holdouts", fault);
    return rc;
}

static struct scene_info *info_of(const struct builder *b)
{
    return (struct scene_info *)(void *)b->sections[SCENE_INFO].data;
}

static int append_square(struct builder *b, const float centre[3], float half, struct fault *fault)
{
    float positions[12];
    uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    const struct mesh square = {
        .vertex_count = 4, .triangle_count = 2, .positions = positions, .triangles = triangles};
    struct scene_mesh mesh;
    const struct scene_instance instance = {.mesh = (uint32_t)builder_count(b, SCENE_MESHES),
                                            .flags = INSTANCE_IDENTITY | INSTANCE_CATCHER,
                                            .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    for (int k = 0; k < 4; k++) { /* counter-clockwise from above */
        positions[3 * k] = centre[0] + (k == 0 || k == 1 ? -half : half);
        positions[3 * k + 1] = centre[1];
        positions[3 * k + 2] = centre[2] + (k == 0 || k == 3 ? -half : half);
    }
    int rc = mesh_append(&square, b, &mesh, fault);
    mesh.material = (uint32_t)builder_count(b, SCENE_MATERIALS) - 1;
    mesh.name = 0;
    if (rc == 0) rc = builder_append_record(b, SCENE_MESHES, &mesh, fault);
    return rc == 0 ? builder_append_record(b, SCENE_INSTANCES, &instance, fault) : rc;
}

int roles_add_ground(struct builder *b, const struct scene_choice *choice, struct fault *fault)
{
    struct scene_material material;
    float centre[3];
    double squared = 0;
    if (!choice->has_ground) return 0;
    const struct scene_info *info = info_of(b);
    for (int c = 0; c < 3; c++) {
        const double side = (double)info->bounds_max[c] - (double)info->bounds_min[c];
        centre[c] = (float)(0.5 * ((double)info->bounds_max[c] + (double)info->bounds_min[c]));
        squared += side * side / 4;
    }
    centre[1] = (float)(choice->ground_height - b->origin[1]);
    surface_init(&material);
    material.metallic = material.specular = 0;
    material.flags = MATERIAL_DOUBLE_SIDED;
    for (int c = 0; c < 3; c++) material.base_color[c] = GROUND_ALBEDO;
    int rc = builder_append_record(b, SCENE_MATERIALS, &material, fault);
    if (rc == 0) rc = append_square(b, centre, (float)(GROUND_RADII * sqrt(squared)), fault);
    if (rc == 0) info_of(b)->placed_triangles += 2;
    return rc;
}
