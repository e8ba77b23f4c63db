#include "server/reconstruct/compose/compose_diffuse.h"

/* Returns whether the pixel's centre reflects anything diffusely. */
static bool is_diffuse(const struct patch *p, size_t i)
{
    return !p->albedo[0] || p->albedo[0][i] > 0.0f || p->albedo[1][i] > 0.0f ||
           p->albedo[2][i] > 0.0f;
}

/* `adds`: to what paths have put. */
static void put(const struct resolver *r, const float *light, bool adds, struct rect block,
                const struct plane *out)
{
    const bool divided = r->plan->paths.without_diffuse_direct != 0;
    for (int32_t y = block.y0; y < block.y1; y++) {
        const size_t first = patch_pixel(r->patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) {
            const size_t i = first + (size_t)x;
            const float own = !divided || is_diffuse(r->patch, i) ? light[i] : 0.0f;
            to[x] = divided && adds ? to[x] + own : own;
        }
    }
}

static void put_layer(const struct resolver *r, float *const light[3], const char *const *names,
                      bool adds, struct rect block, struct image *image)
{
    for (int c = 0; c < 3; c++) {
        const struct plane *out = image_plane(image, names[c]);
        if (out) put(r, light[c], adds, block, out);
    }
}

void compose_diffuse_direct(const struct resolver *r, struct rect block, struct image *image)
{
    static const char *const names[] = {"diffuse_direct.R", "diffuse_direct.G", "diffuse_direct.B"};
    put_layer(r, r->lighting->direct, names, r->patch->path_diffuse_direct[0], block, image);
}

void compose_diffuse_indirect(const struct resolver *r, struct rect block, struct image *image)
{
    static const char *const names[] = {"diffuse_indirect.R", "diffuse_indirect.G",
                                        "diffuse_indirect.B"};
    put_layer(r, r->lighting->indirect, names, r->patch->path_diffuse_indirect[0], block, image);
}
