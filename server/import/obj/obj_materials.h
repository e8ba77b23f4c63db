#pragma once
/* MTL materials with their textures. obj_shading.h says how they scatter. */
#include <assimp/scene.h>

#include "server/import/fence/files.h"
#include "server/import/obj/mtl.h"
#include "server/import/scene/builder.h"
#include "server/import/scene/colored_materials.h"

struct obj_materials {
    struct files *files;     /* borrowed */
    struct builder *builder; /* borrowed */
    const char *name;        /* borrowed; the OBJ's path, which textures lie beside */
    const struct mtl *mtl;   /* borrowed */
    const struct aiScene *scene;
    uint32_t *records;               /* owned; assimp's material -> scene_material or SCENE_NONE */
    char (*paths)[LIMIT_PATH_BYTES]; /* owned; parallel to SCENE_IMAGES */
    struct colored_materials colored;
};

int obj_materials_init(struct obj_materials *m, struct files *files, struct builder *builder,
                       const char *name, const struct mtl *mtl, const struct aiScene *scene,
                       struct fault *fault);
void obj_materials_fini(struct obj_materials *m);

/* Returns the scene's material for one of assimp's. It is appended with its textures at its first
 * use. */
int obj_material_get(struct obj_materials *m, unsigned index, uint32_t *out, struct fault *fault);
