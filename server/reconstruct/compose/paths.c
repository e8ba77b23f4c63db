#include "server/reconstruct/compose/paths.h"

#include "server/reconstruct/lighting/lighting.h"

/* Channels that are means of a sum. */
struct mean {
    const char *channel;
    const float *sum; /* NULL: not in the plan */
};

static size_t patch_index(const struct patch *patch, int32_t x, int32_t y)
{
    return (size_t)(y - patch->rect.y0) * (size_t)rect_width(patch->rect) +
           (size_t)(x - patch->rect.x0);
}

/* Also where sums have overflowed, or where they have and a difference was taken: no comparison
 * holds for NaN. */
static float bounded(float v)
{
    return v < LIGHTING_MAX ? v : LIGHTING_MAX;
}

static void put_mean(const struct patch *patch, const float *sum, struct rect block,
                     const struct plane *out)
{
    if (!sum || !out) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        const size_t first = patch_index(patch, block.x0, y);
        const float *in = sum + first, *spp = patch->paths.spp + first;
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) to[x] = bounded(in[x] / spp[x]);
    }
}

static void put_samples(const struct patch *patch, struct rect block, const struct plane *out)
{
    if (!out) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        const float *spp = patch->paths.spp + patch_index(patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) to[x] = spp[x];
    }
}

static uint64_t count_background(const struct patch *patch, struct rect block)
{
    uint64_t count = 0;
    for (int32_t y = block.y0; y < block.y1 && patch->paths.coverage; y++) {
        const float *in = patch->paths.coverage + patch_index(patch, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) count += in[x] == 0.0f;
    }
    return count;
}

void paths_compose(const struct patch *patch, struct rect block, struct image *image,
                   struct block_statistics *statistics)
{
    const struct patch_paths *p = &patch->paths;
    const struct mean means[] = {
        {"R", p->radiance[0]},
        {"G", p->radiance[1]},
        {"B", p->radiance[2]},
        {"A", p->coverage},
        {"direct.R", p->direct[0]},
        {"direct.G", p->direct[1]},
        {"direct.B", p->direct[2]},
        {"indirect.R", p->indirect[0]},
        {"indirect.G", p->indirect[1]},
        {"indirect.B", p->indirect[2]},
        {"emission.R", p->emission[0]},
        {"emission.G", p->emission[1]},
        {"emission.B", p->emission[2]},
        {"albedo.R", p->albedo[0]},
        {"albedo.G", p->albedo[1]},
        {"albedo.B", p->albedo[2]},
        {"diffuse_direct.R", p->diffuse_direct[0]},
        {"diffuse_direct.G", p->diffuse_direct[1]},
        {"diffuse_direct.B", p->diffuse_direct[2]},
        {"diffuse_indirect.R", p->diffuse_indirect[0]},
        {"diffuse_indirect.G", p->diffuse_indirect[1]},
        {"diffuse_indirect.B", p->diffuse_indirect[2]},
        {"occlusion.O", p->open},
    };
    for (size_t i = 0; i < sizeof means / sizeof means[0]; i++)
        put_mean(patch, means[i].sum, block, image_plane(image, means[i].channel));
    put_samples(patch, block, image_plane(image, "samples.N"));
    statistics->pixels_background += count_background(patch, block);
}
