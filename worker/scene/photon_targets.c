#include "worker/scene/photon_targets.h"

#include <math.h>
#include <stdlib.h>

#include "worker/scene/lobe_boxes.h"
#include "worker/scene/photon_flight.h"
#include "worker/scene/render_scene.h"

/* Boxes of meshes, each found once, however often the mesh is placed. */
struct boxes {
    struct lobe_box *of;
    bool *found;
};

static const struct lobe_box *box_of(const struct render_scene *scene, const struct boxes *b,
                                     uint32_t mesh)
{
    if (scene->blob->meshes[mesh].flags & MESH_IN_BASE) return &scene->base->boxes[mesh];
    if (!b->found[mesh]) lobe_box_of_mesh(&scene->meshes[mesh], &b->of[mesh]);
    b->found[mesh] = true;
    return &b->of[mesh];
}

/* The sphere around the box where an instance puts it. */
static struct photon_target target_of(const struct lobe_box *box, const float m[12])
{
    struct photon_target t = {.radius = 0.0f};
    for (int k = 0; k < 3; k++, m += 4) {
        float half = 0.0f;
        t.middle[k] = m[3];
        for (int c = 0; c < 3; c++) {
            t.middle[k] += m[c] * 0.5f * (box->low[c] + box->high[c]);
            half += fabsf(m[c]) * 0.5f * (box->high[c] - box->low[c]);
        }
        t.radius += half * half;
    }
    t.radius = sqrtf(t.radius);
    return t;
}

static void add(struct photon_targets *s, const struct photon_target *t)
{
    uint32_t smallest = 0;
    if (!(t->radius > 0.0f) || !isfinite(t->radius)) return;
    if (s->count < PHOTON_TARGETS_MAX) {
        s->target[s->count++] = *t;
        return;
    }
    for (uint32_t k = 1; k < PHOTON_TARGETS_MAX; k++)
        if (s->target[k].radius < s->target[smallest].radius) smallest = k;
    if (s->target[smallest].radius < t->radius) s->target[smallest] = *t;
}

static void find_all(const struct render_scene *scene, const struct boxes *boxes,
                     struct photon_targets *out)
{
    const struct scene *blob = scene->blob;
    for (uint64_t i = 0; i < blob->count[SCENE_INSTANCES]; i++) {
        const struct scene_instance *instance = &blob->instances[i];
        const struct mesh_view *mesh = &scene->meshes[instance->mesh];
        if (mesh->triangle_count == 0 || !photon_flight_is_bent_by(mesh->material)) continue;
        struct photon_target t =
            target_of(box_of(scene, boxes, instance->mesh), instance->to_world);
        t.instance = (uint32_t)i;
        add(out, &t);
    }
}

int photon_targets_find(const struct render_scene *scene, struct photon_targets **out)
{
    const size_t meshes = (size_t)scene->blob->count[SCENE_MESHES];
    struct boxes boxes = {malloc((meshes + 1) * sizeof *boxes.of), calloc(meshes + 1, 1)};
    struct photon_targets *t = calloc(1, sizeof *t);
    const int error = boxes.of && boxes.found && t ? 0 : ERR_MEMORY;
    if (!error) find_all(scene, &boxes, t);
    if (error || t->count == 0) {
        free(t);
        t = NULL;
    }
    free(boxes.of);
    free(boxes.found);
    *out = t;
    return error;
}
