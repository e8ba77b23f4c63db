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

static bool has_lobes(const struct mesh_view *mesh)
{
    return mesh->traits & (MESH_REFLECTS | MESH_BUMPY) && mesh->triangle_count > 0;
}

/* `of_mesh` has room for the boxes of all meshes. */
static void find_all(const struct scene *blob, const struct mesh_view *meshes,
                     const struct lobe_box *of_base, struct lobe_box *of_mesh,
                     struct lobe_boxes *out)
{
    const uint64_t instances = blob->count[SCENE_INSTANCES];
    uint64_t lobed = 0, done = 0;
    for (uint64_t k = 0; k < blob->count[SCENE_MESHES]; k++)
        if (blob->meshes[k].flags & MESH_IN_BASE)
            of_mesh[k] = of_base[k];
        else if (has_lobes(&meshes[k]))
            lobe_box_of_mesh(&meshes[k], &of_mesh[k]);
    for (uint64_t i = 0; i < instances; i++) lobed += has_lobes(&meshes[blob->instances[i].mesh]);
    const uint64_t each = (lobed + LOBE_BOXES_MAX - 1) / LOBE_BOXES_MAX;
    for (uint64_t i = 0; i < instances; i++) {
        const uint32_t mesh = blob->instances[i].mesh;
        if (!has_lobes(&meshes[mesh])) continue;
        struct lobe_box *box = &out->box[done / each]; /* lobed, and so each, is at least 1 */
        if (done++ % each == 0) *box = nothing;
        add_instance(&blob->instances[i], &of_mesh[mesh], box);
    }
    out->count = each > 0 ? (uint32_t)((done + each - 1) / each) : 0;
}

int lobe_boxes_create(const struct scene *blob, const struct mesh_view *meshes,
                      const struct lobe_box *of_base, struct lobe_boxes **out)
{
    struct lobe_box *of_mesh = calloc((size_t)blob->count[SCENE_MESHES] + 1, sizeof *of_mesh);
    struct lobe_boxes *boxes = of_mesh ? calloc(1, sizeof *boxes) : NULL;
    if (boxes) find_all(blob, meshes, of_base, of_mesh, boxes);
    free(of_mesh);
    *out = boxes;
    return boxes ? 0 : ERR_MEMORY;
}

void lobe_boxes_destroy(struct lobe_boxes **boxes)
{
    free(*boxes);
    *boxes = NULL;
}
