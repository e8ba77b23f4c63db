#pragma once
/* Which nodes of a scene may be moved, and where they stand. */
#include "proto/scene/scene.h"

/* The most that are told of. */
#define SCENE_PARTS_MAX 64

/* All meshes of one name; in the scene's coordinates, without its origin. */
struct scene_part {
    char name[LIMIT_NAME_BYTES];
    uint32_t flags; /* INSTANCE_CATCHER, INSTANCE_HOLDOUT */
    float lowest[3], highest[3];
};

/* Finds the first parts that have names. The caller frees *out. ERR_MEMORY. */
int scene_parts_find(const struct scene *scene, struct scene_part **out, uint32_t *count);

/* Returns "catcher", "holdout" or "virtual". */
const char *scene_part_role(const struct scene_part *part);
