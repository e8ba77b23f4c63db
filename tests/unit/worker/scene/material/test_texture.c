/* Texture look-ups: wrap modes, filters, decoding, transforms; materials that use them. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include "worker/scene/material/material.h"

/* Four grey texels in a row, 0, 85, 170, 255; alpha falls from 255. */
static const uint8_t ramp[16] = {0,   0,   0,   255, 85,  85,  85,  170,
                                 170, 170, 170, 85,  255, 255, 255, 0};

static struct texture ramp_texture(struct scene_fixture *f, struct texture_decoding *d,
                                   uint32_t wrap, uint32_t filter, uint32_t flags)
{
    struct texture t;
    uint32_t index = fixture_texture(f, 4, 1, ramp, flags);
    struct scene_texture_ref ref = {.texture = index, .transform = {1, 0, 0, 0, 1, 0}};
    f->textures[index].wrap_u = f->textures[index].wrap_v = wrap;
    f->textures[index].filter = filter;
    texture_decoding_init(d);
    texture_init(&t, fixture_scene(f), &ref, d);
    return t;
}

static float grey(const struct texture *t, float u, float v)
{
    float out[4];
    texture_sample(t, u, v, out);
    assert_true(out[0] == out[1] && out[1] == out[2]);
    return out[0];
}

static void expect(float got, double expected)
{
    assert_true(fabs((double)got - expected) < 1e-5);
}

TEST(test_nearest)
{
    struct scene_fixture *f = fixture_new();
    struct texture_decoding d;
    struct texture t = ramp_texture(f, &d, WRAP_REPEAT, FILTER_NEAREST, 0);
    expect(grey(&t, 0.1f, 0.5f), 0);
    expect(grey(&t, 0.49f, 0.5f), 1.0 / 3);
    expect(grey(&t, 0.51f, -7.5f), 2.0 / 3);
    expect(grey(&t, 1.1f, 0.5f), 0);
    expect(grey(&t, -0.1f, 0.5f), 1);
    t = ramp_texture(f, &d, WRAP_CLAMP, FILTER_NEAREST, 0);
    expect(grey(&t, -3.0f, 0.5f), 0);
    expect(grey(&t, 1.0f, 1.0f), 1);
    expect(grey(&t, 9.0f, 9.0f), 1);
    t = ramp_texture(f, &d, WRAP_MIRROR, FILTER_NEAREST, 0);
    expect(grey(&t, 1.1f, 0.5f), 1);
    expect(grey(&t, 1.9f, 0.5f), 0);
    expect(grey(&t, -0.3f, 0.5f), 1.0 / 3);
    expect(grey(&t, 2.3f, 0.5f), 1.0 / 3);
    free(f);
}

TEST(test_bilinear)
{
    struct scene_fixture *f = fixture_new();
    struct texture_decoding d;
    struct texture t = ramp_texture(f, &d, WRAP_REPEAT, FILTER_LINEAR, 0);
    expect(grey(&t, 0.375f, 0.5f), 1.0 / 3);
    expect(grey(&t, 0.5f, 0.2f), 0.5);
    expect(grey(&t, 0.0f, 0.5f), 0.5); /* between the last and the first */
    expect(grey(&t, 1.0f, 0.5f), 0.5);
    expect(grey(&t, 0.99999999f, 0.5f), 0.5);
    t = ramp_texture(f, &d, WRAP_CLAMP, FILTER_LINEAR, 0);
    expect(grey(&t, 0.0f, 0.5f), 0);
    expect(grey(&t, 1.0f, 0.5f), 1);
    t = ramp_texture(f, &d, WRAP_MIRROR, FILTER_LINEAR, 0);
    expect(grey(&t, 1.0f, 0.5f), 1);
    expect(grey(&t, 0.0f, 0.5f), 0);
    free(f);
}

TEST(test_decoding)
{
    struct scene_fixture *f = fixture_new();
    struct texture_decoding d;
    struct texture t = ramp_texture(f, &d, WRAP_CLAMP, FILTER_NEAREST, IMAGE_IS_SRGB);
    float out[4];
    texture_sample(&t, 0.6f, 0.5f, out);
    expect(out[0], pow((170.0 / 255 + 0.055) / 1.055, 2.4));
    expect(out[3], 85.0 / 255); /* alpha is never encoded */
    expect(d.srgb[5], 5.0 / 255 / 12.92);
    expect(texture_min_alpha(&t), 0);
    float mean[3], sum = d.srgb[0] + d.srgb[85] + d.srgb[170] + d.srgb[255];
    texture_mean(&t, mean);
    expect(mean[1], (double)sum / 4);
    free(f);
}

TEST(test_strange_coordinates)
{
    static const float strange[] = {NAN, INFINITY, -INFINITY, 3e38f, -1e20f, 1e7f, -0.0f, 1e-40f};
    struct scene_fixture *f = fixture_new();
    for (uint32_t wrap = 0; wrap < 3; wrap++)
        for (uint32_t filter = 0; filter < 2; filter++) {
            struct texture_decoding d;
            struct texture t = ramp_texture(f, &d, wrap, filter, 0);
            for (int i = 0; i < 8; i++)
                for (int k = 0; k < 8; k++) {
                    float v = grey(&t, strange[i], strange[k]);
                    assert_true(v >= 0.0f && v <= 1.0f);
                }
        }
    free(f);
}

TEST(test_transform_and_sets)
{
    struct scene_fixture *f = fixture_new();
    struct material_table *table;
    uint32_t texture = fixture_texture(f, 4, 1, ramp, 0);
    f->textures[texture].filter = FILTER_NEAREST;
    uint32_t m = fixture_material(f, 0.5f, 1, 1);
    f->materials[m].base_color_texture = (struct scene_texture_ref){
        .texture = texture, .uv_set = 1, .transform = {0, 1, 0.25f, 1, 0, 0}};
    assert_int_equal(material_table_create(fixture_scene(f), &table), 0);
    struct material_uv uv = {.set = {{0.9f, 0.9f}, {0.1f, 0.4f}}};
    float out[4];
    material_base_color(&table->materials[m], &uv, out);
    expect(out[0], 0.5 * 2 / 3); /* u' = v + 0.25 = 0.65 */
    expect(out[1], 2.0 / 3);
    expect(out[3], 85.0 / 255);
    material_table_destroy(&table);
    assert_null(table);
    free(f);
}

/* Tests for alpha run only where a surface can be transparent. */
TEST(test_cutoffs)
{
    struct scene_fixture *f = fixture_new();
    struct material_table *table;
    uint32_t texture = fixture_texture(f, 4, 1, ramp, 0);
    for (int i = 0; i < 4; i++) fixture_material(f, 1, 1, 1);
    f->materials[0].base_color_texture.texture = texture; /* opaque */
    f->materials[1].base_color_texture.texture = texture;
    f->materials[1].alpha_mode = ALPHA_BLEND;
    f->materials[2].alpha_mode = ALPHA_MASK; /* without texture, alpha 1 */
    f->materials[2].alpha_cutoff = 0.7f;
    f->materials[3].alpha_mode = ALPHA_MASK;
    f->materials[3].alpha_cutoff = 0.7f;
    f->materials[3].base_color[3] = 0.6f;
    assert_int_equal(material_table_create(fixture_scene(f), &table), 0);
    expect(table->materials[0].alpha_cutoff, 0);
    expect(table->materials[1].alpha_cutoff, 0.5);
    expect(table->materials[2].alpha_cutoff, 0);
    expect(table->materials[3].alpha_cutoff, 0.7);
    material_table_destroy(&table);
    free(f);
}
