#pragma once
/* Copies materials for meshes with colours of vertices, which multiply the base colour. Meshes
 * without colours keep the material of the file. */
#include "server/import/scene/builder.h"

struct colored_materials {
    uint32_t *copies; /* owned; by material; SCENE_NONE: none yet */
    uint32_t count;
};

/* Returns the coloured copy of a material, which is appended at its first use. */
int colored_material_get(struct colored_materials *c, struct builder *b, uint32_t material,
                         uint32_t *out, struct fault *fault);

/* Forgets copies from index `count` on. */
void colored_materials_cut(struct colored_materials *c, uint32_t count);
void colored_materials_fini(struct colored_materials *c);
