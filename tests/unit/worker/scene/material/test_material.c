/* From material records to the BSDFs of points: the formulas of glTF and its extensions, textures
 * by channel, what materials say of themselves. */
#include "tests/unit/worker/scene/material/material_bench.h"

TEST(matt_materials_are_lambert)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->specular = 0.0f;
    const struct material *m = make(&b);
    assert_true(m->lambert && !m->textured && !m->transmissive && !m->anisotropic && !m->blend);
    material_bsdf(m, NULL, false, &bsdf);
    assert_int_equal(bsdf.model, BSDF_LAMBERT);
    expect(bsdf.albedo[0], 0.5);
    expect(bsdf.albedo[1], 0.25);
    b.record->specular = 0.1f;
    assert_false(make(&b)->lambert);
    b.record->specular = 0.0f;
    b.record->metallic = 0.1f;
    assert_false(make(&b)->lambert);
    b.record->metallic = 0.0f;
    b.record->transmission = 0.1f;
    assert_false(make(&b)->lambert);
    b.record->transmission = 0.0f;
    b.record->model = MODEL_PHONG;
    assert_false(make(&b)->lambert);
    close_bench(&b);
}

TEST(factors_make_gltf_surfaces)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->metallic = 0.25f;
    b.record->roughness = 0.5f;
    b.record->transmission = 0.5f;
    b.record->specular = 0.75f;
    b.record->ior = 1.5f;
    b.record->specular_color[0] = 0.5f;
    b.record->specular_color[1] = 100.0f;
    const struct material *m = make(&b);
    material_bsdf(m, NULL, false, &bsdf);
    assert_int_equal(bsdf.model, BSDF_GLTF);
    expect(bsdf.metallic, 0.25);
    expect(bsdf.transmission, 0.5);
    expect(bsdf.specular, 0.75);
    expect(bsdf.alpha_u, 0.25);
    expect(bsdf.alpha_v, 0.25);
    expect(bsdf.albedo[0], 0.5 * 0.75 * 0.5);
    expect(bsdf.base_color[0], 0.5);
    expect(bsdf.specular_f0[0], 0.02);
    expect(bsdf.specular_f0[1], 1.0);
    expect(bsdf.specular_f0[2], 0.04);
    expect(bsdf.ior, 1.5);
    assert_true(bsdf.thin && !bsdf.inside);
    close_bench(&b);
}

TEST(solids_have_an_inside)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->transmission = 1.0f;
    b.record->ior = 1.6f;
    const struct material *m = make(&b);
    assert_true(m->transmissive && !m->volume);
    material_bsdf(m, NULL, true, &bsdf); /* a thin wall has none */
    assert_true(bsdf.thin && !bsdf.inside);
    expect(bsdf.ior, 1.6);
    b.record->thickness = 0.1f;
    m = make(&b);
    assert_true(m->transmissive && m->volume);
    material_bsdf(m, NULL, true, &bsdf);
    assert_true(!bsdf.thin && bsdf.inside);
    expect(bsdf.ior, 1 / 1.6);
    expect(bsdf.specular_f0[0], (0.6 / 2.6) * (0.6 / 2.6));
    b.record->ior = 0.0f; /* infinite */
    for (int inside = 0; inside < 2; inside++) {
        material_bsdf(make(&b), NULL, inside, &bsdf);
        assert_true(bsdf.ior == 0.0f && bsdf.specular_f0[2] == 1.0f);
    }
    b.record->transmission = 0.0f; /* thickness alone is nothing */
    m = make(&b);
    assert_true(!m->transmissive && !m->volume);
    b.record->transmission = 1.0f;
    b.record->metallic = 1.0f;
    assert_false(make(&b)->transmissive);
    b.record->metallic_roughness_texture = texel(&b, 0, 0, 0, 0, 0);
    assert_true(make(&b)->transmissive);
    close_bench(&b);
}

TEST(textures_speak_by_channel)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->metallic = 1.0f;
    b.record->transmission = 1.0f;
    b.record->metallic_roughness_texture = texel(&b, 9, 51, 102, 9, 0);
    b.record->transmission_texture = texel(&b, 153, 9, 9, 9, 0);
    b.record->specular_texture = texel(&b, 9, 9, 9, 204, 0);
    b.record->specular_color_texture = texel(&b, 255, 188, 0, 9, IMAGE_IS_SRGB);
    b.record->base_color_texture = texel(&b, 255, 0, 255, 255, 0);
    const struct material *m = make(&b);
    assert_true(m->textured);
    material_bsdf(m, &at_origin, false, &bsdf);
    expect(bsdf.metallic, 0.4);
    expect(bsdf.alpha_u, 0.04);
    expect(bsdf.transmission, 0.6);
    expect(bsdf.specular, 0.8);
    expect(bsdf.specular_f0[0], 0.04);
    expect(bsdf.specular_f0[1], 0.04 * pow((188 / 255.0 + 0.055) / 1.055, 2.4));
    assert_true(bsdf.specular_f0[2] == 0.0f);
    expect(bsdf.base_color[0], 0.5);
    assert_true(bsdf.base_color[1] == 0.0f);
    expect(bsdf.albedo[2], 0.6 * 0.4);
    close_bench(&b);
}

TEST(anisotropy_widens_along_its_direction)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    float direction[2];
    b.record->roughness = 0.5f;
    b.record->anisotropy = 0.5f;
    b.record->anisotropy_rad = 0.5f;
    const struct material *m = make(&b);
    assert_true(m->anisotropic);
    material_bsdf(m, NULL, false, &bsdf);
    expect(bsdf.alpha_u, 0.25 + 0.75 * 0.25);
    expect(bsdf.alpha_v, 0.25);
    material_tangent_angle(m, NULL, direction);
    expect(direction[0], cos(0.5));
    expect(direction[1], sin(0.5));
    b.record->anisotropy_texture = texel(&b, 128, 255, 51, 0, 0); /* along the bitangent */
    m = make(&b);
    material_bsdf(m, &at_origin, false, &bsdf);
    expect(bsdf.alpha_u, 0.25 + 0.75 * 0.01);
    material_tangent_angle(m, &at_origin, direction);
    assert_true(fabs((double)direction[0] - cos(0.5 + 1.5668746)) < 1e-4);
    assert_true(fabs((double)direction[1] - sin(0.5 + 1.5668746)) < 1e-4);
    b.record->anisotropy = 0.0f;
    m = make(&b);
    assert_false(m->anisotropic);
    material_tangent_angle(m, &at_origin, direction);
    assert_true(direction[0] == 1.0f && direction[1] == 0.0f);
    close_bench(&b);
}

TEST(dispersion_spreads_the_index)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->dispersion = 2;
    b.record->transmission = 1;
    material_bsdf(make(&b), NULL, false, &bsdf);
    assert_false(bsdf.dispersed); /* a thin wall bends nothing */
    b.record->thickness = 1;
    const struct material *m = make(&b);
    material_bsdf(m, NULL, false, &bsdf);
    assert_true(bsdf.dispersed && bsdf.color == BSDF_ALL_COLORS);
    expect(bsdf.iors[0], 1.475);
    expect(bsdf.iors[1], 1.5);
    expect(bsdf.iors[2], 1.525);
    material_bsdf(m, NULL, true, &bsdf);
    expect(bsdf.iors[2], 1 / 1.525);
    b.record->dispersion = 1000;
    material_bsdf(make(&b), NULL, false, &bsdf);
    expect(bsdf.iors[0], 1);
    close_bench(&b);
}

TEST(other_models_pass_through)
{
    static const struct {
        uint32_t record;
        enum bsdf_model model;
    } rows[] = {
#define MODEL(number, NAME, name) {MODEL_##NAME, BSDF_##NAME},
#include "proto/scene/model.def"
    };
    struct bench b = open_bench();
    for (size_t i = MODEL_GLTF + 1; i < sizeof rows / sizeof *rows; i++) {
        struct bsdf bsdf;
        b.record->model = rows[i].record;
        b.record->model_specular[1] = 0.5f;
        b.record->exponent_u = 10.0f;
        b.record->exponent_v = 20.0f;
        b.record->alpha_u = 0.3f;
        b.record->alpha_v = 0.3f;
        b.record->eta[2] = 1.5f;
        b.record->k[0] = 3.0f;
        b.record->second_specular[0] = 0.25f;
        b.record->second_alpha = 0.6f;
        b.record->grazing[1] = 0.7f;
        b.record->transmission = 1.0f; /* glTF's alone */
        const struct material *m = make(&b);
        assert_true(!m->lambert && !m->transmissive);
        assert_int_equal(m->anisotropic, rows[i].record == MODEL_ASHIKHMIN_SHIRLEY);
        material_bsdf(m, NULL, true, &bsdf);
        assert_int_equal(bsdf.model, rows[i].model);
        assert_true(bsdf.albedo[0] == 0.5f && bsdf.model_specular[1] == 0.5f);
        assert_true(bsdf.exponent_u == 10.0f && bsdf.exponent_v == 20.0f);
        assert_true(bsdf.alpha_u == 0.3f && bsdf.alpha_v == 0.3f);
        assert_true(bsdf.eta[2] == 1.5f && bsdf.k[0] == 3.0f);
        assert_true(bsdf.second_specular[0] == 0.25f && bsdf.second_alpha == 0.6f);
        assert_true(bsdf.grazing[1] == 0.7f);
        assert_true(!bsdf.inside && !bsdf.thin);
    }
    close_bench(&b);
}

TEST(unlit_ones_only_shine)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    float radiance[3];
    b.record->flags = MATERIAL_UNLIT;
    b.record->transmission = 1.0f;
    b.record->anisotropy = 1.0f;
    const struct material *m = make(&b);
    assert_true(m->unlit && m->emissive && !m->lambert && !m->transmissive && !m->anisotropic);
    material_bsdf(m, NULL, false, &bsdf);
    assert_int_equal(bsdf.model, BSDF_BLACK);
    assert_true(bsdf.albedo[2] == 0.0f);
    material_emission(m, NULL, radiance);
    expect(radiance[1], 0.25);
    material_mean_emission(m, radiance);
    expect(radiance[1], 0.25);
    close_bench(&b);
}

TEST(light_fades_inside)
{
    struct bench b = open_bench();
    float left[3];
    b.record->transmission = b.record->thickness = 1.0f;
    b.record->attenuation[0] = 0.5f;
    b.record->attenuation[1] = FLT_MIN;
    b.record->attenuation_distance = 2.0f;
    const struct material *m = make(&b);
    material_attenuation(m, 2.0f, left);
    expect(left[0], 0.5);
    assert_true(left[1] < 1e-30f && left[2] == 1.0f);
    material_attenuation(m, 5.0f, left);
    expect(left[0], pow(0.5, 2.5));
    material_attenuation(m, 0.0f, left);
    assert_true(left[0] == 1.0f && left[1] == 1.0f);
    material_attenuation(m, 1e30f, left);
    assert_true(left[0] == 0.0f && left[1] == 0.0f && left[2] == 1.0f);
    material_attenuation(m, INFINITY, left);
    assert_true(left[0] == 0.0f && left[2] == 1.0f);
    b.record->attenuation_distance = 0.0f;
    material_attenuation(make(&b), 5.0f, left);
    assert_true(left[0] == 1.0f && left[1] == 1.0f);
    b.record->attenuation_distance = 2.0f;
    b.record->thickness = 0.0f; /* thin walls have no inside to fade in */
    material_attenuation(make(&b), 5.0f, left);
    assert_true(left[0] == 1.0f && left[1] == 1.0f);
    close_bench(&b);
}

TEST(opacity_follows_the_mode)
{
    struct bench b = open_bench();
    b.record->base_color[3] = 0.25f;
    b.record->alpha_cutoff = 0.2f;
    assert_true(material_opacity(make(&b), NULL) == 1.0f);
    b.record->alpha_mode = ALPHA_BLEND;
    const struct material *m = make(&b);
    assert_true(m->blend && material_opacity(m, NULL) == 0.25f);
    b.record->alpha_mode = ALPHA_MASK;
    m = make(&b);
    assert_true(!m->blend && material_opacity(m, NULL) == 1.0f);
    b.record->alpha_cutoff = 0.3f;
    assert_true(material_opacity(make(&b), NULL) == 0.0f);
    b.record->alpha_mode = ALPHA_BLEND;
    b.record->base_color[3] = 1.0f;
    assert_false(make(&b)->blend);
    b.record->base_color_texture = texel(&b, 255, 255, 255, 254, 0);
    m = make(&b);
    assert_true(m->blend);
    expect(material_opacity(m, &at_origin), 254 / 255.0);
    close_bench(&b);
}

TEST(normals_without_maps_stand_up)
{
    struct bench b = open_bench();
    float n[3];
    material_tangent_normal(make(&b), NULL, n);
    assert_true(n[0] == 0.0f && n[1] == 0.0f && n[2] == 1.0f);
    close_bench(&b);
}
