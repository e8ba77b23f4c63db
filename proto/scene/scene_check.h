#pragma once
/* The contents of a scene blob whose sections are known to lie where they should. */
#include "proto/scene/scene.h"

/* Checks every index and every number; *fault names record and field ("meshes[3].material"). */
int scene_check(const struct scene *s, struct fault *fault);

/* "positions" and so on. */
const char *scene_section_name(uint32_t section);
