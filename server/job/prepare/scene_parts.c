#include "server/job/prepare/scene_parts.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Returns the part of a name, which is begun if there is none; NULL where no more are told of. */
static struct scene_part *part_of(struct scene_part *parts, uint32_t *count, const char *name)
{
    for (uint32_t i = 0; i < *count; i++)
        if (strcmp(parts[i].name, name) == 0) return &parts[i];
    if (*count == SCENE_PARTS_MAX || strlen(name) >= LIMIT_NAME_BYTES) return NULL;
    struct scene_part *part = &parts[(*count)++];
    *part = (struct scene_part){.lowest = {INFINITY, INFINITY, INFINITY},
                                .highest = {-INFINITY, -INFINITY, -INFINITY}};
    snprintf(part->name, sizeof part->name, "%s", name);
    return part;
}

/* What a mesh fills, in its own coordinates. */
struct mesh_box {
    bool found;
    float corner[2][3]; /* the lowest, the highest */
};

static void find_box(const struct scene *scene, const struct scene_mesh *mesh, struct mesh_box *box)
{
    const float *p = scene_mesh_home(scene, mesh)->positions + (size_t)3 * mesh->first_vertex;
    for (int c = 0; c < 3; c++) box->corner[0][c] = INFINITY, box->corner[1][c] = -INFINITY;
    for (uint32_t i = 0; i < mesh->vertex_count; i++, p += 3)
        for (int c = 0; c < 3; c++) {
            box->corner[0][c] = fminf(box->corner[0][c], p[c]);
            box->corner[1][c] = fmaxf(box->corner[1][c], p[c]);
        }
    box->found = true;
}

/* By the corners of the mesh's box: a scene may have millions of instances. */
static void widen(struct scene_part *part, const float to_world[12], const struct mesh_box *box)
{
    for (int k = 0; k < 8; k++) {
        const float p[3] = {box->corner[k & 1][0], box->corner[k >> 1 & 1][1],
                            box->corner[k >> 2][2]};
        for (int c = 0; c < 3; c++) {
            const float *row = to_world + 4 * c;
            const float at = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
            part->lowest[c] = fminf(part->lowest[c], at);
            part->highest[c] = fmaxf(part->highest[c], at);
        }
    }
}

int scene_parts_find(const struct scene *scene, struct scene_part **out, uint32_t *count)
{
    struct scene_part *parts = calloc(SCENE_PARTS_MAX, sizeof *parts);
    struct mesh_box *boxes = calloc(scene->count[SCENE_MESHES] + 1, sizeof *boxes);
    *count = 0;
    if (!parts || !boxes) {
        free(parts);
        free(boxes);
        return ERR_MEMORY;
    }
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        const char *name = scene_name(scene, instance->name);
        if (name[0] == '\0' || scene->meshes[instance->mesh].vertex_count == 0) continue;
        struct scene_part *part = part_of(parts, count, name);
        if (!part) continue;
        part->flags |= instance->flags & (INSTANCE_CATCHER | INSTANCE_HOLDOUT);
        struct mesh_box *box = &boxes[instance->mesh];
        if (!box->found) find_box(scene, &scene->meshes[instance->mesh], box);
        widen(part, instance->to_world, box);
    }
    free(boxes);
    *out = parts;
    return 0;
}

const char *scene_part_role(const struct scene_part *part)
{
    if (part->flags & INSTANCE_HOLDOUT) return "holdout";
    return part->flags & INSTANCE_CATCHER ? "catcher" : "virtual";
}
