/* What holds of each picture by itself. Tolerances are of relative RMS differences after some
 * pixels are left out: an edge that falls on a sample may fall to its other side by rounding, and
 * the sample with it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/property/property.h"

/* Pixels that may differ by more: edges, and what filters make of them around. */
#define SPARED       0.05
#define SPARED_MOVED 0.15
/* Samples travel as half floats: other factors than powers of two round them otherwise. */
#define BRIGHTER_MAX 5e-3
/* Powers of two round nothing; constants of the product, such as the least distance of rays, must
 * follow. */
#define SCALED_MAX 1e-5
/* Hits are off by 1/128 of the size then. */
#define MOVED_MAX  0.1
#define MOVED_GRID 0.125
#define MOVED_BACK 16
enum { MOVED_MIN_PX = 16 };
/* Where numbers that are not finite are cut off, they are as large as what they are cut to. */
#define FINITE_MAX 1e25f

struct image *property_picture(const struct property_case *c, const struct change *change,
                               char says[PROPERTY_SAYS_BYTES])
{
    return picture_render(c, change, says, PROPERTY_SAYS_BYTES);
}

static int descending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

double property_apart(const struct image *a, const struct image *b, double gain, double spared)
{
    static const char *const names[] = {"R", "G", "B"};
    const size_t pixels = (size_t)a->width_px * (size_t)a->height_px;
    double *off = calloc(pixels, sizeof *off), sum = 0, all = 0;
    if (!off) abort();
    for (int k = 0; k < 3; k++) {
        const struct plane *p = image_plane(a, names[k]), *q = image_plane(b, names[k]);
        for (size_t i = 0; i < pixels; i++) {
            const int32_t x = (int32_t)(i % (size_t)a->width_px),
                          y = (int32_t)(i / (size_t)a->width_px);
            const double v = (double)*plane_at(p, x, y) * gain, d = (double)*plane_at(q, x, y) - v;
            off[i] += d * d;
            all += v * v;
        }
    }
    qsort(off, pixels, sizeof *off, descending);
    for (size_t i = (size_t)ceil(spared * (double)pixels); i < pixels; i++) sum += off[i];
    free(off);
    return all > 0 ? sqrt(sum / all) : sum > 0 ? INFINITY : 0;
}

enum property_result property_finite(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    enum property_result result = PROPERTY_HOLDS;
    struct image *image = property_picture(c, &none, says);
    if (!image) return PROPERTY_DOES_NOT_APPLY;
    for (uint32_t k = 0; k < image->channel_count && result == PROPERTY_HOLDS; k++)
        for (int32_t y = 0; y < image->height_px && result == PROPERTY_HOLDS; y++)
            for (int32_t x = 0; x < image->width_px; x++) {
                const float v = *plane_at(&image->channels[k].plane, x, y);
                /* What no ray meets is infinitely far. */
                if (fabsf(v) < FINITE_MAX || (!strcmp(image->channels[k].name, "depth.Z") && v > 0))
                    continue;
                snprintf(says, PROPERTY_SAYS_BYTES, "%s of pixel %d, %d is %g",
                         image->channels[k].name, x, y, (double)v);
                result = PROPERTY_FAILS;
                break;
            }
    image_destroy(&image);
    return result;
}

/* Two pictures of a case, one of them changed. */
static enum property_result alike(const struct property_case *c, const struct property_case *other,
                                  const struct change *change, double gain, double spared,
                                  double most, char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    struct image *a = property_picture(c, &none, says),
                 *b = a ? property_picture(other, change, says) : NULL;
    enum property_result result = PROPERTY_DOES_NOT_APPLY;
    if (a && b) {
        const double apart = property_apart(a, b, gain, spared);
        snprintf(says, PROPERTY_SAYS_BYTES, "%.3g apart, not %.3g", apart, most);
        result = apart <= most ? PROPERTY_HOLDS : PROPERTY_FAILS;
    } else if (a) {
        /* What is accepted as it is must be accepted changed. */
        result = PROPERTY_FAILS;
    }
    image_destroy(&a);
    image_destroy(&b);
    return result;
}

/* Tiles and blocks of any size, and results in any order: the same bytes. Under a target tiles are
 * what gets more samples, so that these stay. */
enum property_result property_cut(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct change change = {.backwards = true};
    struct property_case other = *c;
    if (c->error == 0) other.tile = c->tile == 16 ? 64 : 16;
    other.block = c->block == 32 ? 256 : 32;
    return alike(c, &other, &change, 1, 0, 0, says);
}

/* 10^-4 to 10^4. Other factors than powers of two round coordinates, and of surfaces that lie in
 * one place another may then be the first. */
enum property_result property_scaled(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    static const double scales[] = {0x1p-14, 0x1p-10, 0.125, 8, 0x1p10, 0x1p14};
    const struct change change = {.scale = scales[c->seed % 6]};
    return alike(c, c, &change, 1, 0, SCALED_MAX, says);
}

static void coarsen(double *v, int count)
{
    for (int i = 0; i < count; i++) v[i] = round(v[i] / MOVED_GRID) * MOVED_GRID;
}

/* Colours that no light touches are what they are, however bright lights are and how many. */
void property_light_up(struct property_case *c)
{
    for (int i = 0; i < c->body_count; i++)
        if (c->bodies[i].dress == DRESS_UNLIT) c->bodies[i].dress = DRESS_COLOR;
}

/* Details are of MOVED_GRID and more, and no needles: smaller ones are lost so far away, which is
 * no fault. In a picture of a few pixels edges would be all that there is. */
enum property_result property_moved(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    /* The scene is some four wide; its coordinates stay multiples of what floats have there. */
    const double away[3] = {1e5, c->seed % 2 ? -1e5 : 0, c->seed % 3 ? 5e4 : 0};
    struct property_case coarse = *c;
    coarse.width = c->width < MOVED_MIN_PX ? MOVED_MIN_PX : c->width;
    coarse.height = c->height < MOVED_MIN_PX ? MOVED_MIN_PX : c->height;
    for (int i = 0; i < c->body_count; i++) {
        if (c->bodies[i].shape > BODY_ROOM) coarse.bodies[i].shape = BODY_PANEL;
        coarse.bodies[i].dress = DRESS_PLAIN; /* texels are smaller */
        coarsen(coarse.bodies[i].centre, 3);
        coarsen(coarse.bodies[i].size, 3);
    }
    for (int i = 0; i < c->light_count; i++) coarsen(coarse.lights[i].centre, 3);
    struct change change = {.shift = {away[0], away[1], away[2]}};
    const enum property_result result =
        alike(&coarse, &coarse, &change, 1, SPARED_MOVED, MOVED_MAX, says);
    if (result != PROPERTY_FAILS) return result;
    /* An edge close to a light moves its shadow by a lot. That is gone where coordinates have more
     * digits; surfaces that shade themselves do so anywhere. */
    for (int i = 0; i < 3; i++) change.shift[i] /= MOVED_BACK;
    return alike(&coarse, &coarse, &change, 1, SPARED_MOVED, MOVED_MAX, says);
}

/* Whether meshes shine: which of them a path looks at hangs on rounding, where factors are not
 * powers of two. */
static bool has_emitter(const struct property_case *c)
{
    for (int i = 0; i < c->body_count; i++)
        if (c->bodies[i].surface == SURFACE_EMITTER || c->bodies[i].dress == DRESS_GLOW)
            return true;
    return false;
}

/* Whether samples are dealt by numbers that rounding moves: then others are taken. */
static bool deals(const struct property_case *c)
{
    return c->error > 0 || c->lens_second_set > 0 || c->indirect == CASE_ADAPTIVE;
}

enum property_result property_brighter(const struct property_case *c,
                                       char says[PROPERTY_SAYS_BYTES])
{
    static const double gains[] = {1e-4, 1e-2, 3, 100, 1e4, 1e6},
                        twos[] = {0x1p-13, 0x1p-7, 2, 128, 0x1p13, 0x1p20};
    const bool exact = has_emitter(c) || deals(c);
    const struct change change = {.gain = (exact ? twos : gains)[c->seed % 6]};
    struct property_case lit = *c;
    property_light_up(&lit);
    return alike(&lit, &lit, &change, change.gain, SPARED, BRIGHTER_MAX, says);
}
