/* Layers of materials: coats, sheens, thin films, and light that is let through. */
#include "tests/unit/worker/scene/material/material_bench.h"

TEST(coats_are_their_factors_times_their_textures)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->clearcoat = 0.5f;
    b.record->clearcoat_roughness = 0.5f;
    const struct material *m = make(&b);
    assert_false(m->lambert); /* whatever is beneath */
    material_bsdf(m, NULL, false, &bsdf);
    assert_true(bsdf.coat == 0.5f && bsdf.coat_alpha == 0.25f);
    b.record->clearcoat_texture = texel(&b, 51, 0, 0, 0, 0);
    b.record->clearcoat_roughness_texture = texel(&b, 0, 102, 0, 0, 0);
    m = make(&b);
    material_bsdf(m, &at_origin, false, &bsdf);
    expect(bsdf.coat, 0.5 * 0.2);
    expect(bsdf.coat_alpha, 0.2 * 0.2);
    close_bench(&b);
}

TEST(sheens_are_their_factors_times_their_textures)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    const float color[3] = {0.5f, 0, 1};
    b.record->specular = 0;
    memcpy(b.record->sheen_color, color, sizeof color);
    b.record->sheen_roughness = 0.5f;
    const struct material *m = make(&b);
    assert_false(m->lambert);
    material_bsdf(m, NULL, false, &bsdf);
    assert_true(bsdf.sheen[0] == 0.5f && bsdf.sheen[2] == 1 && bsdf.sheen_alpha == 0.25f);
    b.record->sheen_color_texture = texel(&b, 255, 255, 128, 0, IMAGE_IS_SRGB);
    b.record->sheen_roughness_texture = texel(&b, 0, 0, 0, 102, 0);
    m = make(&b);
    material_bsdf(m, &at_origin, false, &bsdf);
    expect(bsdf.sheen[0], 0.5);
    expect(bsdf.sheen[2], 0.215861);
    expect(bsdf.sheen_alpha, 0.2 * 0.2);
    close_bench(&b);
}

TEST(light_that_is_let_through_is_taken_from_what_is_reflected)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    const float color[3] = {0.5f, 1, 0};
    b.record->specular = 0;
    b.record->diffuse_transmission = 0.5f;
    memcpy(b.record->diffuse_transmission_color, color, sizeof color);
    const struct material *m = make(&b);
    assert_true(m->translucent && !m->lambert && !m->volume && !material_is_metallic_only(m));
    material_bsdf(m, NULL, false, &bsdf);
    assert_true(bsdf.albedo[0] == 0.25f && bsdf.through[0] == 0.25f && bsdf.through[2] == 0);
    assert_true(bsdf.thin);
    b.record->diffuse_transmission_texture = texel(&b, 0, 0, 0, 102, 0);
    b.record->diffuse_transmission_color_texture = texel(&b, 255, 128, 0, 0, IMAGE_IS_SRGB);
    b.record->metallic = 0.5f;
    b.record->thickness = 1;
    m = make(&b);
    assert_true(m->volume);
    material_bsdf(m, &at_origin, true, &bsdf);
    expect(bsdf.albedo[0], 0.5 * 0.8 * 0.5);
    expect(bsdf.through[0], 0.2 * 0.5 * 0.5);
    expect(bsdf.through[1], 0.2 * 0.215861 * 0.5);
    assert_true(bsdf.inside && !bsdf.thin);
    close_bench(&b);
}

TEST(films_are_as_thick_as_their_textures_say)
{
    struct bench b = open_bench();
    struct bsdf bsdf;
    b.record->iridescence = 0.5f;
    b.record->iridescence_ior = 1.5f;
    b.record->iridescence_nm[0] = 100, b.record->iridescence_nm[1] = 600;
    material_bsdf(make(&b), NULL, false, &bsdf);
    assert_true(bsdf.film == 0.5f && bsdf.film_ior == 1.5f && bsdf.film_nm == 600);
    assert_true(bsdf.film_mean > 0 && bsdf_has_layers(&bsdf));
    b.record->iridescence_texture = texel(&b, 102, 0, 0, 0, 0);
    b.record->iridescence_thickness_texture = texel(&b, 0, 51, 0, 0, 0);
    material_bsdf(make(&b), &at_origin, false, &bsdf);
    expect(bsdf.film, 0.2);
    expect(bsdf.film_nm, 200);
    close_bench(&b);
}
