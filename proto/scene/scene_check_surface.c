#include <float.h>

#include "proto/scene/scene_internal.h"

#define VALUE_MAX      1e6f /* scales, texture coordinates' factors */
#define IOR_MAX        1e3f /* of real materials below 5 */
#define EXPONENT_MAX   1e5f /* as struct bsdf takes them */
#define TURN_MAX       6.2832f
#define DISPERSION_MAX 1e3f
#define FILM_MAX_NM    1e6f
#define MATERIAL_FLAGS (MATERIAL_DOUBLE_SIDED | MATERIAL_UNLIT | MATERIAL_COLORED | MATERIAL_CULLED)

static int check_texture_ref(const struct scene_record *at, const char *field,
                             const struct scene_texture_ref *ref)
{
    int error = record_optional(at, field, ref->texture, SCENE_TEXTURES);
    if (!error) error = record_value(at, field, ref->uv_set, 1);
    if (!error) error = record_numbers(at, field, ref->transform, 6, -VALUE_MAX, VALUE_MAX);
    return error;
}

/* Checks an index of refraction from outside; 0 stands for infinity. */
static int check_ior(const struct scene_record *at, float ior)
{
    const int error = record_number(at, "ior", ior, 0.0f, IOR_MAX);
    if (error || ior == 0.0f || ior >= 1.0f) return error;
    return record_refuse(at, "ior", ERR_RANGE, (double)ior, "is neither 0 nor at least 1");
}

static int check_surface(const struct scene_record *at, const struct scene_material *m)
{
    int error = record_numbers(at, "base_color", m->base_color, 4, 0.0f, 1.0f);
    if (!error) error = record_numbers(at, "emission", m->emission, 3, 0.0f, LIMIT_RADIANCE);
    if (!error) error = record_number(at, "metallic", m->metallic, 0.0f, 1.0f);
    if (!error) error = record_number(at, "roughness", m->roughness, 0.0f, 1.0f);
    if (!error) error = record_number(at, "normal_scale", m->normal_scale, -VALUE_MAX, VALUE_MAX);
    if (!error) error = record_number(at, "alpha_cutoff", m->alpha_cutoff, 0.0f, VALUE_MAX);
    if (!error) error = record_number(at, "specular", m->specular, 0.0f, 1.0f);
    if (!error) error = check_ior(at, m->ior);
    if (!error) error = record_number(at, "transmission", m->transmission, 0.0f, 1.0f);
    if (!error) error = record_numbers(at, "specular_color", m->specular_color, 3, 0.0f, VALUE_MAX);
    if (!error) error = record_number(at, "anisotropy", m->anisotropy, 0.0f, 1.0f);
    if (!error) error = record_number(at, "clearcoat", m->clearcoat, 0.0f, 1.0f);
    if (!error)
        error = record_number(at, "clearcoat_roughness", m->clearcoat_roughness, 0.0f, 1.0f);
    if (!error) error = record_number(at, "anisotropy_rad", m->anisotropy_rad, -TURN_MAX, TURN_MAX);
    return error;
}

/* Checks what lies on and in the surface beside its coat. */
static int check_layers(const struct scene_record *at, const struct scene_material *m)
{
    int error = record_number(at, "clearcoat_normal_scale", m->clearcoat_normal_scale, -VALUE_MAX,
                              VALUE_MAX);
    if (!error) error = record_number(at, "dispersion", m->dispersion, 0.0f, DISPERSION_MAX);
    if (!error) error = record_numbers(at, "sheen_color", m->sheen_color, 3, 0.0f, 1.0f);
    if (!error) error = record_number(at, "sheen_roughness", m->sheen_roughness, 0.0f, 1.0f);
    if (!error) error = record_number(at, "iridescence", m->iridescence, 0.0f, 1.0f);
    if (!error) error = record_number(at, "iridescence_ior", m->iridescence_ior, 1.0f, IOR_MAX);
    if (!error)
        error = record_numbers(at, "iridescence_nm", m->iridescence_nm, 2, 0.0f, FILM_MAX_NM);
    if (!error)
        error = record_number(at, "diffuse_transmission", m->diffuse_transmission, 0.0f, 1.0f);
    if (!error)
        error = record_numbers(at, "diffuse_transmission_color", m->diffuse_transmission_color, 3,
                               0.0f, 1.0f);
    return error;
}

static int check_volume(const struct scene_record *at, const struct scene_material *m)
{
    int error = record_number(at, "thickness", m->thickness, 0.0f, LIMIT_COORDINATE);
    if (!error) error = record_numbers(at, "attenuation", m->attenuation, 3, FLT_MIN, 1.0f);
    if (!error)
        error = record_number(at, "attenuation_distance", m->attenuation_distance, 0.0f,
                              LIMIT_COORDINATE);
    return error;
}

static int check_model(const struct scene_record *at, const struct scene_material *m)
{
    int error = record_value(at, "model", m->model, MODEL_COUNT - 1);
    if (!error) error = record_numbers(at, "model_specular", m->model_specular, 3, 0.0f, 1.0f);
    if (!error) error = record_number(at, "exponent_u", m->exponent_u, 0.0f, EXPONENT_MAX);
    if (!error) error = record_number(at, "exponent_v", m->exponent_v, 0.0f, EXPONENT_MAX);
    if (!error) error = record_number(at, "alpha_u", m->alpha_u, 0.0f, 1.0f);
    if (!error) error = record_number(at, "alpha_v", m->alpha_v, 0.0f, 1.0f);
    if (!error) error = record_numbers(at, "second_specular", m->second_specular, 3, 0.0f, 1.0f);
    if (!error) error = record_number(at, "second_alpha", m->second_alpha, 0.0f, 1.0f);
    if (!error) error = record_numbers(at, "grazing", m->grazing, 2, 0.0f, 1.0f);
    if (!error) error = record_numbers(at, "eta", m->eta, 3, 0.0f, IOR_MAX);
    if (!error) error = record_numbers(at, "k", m->k, 3, 0.0f, IOR_MAX);
    return error;
}

static int check_material_textures(const struct scene_record *at, const struct scene_material *m)
{
    const struct {
        const char *field;
        const struct scene_texture_ref *ref;
    } all[] = {{"base_color_texture", &m->base_color_texture},
               {"metallic_roughness_texture", &m->metallic_roughness_texture},
               {"normal_texture", &m->normal_texture},
               {"emission_texture", &m->emission_texture},
               {"transmission_texture", &m->transmission_texture},
               {"specular_texture", &m->specular_texture},
               {"specular_color_texture", &m->specular_color_texture},
               {"anisotropy_texture", &m->anisotropy_texture},
               {"clearcoat_texture", &m->clearcoat_texture},
               {"clearcoat_roughness_texture", &m->clearcoat_roughness_texture},
               {"clearcoat_normal_texture", &m->clearcoat_normal_texture},
               {"sheen_color_texture", &m->sheen_color_texture},
               {"sheen_roughness_texture", &m->sheen_roughness_texture},
               {"iridescence_texture", &m->iridescence_texture},
               {"iridescence_thickness_texture", &m->iridescence_thickness_texture},
               {"diffuse_transmission_texture", &m->diffuse_transmission_texture},
               {"diffuse_transmission_color_texture", &m->diffuse_transmission_color_texture}};
    int error = 0;
    for (size_t i = 0; i < sizeof all / sizeof all[0] && !error; i++)
        error = check_texture_ref(at, all[i].field, all[i].ref);
    return error;
}

int scene_check_material(const struct scene_record *at, const struct scene_material *m)
{
    int error = check_surface(at, m);
    if (!error) error = check_layers(at, m);
    if (!error) error = check_volume(at, m);
    if (!error) error = check_model(at, m);
    if (!error) error = record_value(at, "alpha_mode", m->alpha_mode, ALPHA_BLEND);
    if (!error) error = record_flags(at, m->flags, MATERIAL_FLAGS);
    if (!error) error = record_name(at, m->name);
    return error ? error : check_material_textures(at, m);
}

int scene_check_texture(const struct scene_record *at, const struct scene_texture *t)
{
    int error = record_index(at, "image", t->image, SCENE_IMAGES);
    if (!error) error = record_value(at, "wrap_u", t->wrap_u, WRAP_MIRROR);
    if (!error) error = record_value(at, "wrap_v", t->wrap_v, WRAP_MIRROR);
    if (!error) error = record_value(at, "filter", t->filter, FILTER_NEAREST);
    return error;
}

int scene_check_image(const struct scene_record *at, const struct scene_image *image)
{
    const uint32_t width = image->width_px, height = image->height_px;
    if (width < 1 || width > LIMIT_TEXTURE_SIDE_PX)
        return record_refuse(at, "width_px", ERR_LIMIT, width, "is no width of an image");
    if (height < 1 || height > LIMIT_TEXTURE_SIDE_PX)
        return record_refuse(at, "height_px", ERR_LIMIT, height, "is no height of an image");
    int error = record_value(at, "format", image->format, IMAGE_RGBA8);
    if (!error) error = record_flags(at, image->flags, IMAGE_IS_SRGB | IMAGE_IN_BASE);
    if (!error) error = record_name(at, image->name);
    if (!error) error = record_reserved(at, image->reserved);
    if (!error && image->flags & IMAGE_IN_BASE && !at->scene->base)
        return record_refuse(at, "flags", ERR_MISMATCH, image->flags, "though there is no base");
    if (error) return error;
    const uint64_t need_bytes = 4ull * width * height;
    const uint64_t have_bytes = scene_image_home(at->scene, image)->count[SCENE_PIXELS];
    if (need_bytes > have_bytes || image->first_byte > have_bytes - need_bytes)
        return record_refuse(at, "first_byte", ERR_RANGE, (double)image->first_byte,
                             "puts the image past the pixels' end");
    return 0;
}
