/* Constant light fields: the case lends its size, cut, samples and filters to scenes whose picture
 * is known. */
#include <math.h>
#include <string.h>

#include "tests/property/property.h"

/* Samples travel as half floats and shared exponents. */
#define TRAVEL 2e-3
/* What is left of the noise of many samples, and of the middle of a pixel for all of it. */
#define MANY_SAMPLES        1024
#define UNOCCLUDED_MAX      0.01
#define UNOCCLUDED_STEP_DEG 4.0 /* a pixel, at most */
#define UNOCCLUDED_SPARED   0.1 /* of the pixels: few samples at the edge of the floor */

/* The case with one body and no light. */
static struct property_case emptied(const struct property_case *c)
{
    struct property_case e = *c;
    e.body_count = 1;
    e.light_count = 0;
    e.occlusion = 0;
    memset(e.environment, 0, sizeof e.environment);
    e.map = 0;
    e.orthographic = 0; /* which may look past what is built */
    memcpy(e.target, (double[]){0, 0, 0}, sizeof e.target);
    memset(e.bodies, 0, sizeof e.bodies);
    return e;
}

static struct case_body floor_of(enum body_surface surface)
{
    return (struct case_body){.shape = BODY_PANEL,
                              .surface = surface,
                              .size = {4, 0, 4},
                              .facing = 1,
                              .albedo = {0.5, 0.5, 0.5},
                              .sharpness = 0.5};
}

/* All pixels of a channel that show the floor within `most` of `value`. */
static enum property_result all_are(const struct image *image, const char *name, double value,
                                    double most, char says[PROPERTY_SAYS_BYTES])
{
    const struct plane *p = image_plane(image, name), *a = image_plane(image, "A");
    for (int32_t y = 0; y < image->height_px; y++)
        for (int32_t x = 0; x < image->width_px; x++) {
            if (a && *plane_at(a, x, y) < 1) continue;
            const double v = (double)*plane_at(p, x, y);
            if (fabs(v - value) <= most * fabs(value)) continue;
            snprintf(says, PROPERTY_SAYS_BYTES, "%s of pixel %d, %d is %.9g, not %.9g", name, x, y,
                     v, value);
            return PROPERTY_FAILS;
        }
    return PROPERTY_HOLDS;
}

/* Above a floor alone the hemisphere is open. */
enum property_result property_open(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    struct property_case e = emptied(c);
    e.bodies[0] = floor_of(SURFACE_LAMBERT);
    e.occlusion = 1;
    e.eye[1] = fmax(e.eye[1], 1);
    memcpy(e.environment, (double[]){1, 1, 1}, sizeof e.environment);
    struct image *image = property_picture(&e, &none, says);
    if (!image) return PROPERTY_DOES_NOT_APPLY;
    const enum property_result result = all_are(image, "occlusion.O", 1, 1e-6, says);
    image_destroy(&image);
    return result;
}

/* Without anything in the way filters of shadows show all of a light: what many samples of it come
 * to. */
enum property_result property_unoccluded(const struct property_case *c,
                                         char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    struct property_case e = emptied(c);
    e.bodies[0] = floor_of(SURFACE_LAMBERT);
    e.eye[1] = fmax(e.eye[1], 1);
    e.yfov_deg = fmin(e.yfov_deg, UNOCCLUDED_STEP_DEG * e.height);
    e.aperture = e.focus = 0;
    e.bounces = e.tent = 0;
    e.error = 0; /* paths alone know theirs */
    e.light_count = 1;
    e.lights[0] = (struct case_light){.kind = c->seed % 2 ? CASE_RECTANGLE : CASE_GAUSSIAN,
                                      .centre = {0.5, 2, 0.25},
                                      .half = {0.5, 0.25},
                                      .facing = 4,
                                      .level = {1, 2, 3}};
    if (e.method >= 3) return PROPERTY_DOES_NOT_APPLY; /* nothing is filtered */
    struct property_case plain = e;
    plain.method = 3;
    plain.spp = MANY_SAMPLES;
    struct image *a = property_picture(&plain, &none, says),
                 *b = a ? property_picture(&e, &none, says) : NULL;
    if (!b) {
        image_destroy(&a);
        return PROPERTY_DOES_NOT_APPLY;
    }
    const double apart = property_apart(a, b, 1, UNOCCLUDED_SPARED);
    snprintf(says, PROPERTY_SAYS_BYTES, "%.3g apart", apart);
    image_destroy(&a);
    image_destroy(&b);
    return apart <= UNOCCLUDED_MAX ? PROPERTY_HOLDS : PROPERTY_FAILS;
}

/* A wall that shines and fills the picture: every sample has one radiance, whatever the lens does.
 */
enum property_result property_glow(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    struct property_case e = emptied(c);
    enum property_result result = PROPERTY_HOLDS;
    e.bodies[0] = (struct case_body){.shape = BODY_ROOM,
                                     .surface = SURFACE_EMITTER,
                                     .size = {8, 8, 8},
                                     .albedo = {0.25, 0.5, 0.75}};
    struct image *image = property_picture(&e, &none, says);
    if (!image) return PROPERTY_DOES_NOT_APPLY;
    static const char *const names[] = {"R", "G", "B"};
    for (int k = 0; k < 3 && result == PROPERTY_HOLDS; k++)
        result = all_are(image, names[k], 1 + k, TRAVEL, says);
    image_destroy(&image);
    return result;
}

/* A closed room that emits 1 and reflects rho shows the sum of rho^k over all scatterings that are
 * followed. */
enum property_result property_furnace(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    static const char *const names[] = {"R", "G", "B"};
    const struct change none = {0};
    struct property_case e = emptied(c);
    const int bounces = c->seed % 3 == 0 ? 64 : c->seed % 3 == 1 ? 0 : c->bounces;
    e.bounces = bounces;
    e.bodies[0] = (struct case_body){.shape = BODY_ROOM,
                                     .surface = SURFACE_FURNACE,
                                     .size = {4, 4, 5},
                                     .albedo = {0.2, 0.5, 0.8}};
    struct image *image = property_picture(&e, &none, says);
    if (!image) return PROPERTY_DOES_NOT_APPLY;
    enum property_result result = PROPERTY_HOLDS;
    const double pixels = (double)image->width_px * image->height_px;
    for (int k = 0; k < 3 && result == PROPERTY_HOLDS; k++) {
        const double rho = e.bodies[0].albedo[k],
                     expected = (1 - pow(rho, bounces + 2)) / (1 - rho);
        const struct plane *p = image_plane(image, names[k]);
        double sum = 0;
        for (int32_t y = 0; y < image->height_px; y++)
            for (int32_t x = 0; x < image->width_px; x++) sum += (double)*plane_at(p, x, y);
        /* Samples of a pixel are off by as much as what is expected, at the most, where few are
         * taken; pixels share what filters give them. */
        const double value = sum / pixels,
                     allowed = expected * (TRAVEL + 6 * 0.5 / sqrt(pixels * e.spp));
        if (fabs(value - expected) <= allowed) continue;
        snprintf(says, PROPERTY_SAYS_BYTES,
                 "%s of albedo %g after %d bounces is %.6g, not %.6g +- %.2g", names[k], rho,
                 bounces, value, expected, allowed);
        result = PROPERTY_FAILS;
    }
    image_destroy(&image);
    return result;
}
