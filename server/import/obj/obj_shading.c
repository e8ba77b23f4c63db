#include "server/import/obj/obj_shading.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "server/import/scene/surface.h"

/* Highlights of greater exponents, less than 8 degrees wide, are taken for a sharp mirror's. */
#define MIRROR_EXPONENT 200.0f
#define EXPONENT_MAX    1e5f
#define TRACE           0.05f /* of a diffuse colour: beside a mirror it is left out */
#define IOR_MAX         1e3f
#define IOR_GLASS       1.5f
#define SOLID           1.0f /* any thickness says that there is an inside */

struct shading {
    const struct mtl_material *from;
    const char *place;
    struct scene_material *m;
    struct warnings *warnings;
    float ks[3], tf[3];
    float ns, ni, d;
    int illum;
};

static float clamp(float v, float lowest, float highest)
{
    return v >= lowest ? v <= highest ? v : highest : lowest; /* NaN is the lowest */
}

/* Returns a number brought into range; `absent` where the material does not give it. */
static float get_number(const struct shading *s, uint32_t given, float value, float lowest,
                        float highest, const char *name, float absent)
{
    if (!(s->from->given & given)) return absent;
    const float inside = clamp(value, lowest, highest);
    if (!(value >= lowest && value <= highest))
        warnings_add(s->warnings, s->place, "%s is out of range and taken as %g", name,
                     (double)inside);
    return inside;
}

static void get_color(const struct shading *s, uint32_t given, const float rgb[3], const char *name,
                      float inout[3])
{
    bool inside = true;
    if (!(s->from->given & given)) return;
    for (int i = 0; i < 3; i++) {
        inout[i] = clamp(rgb[i], 0, 1);
        inside &= rgb[i] == inout[i];
    }
    if (!inside) warnings_add(s->warnings, s->place, "%s is brought into [0, 1]", name);
}

static void get_all(struct shading *s)
{
    const struct mtl_material *m = s->from;
    s->illum = m->given & MTL_ILLUM ? (int)clamp(m->illum, 0, 100) : 1;
    for (int i = 0; i < 3; i++) s->tf[i] = 1;
    get_color(s, MTL_KS, m->ks, "Ks", s->ks);
    get_color(s, MTL_TF, m->tf, "Tf", s->tf);
    s->ns = get_number(s, MTL_NS, m->ns, 0, EXPONENT_MAX, "Ns", 0);
    s->ni = get_number(s, MTL_NI, m->ni, 0, IOR_MAX, "Ni", 1);
    s->d = get_number(s, MTL_D, m->d, 0, 1, "d", 1);
}

static bool is_black(const float rgb[3])
{
    return !(rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0);
}

/* Light passes the surface of a solid twice, so that each time lets the root of Tf through. */
static void make_glass(const struct shading *s)
{
    struct scene_material *m = s->m;
    m->transmission = 1;
    m->specular = 1;
    m->roughness = 0;
    m->thickness = SOLID;
    m->ior = s->ni > 1 ? s->ni : IOR_GLASS;
    m->base_color_texture.texture = SCENE_NONE;
    for (int i = 0; i < 3; i++) m->base_color[i] = sqrtf(s->tf[i]);
    if (!(s->ni > 1))
        warnings_add(s->warnings, s->place, "glass with Ni of 1 or less is taken as of 1.5");
}

static void make_glossy(const struct shading *s, enum material_model model)
{
    s->m->model = model;
    memcpy(s->m->model_specular, s->ks, sizeof s->ks);
    s->m->exponent_u = s->m->exponent_v = s->ns;
    surface_conserve(s->m, s->place, s->warnings);
}

/* Sharp reflections: a mirror, or a smooth coat where there is more than a trace of colour. */
static void make_sharp(const struct shading *s)
{
    const float *kd = s->m->base_color;
    if (kd[0] > TRACE || kd[1] > TRACE || kd[2] > TRACE) {
        make_glossy(s, MODEL_BECKMANN);
        return;
    }
    for (int i = 0; i < 3; i++) s->m->base_color[i] = 0;
    make_glossy(s, MODEL_MIRROR);
}

/* Sets the shading by the illumination model. Returns false for glass. */
static bool shade(const struct shading *s)
{
    switch (s->illum) {
    case 4:
    case 6:
    case 7:
    case 9:
        make_glass(s);
        return false;
    case 3:
    case 5:
    case 8:
        if (is_black(s->ks)) return true;
        if (s->ns > 0 && s->ns < MIRROR_EXPONENT)
            make_glossy(s, MODEL_BLINN_PHONG);
        else
            make_sharp(s);
        return true;
    case 2:
        if (!is_black(s->ks)) make_glossy(s, MODEL_BLINN_PHONG);
        return true;
    default:
        if (!is_black(s->ks))
            warnings_add(s->warnings, s->place,
                         "Ks and Ns are ignored, as illum is 0, 1 or absent");
        return true;
    }
}

/* Metallic-roughness in place of illum; false when neither factor is there. */
static bool make_metallic(const struct shading *s)
{
    struct scene_material *m = s->m;
    if (!(s->from->given & (MTL_PM | MTL_PR))) return false;
    m->metallic = get_number(s, MTL_PM, s->from->pm, 0, 1, "Pm", m->metallic);
    m->roughness = get_number(s, MTL_PR, s->from->pr, 0, 1, "Pr", m->roughness);
    m->specular = 1;
    if (s->ni > 1) m->ior = s->ni;
    return true;
}

/* The opacity map, which is the colour texture's alpha where both name one file. */
static bool has_alpha_map(const struct shading *s)
{
    const char *color = s->from->map_kd.name, *opacity = s->from->map_d.name;
    if (opacity == NULL) return false;
    if (color != NULL && strcmp(color, opacity) == 0) return true;
    warnings_add(s->warnings, s->place, "map_d is ignored, as it is not the image of map_Kd");
    return false;
}

static void blend(const struct shading *s)
{
    bool mapped = has_alpha_map(s);
    s->m->base_color[3] = s->d;
    if (s->d < 1 || mapped) s->m->alpha_mode = ALPHA_BLEND;
}

static void warn_of_maps(const struct shading *s)
{
    const uint32_t given = s->from->given;
    if (given & MTL_MAP_KS) warnings_add(s->warnings, s->place, "map_Ks and map_Ns are ignored");
    if (given & MTL_MAP_METAL) warnings_add(s->warnings, s->place, "map_Pm and map_Pr are ignored");
    if (given & MTL_MAP_BUMP)
        warnings_add(s->warnings, s->place, "bump, normal and displacement maps are ignored");
}

void obj_shading_read(const struct mtl_material *from, const char *place, struct scene_material *m,
                      struct warnings *warnings)
{
    struct shading s = {.from = from, .place = place, .m = m, .warnings = warnings};
    get_all(&s);
    if (make_metallic(&s) || shade(&s)) blend(&s);
    warn_of_maps(&s);
}
