#include "server/job/prepare/scene_parts.h"

#include <math.h>
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

static void widen(struct scene_part *part, const struct scene *scene,
                  const struct scene_instance *instance)
{
    const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
    const float *m = instance->to_world;
    const float *p = scene_mesh_home(scene, mesh)->positions + (size_t)3 * mesh->first_vertex;
    for (uint32_t i = 0; i < mesh->vertex_count; i++, p += 3)
        for (int c = 0; c < 3; c++) {
            const float *row = m + 4 * c;
            const float at = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
            part->lowest[c] = fminf(part->lowest[c], at);
            part->highest[c] = fmaxf(part->highest[c], at);
        }
}

int scene_parts_find(const struct scene *scene, struct scene_part **out, uint32_t *count)
{
    struct scene_part *parts = calloc(SCENE_PARTS_MAX, sizeof *parts);
    *count = 0;
    if (!parts) return ERR_MEMORY;
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        const char *name = scene_name(scene, instance->name);
        if (name[0] == '\0' || scene->meshes[instance->mesh].vertex_count == 0) continue;
        struct scene_part *part = part_of(parts, count, name);
        if (!part) continue;
        part->flags |= instance->flags & (INSTANCE_CATCHER | INSTANCE_HOLDOUT);
        widen(part, scene, instance);
    }
    *out = parts;
    return 0;
}

const char *scene_part_role(const struct scene_part *part)
{
    if (part->flags & INSTANCE_HOLDOUT) return "holdout";
    return part->flags & INSTANCE_CATCHER ? "catcher" : "virtual";
}
