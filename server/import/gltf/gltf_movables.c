/* The meshes of a base that frames place. */
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"

/* By mesh, primitive, poser: the first three numbers. */
static int compare(const void *a, const void *b)
{
    const struct gltf_movable *x = a, *y = b;
    const uint32_t keys[3][2] = {
        {x->mesh, y->mesh}, {x->primitive, y->primitive}, {x->poser, y->poser}};
    for (int i = 0; i < 3; i++)
        if (keys[i][0] != keys[i][1]) return keys[i][0] < keys[i][1] ? -1 : 1;
    return 0;
}

int gltf_movable_keep(struct gltf *g, const struct gltf_movable *movable, struct fault *fault)
{
    if (g->movable_count == g->movable_capacity) {
        const uint32_t capacity = g->movable_capacity * 2 + 16;
        struct gltf_movable *list = realloc(g->movables, capacity * sizeof *list);
        if (list == NULL) return fault_set(fault, ERR_MEMORY, "meshes", "no memory for what moves");
        g->movables = list;
        g->movable_capacity = capacity;
    }
    g->movables[g->movable_count++] = *movable;
    return 0;
}

void gltf_movables_sort(struct gltf *g)
{
    if (g->movable_count > 0) qsort(g->movables, g->movable_count, sizeof *g->movables, compare);
}

const struct gltf_movable *gltf_movable_find(const struct gltf *g, uint32_t mesh,
                                             uint32_t primitive, uint32_t poser)
{
    const struct gltf_movable key = {.mesh = mesh, .primitive = primitive, .poser = poser};
    if (g->movable_count == 0) return NULL;
    return bsearch(&key, g->movables, g->movable_count, sizeof key, compare);
}
