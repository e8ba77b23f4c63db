#include "server/reconstruct/compose/catcher.h"

#include <math.h>
#include <stddef.h>

/* Where the view without the objects is black, noise of the other would burn out. */
#define RATIO_MAX 64.0f

static float ratio_of(float with, float without)
{
    if (with == without || !(without > 0.0f)) return 1.0f;
    return fminf(with / without, RATIO_MAX);
}

/* The planes of a layer; NULL for those that the image lacks. */
struct layer {
    const struct plane *of[4];
};

static struct layer find(const struct image *image, const char *const names[4])
{
    struct layer out = {{NULL}};
    for (int c = 0; c < 4 && names[c]; c++) out.of[c] = image_plane(image, names[c]);
    return out;
}

static float at(const struct plane *plane, int32_t x, int32_t y)
{
    return *plane_at(plane, x, y);
}

static void put(const struct plane *plane, int32_t x, int32_t y, float v)
{
    if (plane) *plane_at(plane, x, y) = v;
}

/* What a catcher's part of a pixel may be of the photograph there, over what it is in the view
 * without the objects. What is brighter is something else, such as a lamp. */
#define PART_MAX 4.0f

/* Returns the share of a pixel's photograph that is the catcher's. Where other things cover some of
 * the pixel, these may be much brighter, and do not change. */
static float share_of(float coverage, float without, float plate)
{
    if (coverage >= 1.0f || !(plate > 0.0f)) return coverage;
    return fminf(coverage, PART_MAX * without / plate);
}

struct composing {
    const struct catcher_views *views;
    struct layer objects, with, without, plate;          /* read */
    struct layer composite, catcher, overlay, backplate; /* filled */
};

static void compose_pixel(const struct composing *k, int32_t x, int32_t y)
{
    const float alpha = at(k->objects.of[3], x, y), left = 1.0f - alpha;
    const float coverage = fminf(at(k->with.of[3], x, y), 1.0f);
    float sum = 0.0f;
    for (int c = 0; c < 3; c++) {
        const float object = alpha > 0.0f ? at(k->objects.of[c], x, y) : 0.0f;
        const float with = at(k->with.of[c], x, y), without = at(k->without.of[c], x, y);
        const float plate = k->plate.of[c] ? at(k->plate.of[c], x, y) : 0.0f;
        const float share = share_of(coverage, without, plate);
        const float factor = 1.0f + share * (ratio_of(with, without) - 1.0f);
        const float behind =
            k->views->adds ? fmaxf(plate + (with - without), 0.0f) : plate * factor;
        sum += factor;
        put(k->composite.of[c], x, y, object + left * behind);
        put(k->catcher.of[c], x, y, k->views->adds ? with - without : factor);
        put(k->overlay.of[c], x, y, object);
        put(k->backplate.of[c], x, y, plate);
        put(k->objects.of[c], x, y, object);
    }
    put(k->overlay.of[3], x, y, 1.0f - left * fminf(sum / 3.0f, 1.0f));
}

void catcher_compose(const struct catcher_views *views, struct rect rect, struct image *picture)
{
    static const char *const light[4] = {"R", "G", "B", "A"};
    static const char *const composite[4] = {"composite.R", "composite.G", "composite.B"};
    static const char *const catcher[4] = {"catcher.R", "catcher.G", "catcher.B"};
    static const char *const overlay[4] = {"overlay.R", "overlay.G", "overlay.B", "overlay.A"};
    static const char *const backplate[4] = {"backplate.R", "backplate.G", "backplate.B"};
    struct composing k = {.views = views,
                          .objects = find(picture, light),
                          .with = find(views->with, light),
                          .without = find(views->without, light),
                          .composite = find(picture, composite),
                          .catcher = find(picture, catcher),
                          .overlay = find(picture, overlay),
                          .backplate = find(picture, backplate)};
    if (views->plate) k.plate = find(views->plate, light);
    for (int32_t y = rect.y0; y < rect.y1; y++)
        for (int32_t x = rect.x0; x < rect.x1; x++) compose_pixel(&k, x, y);
}
