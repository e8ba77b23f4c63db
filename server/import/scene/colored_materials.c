#include "server/import/scene/colored_materials.h"

#include <stdlib.h>
#include <string.h>

static int reserve(struct colored_materials *c, uint32_t count, struct fault *fault)
{
    if (count <= c->count) return 0;
    uint32_t *copies = realloc(c->copies, count * sizeof *copies);
    if (copies == NULL) return fault_set(fault, ERR_MEMORY, "materials", "no memory for materials");
    for (uint32_t i = c->count; i < count; i++) copies[i] = SCENE_NONE;
    c->copies = copies;
    c->count = count;
    return 0;
}

int colored_material_get(struct colored_materials *c, struct builder *b, uint32_t material,
                         uint32_t *out, struct fault *fault)
{
    void *at;
    int rc = reserve(c, material + 1, fault);
    if (rc != 0) return rc;
    if (c->copies[material] == SCENE_NONE) {
        const uint32_t copy = (uint32_t)builder_count(b, SCENE_MATERIALS);
        rc = builder_append(b, SCENE_MATERIALS, 1, &at, fault);
        if (rc != 0) return rc;
        struct scene_material record = builder_materials(b)[material];
        record.flags |= MATERIAL_COLORED;
        memcpy(at, &record, sizeof record);
        c->copies[material] = copy;
    }
    *out = c->copies[material];
    return 0;
}

void colored_materials_cut(struct colored_materials *c, uint32_t count)
{
    for (uint32_t i = 0; i < c->count; i++)
        if (c->copies[i] != SCENE_NONE && c->copies[i] >= count) c->copies[i] = SCENE_NONE;
}

void colored_materials_fini(struct colored_materials *c)
{
    free(c->copies);
    *c = (struct colored_materials){0};
}
