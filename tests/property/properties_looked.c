/* Looking changes nothing: whatever layers a job asks for besides, beauty is the same to the last
 * bit. */
#include <string.h>

#include "server/job/plan/plan.h"
#include "tests/property/property.h"

/* The distance of occlusion, where a case has none. */
#define NEAR 0.5

static const struct {
    const char *name;
    bool by_lens; /* lens samples give it, or pixel centres beside them (plan_lens.c) */
} looks[] = {
    {"direct", false},
    {"indirect", false},
    {"albedo", false},
    {"normal", true},
    {"depth", true},
    {"samples", true},
    {"visibility", true},
    {"slope_min", true},
    {"slope_max", true},
    {"emission", false},
    {"id", true},
    {"filter_width", true},
    {"error", false},
    {"occlusion", false},
    {"diffuse_direct", false},
    {"diffuse_indirect", false},
    {"motion.backward", true},
    {"motion.forward", true},
};

static bool is_same(const struct image *a, const struct image *b, const char *layer,
                    char says[PROPERTY_SAYS_BYTES])
{
    static const char *const names[] = {"R", "G", "B", "A"};
    for (int k = 0; k < 4; k++) {
        const struct plane *p = image_plane(a, names[k]), *q = image_plane(b, names[k]);
        for (int32_t y = 0; y < a->height_px; y++)
            for (int32_t x = 0; x < a->width_px; x++) {
                const float v = *plane_at(p, x, y), w = *plane_at(q, x, y);
                if (!memcmp(&v, &w, sizeof v)) continue;
                snprintf(says, PROPERTY_SAYS_BYTES, "with %s %s of pixel %d, %d is %.9g, not %.9g",
                         layer, names[k], x, y, (double)w, (double)v);
                return false;
            }
    }
    return true;
}

static enum property_result look(const struct property_case *c, const char *layer,
                                 const struct image *alone, char says[PROPERTY_SAYS_BYTES])
{
    const struct change change = {.layer = layer};
    struct property_case seen = *c;
    if (!strcmp(layer, "occlusion")) seen.occlusion = NEAR;
    struct image *image = property_picture(&seen, &change, says);
    if (!image) return PROPERTY_HOLDS; /* jobs may be refused a layer */
    const bool same = is_same(alone, image, layer, says);
    image_destroy(&image);
    return same ? PROPERTY_HOLDS : PROPERTY_FAILS;
}

static bool has_mirror(const struct property_case *c)
{
    bool any = false;
    for (int i = 0; i < c->body_count; i++)
        any |= c->bodies[i].surface == SURFACE_MIRROR ||
               (c->bodies[i].surface == SURFACE_METAL && c->bodies[i].sharpness >= 1);
    return any;
}

/* The sheared filter of indirect light and averages of area lights know no errors; plans say what
 * they take in their place. Through a lens images in mirrors are not filtered where a layer shows
 * the mirrors' own surfaces. */
static bool is_exempt(const struct property_case *c, const char *layer)
{
    const bool own = !strcmp(layer, "depth") || !strcmp(layer, "normal") || !strcmp(layer, "id");
    const bool unknown = c->indirect == CASE_INDIRECT_SHEARED || c->method == CASE_AVERAGE;
    return (!strcmp(layer, "error") && unknown) || (own && c->focus > 0 && has_mirror(c));
}

/* Through a lens paths alone give some layers, and then make the picture, too. */
enum property_result property_looked(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    struct property_case bare = *c;
    bare.layers = 0;
    bare.occlusion = 0;
    struct image *alone = property_picture(&bare, &none, says);
    if (!alone) return PROPERTY_DOES_NOT_APPLY;
    const bool lens = picture_facts()->integrator == INTEGRATOR_LENS_FIELD;
    enum property_result result = PROPERTY_HOLDS;
    for (size_t i = 0; i < sizeof looks / sizeof looks[0] && result == PROPERTY_HOLDS; i++)
        if (!is_exempt(c, looks[i].name) && (looks[i].by_lens || !lens))
            result = look(&bare, looks[i].name, alone, says);
    image_destroy(&alone);
    return result;
}
