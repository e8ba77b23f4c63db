#pragma once
/* Reads MTL files as they are written. assimp is not used, because it cuts names at spaces and
 * drops options. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/error.h"
#include "server/import/fence/files.h"
#include "server/import/scene/warnings.h"

/* An image that a material names. */
struct mtl_image {
    char *name; /* owned; NULL: none */
    float scale[2], offset[2];
    bool clamp;
};

/* Bits of struct mtl_material's `given`. */
enum {
    MTL_KD = 1,
    MTL_KS = 2,
    MTL_KE = 4,
    MTL_TF = 8,
    MTL_NS = 16,
    MTL_NI = 32,
    MTL_D = 64,
    MTL_PM = 128,
    MTL_PR = 256,
    MTL_ILLUM = 512,
    MTL_MAP_KS = 1024, /* maps that are not drawn */
    MTL_MAP_METAL = 2048,
    MTL_MAP_BUMP = 4096
};

struct mtl_material {
    char *name; /* owned */
    uint32_t given;
    float kd[3], ks[3], ke[3], tf[3];
    float ns, ni, d, pm, pr; /* d: opacity, also from Tr */
    float illum;
    struct mtl_image map_kd, map_ke, map_d;
};

struct mtl {
    struct mtl_material *list; /* owned */
    uint32_t count;
};

/* Reads all libraries that an OBJ names, in its order; of one name the first counts. Of libraries
 * that are missing a warning tells. ERR_RANGE, ERR_LIMIT, ERR_MEMORY at "mtllib". */
int mtl_read(struct mtl *mtl, struct files *files, const char *obj_name,
             const struct file_view *obj, struct warnings *warnings, struct fault *fault);
void mtl_fini(struct mtl *mtl);

/* Returns a material by its name; NULL: no library has it. */
const struct mtl_material *mtl_find(const struct mtl *mtl, const char *name);
