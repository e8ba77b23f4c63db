#include "server/reconstruct/compose/mattes.h"

#include <stdio.h>
#include <string.h>

#include "proto/scene/matte.h"

/* What is known of a layer; planes as the image's. */
struct matte_layer {
    const uint32_t *ids; /* MATTE_RANKS areas */
    const float *shares;
    const struct plane *color[3], *ranks[2 * MATTE_RANKS];
};

static bool find(const struct image *image, const char *name, struct matte_layer *l)
{
    static const char rgba[] = "RGBA";
    char channel[32];
    if (!l->ids || !l->shares) return false;
    for (uint32_t c = 0; c < 3; c++) {
        snprintf(channel, sizeof channel, "%s.%c", name, rgba[c]);
        l->color[c] = image_plane(image, channel);
        if (!l->color[c]) return false;
    }
    for (uint32_t k = 0; k < 2 * MATTE_RANKS; k++) {
        snprintf(channel, sizeof channel, "%s%02u.%c", name, k / 4, rgba[k % 4]);
        l->ranks[k] = image_plane(image, channel);
        if (!l->ranks[k]) return false;
    }
    return true;
}

/* The middle bits of a hash: every name has a colour of its own, mostly. */
static float color_of(uint32_t id, uint32_t c)
{
    return (float)(id >> (4 + 8 * c) & 255u) / 255.0f;
}

static void put_pixel(const struct matte_layer *l, size_t i, size_t area, int32_t x, int32_t y)
{
    float color[3] = {0};
    for (uint32_t r = 0; r < MATTE_RANKS; r++) {
        const uint32_t id = l->ids[r * area + i];
        const float share = l->shares[r * area + i];
        memcpy(plane_at(l->ranks[2 * r], x, y), &id, sizeof id);
        *plane_at(l->ranks[2 * r + 1], x, y) = share;
        for (uint32_t c = 0; c < 3; c++) color[c] += share * color_of(id, c);
    }
    for (uint32_t c = 0; c < 3; c++) *plane_at(l->color[c], x, y) = color[c];
}

static void put(const struct patch *patch, const struct matte_layer *l, struct rect block)
{
    const size_t area = (size_t)rect_area(patch->rect);
    for (int32_t y = block.y0; y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++)
            put_pixel(l, patch_pixel(patch, x, y), area, x, y);
}

void mattes_compose(const struct patch *patch, struct rect block, struct image *image)
{
    struct matte_layer objects = {.ids = patch->matte_objects,
                                  .shares = patch->matte_object_shares},
                       materials = {.ids = patch->matte_materials,
                                    .shares = patch->matte_material_shares};
    if (find(image, MATTE_OBJECT_LAYER, &objects)) put(patch, &objects, block);
    if (find(image, MATTE_MATERIAL_LAYER, &materials)) put(patch, &materials, block);
}
