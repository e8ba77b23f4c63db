#include "worker/scene/lobe_boxes.h"

#include <math.h>
#include <stdlib.h>

#include "worker/scene/render_scene.h"

static const struct lobe_box nothing = {{INFINITY, INFINITY, INFINITY},
                                        {-INFINITY, -INFINITY, -INFINITY}};

static void add_point(const float p[3], struct lobe_box *box)
{
    for (int c = 0; c < 3; c++) {
        box->low[c] = fminf(box->low[c], p[c]);
        box->high[c] = fmaxf(box->high[c], p[c]);
    }
}

void lobe_box_of_mesh(const struct mesh_view *mesh, struct lobe_box *box)
{
    *box = nothing;
    for (size_t k = 0; k < (size_t)3 * mesh->triangle_count; k++)
        add_point(mesh->positions + (size_t)3 * mesh->triangles[k], box);
}

/* Adds the corners of the mesh's box, where the instance puts them. */
static void add_instance(const struct scene_instance *instance, const struct lobe_box *mesh,
                         struct lobe_box *box)
{
    const float *const end[2] = {mesh->low, mesh->high};
    for (int corner = 0; corner < 8; corner++) {
        const float *m = instance->to_world;
        float p[3];
        for (int c = 0; c < 3; c++, m += 4)
            p[c] = m[0] * end[corner & 1][0] + m[1] * end[corner >> 1 & 1][1] +
                   m[2] * end[corner >> 2][2] + m[3];
        add_point(p, box);
    }
}

/* What boxes are found of. */
struct finder {
    enum lobe_boxes_of kind;
    const struct scene *blob;
    const struct mesh_view *meshes;
    const struct lobe_box *of_base;
    struct lobe_box *of_mesh; /* room for those of all meshes */
};

static bool is_wanted(const struct finder *f, const struct scene_instance *instance)
{
    const struct mesh_view *mesh = &f->meshes[instance->mesh];
    if (mesh->triangle_count == 0) return false;
    if (f->kind == BOXES_OF_VIRTUAL) return instance_class(instance) == INSTANCE_IS_VIRTUAL;
    return (mesh->traits & (MESH_REFLECTS | MESH_BUMPY)) != 0;
}

/* Each mesh once, however often it is placed. */
static void find_meshes(const struct finder *f, uint64_t instances)
{
    bool *const found = (bool *)(f->of_mesh + f->blob->count[SCENE_MESHES]);
    for (uint64_t i = 0; i < instances; i++) {
        const uint32_t k = f->blob->instances[i].mesh;
        if (found[k] || !is_wanted(f, &f->blob->instances[i])) continue;
        found[k] = true;
        if (f->blob->meshes[k].flags & MESH_IN_BASE)
            f->of_mesh[k] = f->of_base[k];
        else
            lobe_box_of_mesh(&f->meshes[k], &f->of_mesh[k]);
    }
}

static void find_all(const struct finder *f, struct lobe_boxes *out)
{
    const uint64_t instances = f->blob->count[SCENE_INSTANCES];
    uint64_t wanted = 0, done = 0;
    find_meshes(f, instances);
    for (uint64_t i = 0; i < instances; i++) wanted += is_wanted(f, &f->blob->instances[i]);
    const uint64_t each = (wanted + LOBE_BOXES_MAX - 1) / LOBE_BOXES_MAX;
    for (uint64_t i = 0; i < instances; i++) {
        const struct scene_instance *instance = &f->blob->instances[i];
        if (!is_wanted(f, instance)) continue;
        struct lobe_box *box = &out->box[done / each]; /* wanted, and so each, is at least 1 */
        if (done++ % each == 0) *box = nothing;
        add_instance(instance, &f->of_mesh[instance->mesh], box);
    }
    out->count = each > 0 ? (uint32_t)((done + each - 1) / each) : 0;
}

static bool has_real(const struct scene *blob)
{
    for (uint64_t i = 0; i < blob->count[SCENE_INSTANCES]; i++)
        if (instance_class(&blob->instances[i]) != INSTANCE_IS_VIRTUAL) return true;
    return false;
}

int lobe_boxes_create(enum lobe_boxes_of kind, const struct scene *blob,
                      const struct mesh_view *meshes, const struct lobe_box *of_base,
                      struct lobe_boxes **out)
{
    const size_t count = (size_t)blob->count[SCENE_MESHES] + 1;
    *out = NULL;
    if (kind == BOXES_OF_VIRTUAL && !has_real(blob)) return 0;
    struct lobe_box *of_mesh = calloc(count, sizeof *of_mesh + sizeof(bool));
    struct lobe_boxes *boxes = of_mesh ? calloc(1, sizeof *boxes) : NULL;
    const struct finder f = {kind, blob, meshes, of_base, of_mesh};
    if (boxes) find_all(&f, boxes);
    free(of_mesh);
    *out = boxes;
    return boxes ? 0 : ERR_MEMORY;
}

void lobe_boxes_destroy(struct lobe_boxes **boxes)
{
    free(*boxes);
    *boxes = NULL;
}
