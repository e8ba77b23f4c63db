#include "server/import/scene/surface.h"

#include <string.h>

void surface_init(struct scene_material *m)
{
    const struct scene_texture_ref none = {.texture = SCENE_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    *m = (struct scene_material){.base_color = {1, 1, 1, 1},
                                 .metallic = 1,
                                 .roughness = 1,
                                 .normal_scale = 1,
                                 .alpha_cutoff = 0.5f,
                                 .specular = 1,
                                 .ior = 1.5f,
                                 .specular_color = {1, 1, 1},
                                 .attenuation = {1, 1, 1},
                                 .clearcoat_normal_scale = 1,
                                 .iridescence_ior = 1.3f,
                                 .iridescence_nm = {100, 400},
                                 .diffuse_transmission_color = {1, 1, 1},
                                 .base_color_texture = none,
                                 .metallic_roughness_texture = none,
                                 .normal_texture = none,
                                 .emission_texture = none,
                                 .transmission_texture = none,
                                 .specular_texture = none,
                                 .specular_color_texture = none,
                                 .anisotropy_texture = none,
                                 .clearcoat_texture = none,
                                 .clearcoat_roughness_texture = none,
                                 .clearcoat_normal_texture = none,
                                 .sheen_color_texture = none,
                                 .sheen_roughness_texture = none,
                                 .iridescence_texture = none,
                                 .iridescence_thickness_texture = none,
                                 .diffuse_transmission_texture = none,
                                 .diffuse_transmission_color_texture = none};
}

bool surface_is_anisotropic(const struct scene_material *m)
{
    return m->anisotropy > 0 || m->alpha_u != m->alpha_v || m->exponent_u != m->exponent_v;
}

void surface_textures(struct scene_material *m, struct scene_texture_ref *out[SURFACE_TEXTURES])
{
    struct scene_texture_ref *const all[SURFACE_TEXTURES] = {
        &m->base_color_texture,
        &m->normal_texture,
        &m->metallic_roughness_texture,
        &m->emission_texture,
        &m->transmission_texture,
        &m->specular_texture,
        &m->specular_color_texture,
        &m->anisotropy_texture,
        &m->clearcoat_texture,
        &m->clearcoat_roughness_texture,
        &m->clearcoat_normal_texture,
        &m->sheen_color_texture,
        &m->sheen_roughness_texture,
        &m->iridescence_texture,
        &m->iridescence_thickness_texture,
        &m->diffuse_transmission_texture,
        &m->diffuse_transmission_color_texture};
    memcpy(out, all, sizeof all);
}

void surface_conserve(struct scene_material *m, const char *place, struct warnings *warnings)
{
    float most = 0;
    for (int i = 0; i < 3; i++) {
        float sum = m->base_color[i] + m->model_specular[i];
        most = sum > most ? sum : most;
    }
    if (most <= 1) return;
    for (int i = 0; i < 3; i++) {
        m->base_color[i] /= most;
        m->model_specular[i] /= most;
    }
    warnings_add(warnings, place,
                 "its diffuse and specular colours sum up to more than 1 and are scaled down");
}
