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

/* A layer's pixels of a row, from the rectangle's first on; NULL for channels that are not there.
 */
struct row {
    float *of[4];
};

static struct row row_of(const struct layer *layer, int32_t x, int32_t y)
{
    struct row out = {{NULL}};
    for (int c = 0; c < 4; c++)
        if (layer->of[c]) out.of[c] = plane_at(layer->of[c], x, y);
    return out;
}

static void put(float *to, size_t i, float v)
{
    if (to) to[i] = v;
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
    bool adds;
    struct row objects, with, without, plate;          /* read */
    struct row composite, catcher, overlay, backplate; /* filled */
};

static void compose_pixel(const struct composing *k, size_t i)
{
    const float alpha = k->objects.of[3][i], left = 1.0f - alpha;
    const float coverage = fminf(k->with.of[3][i], 1.0f);
    float sum = 0.0f;
    for (int c = 0; c < 3; c++) {
        const float object = alpha > 0.0f ? k->objects.of[c][i] : 0.0f;
        const float with = k->with.of[c][i], without = k->without.of[c][i];
        const float plate = k->plate.of[c] ? k->plate.of[c][i] : 0.0f;
        const float share = share_of(coverage, without, plate);
        const float factor = 1.0f + share * (ratio_of(with, without) - 1.0f);
        const float behind = k->adds ? fmaxf(plate + (with - without), 0.0f) : plate * factor;
        sum += factor;
        put(k->composite.of[c], i, object + left * behind);
        put(k->catcher.of[c], i, k->adds ? with - without : factor);
        put(k->overlay.of[c], i, object);
        put(k->backplate.of[c], i, plate);
        put(k->objects.of[c], i, object);
    }
    put(k->overlay.of[3], i, 1.0f - left * fminf(sum / 3.0f, 1.0f));
}

void catcher_compose(const struct catcher_views *views, struct rect rect, struct image *picture)
{
    static const char *const light[4] = {"R", "G", "B", "A"};
    static const char *const composite[4] = {"composite.R", "composite.G", "composite.B"};
    static const char *const catcher[4] = {"catcher.R", "catcher.G", "catcher.B"};
    static const char *const overlay[4] = {"overlay.R", "overlay.G", "overlay.B", "overlay.A"};
    static const char *const backplate[4] = {"backplate.R", "backplate.G", "backplate.B"};
    const struct layer objects = find(picture, light), with = find(views->with, light),
                       without = find(views->without, light), over = find(picture, overlay),
                       factor = find(picture, catcher), plate = find(picture, backplate),
                       whole = find(picture, composite);
    struct layer photograph = {{NULL}};
    if (views->plate) photograph = find(views->plate, light);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const struct composing k = {.adds = views->adds,
                                    .objects = row_of(&objects, rect.x0, y),
                                    .with = row_of(&with, rect.x0, y),
                                    .without = row_of(&without, rect.x0, y),
                                    .plate = row_of(&photograph, rect.x0, y),
                                    .composite = row_of(&whole, rect.x0, y),
                                    .catcher = row_of(&factor, rect.x0, y),
                                    .overlay = row_of(&over, rect.x0, y),
                                    .backplate = row_of(&plate, rect.x0, y)};
        for (size_t i = 0; i < (size_t)rect_width(rect); i++) compose_pixel(&k, i);
    }
}
