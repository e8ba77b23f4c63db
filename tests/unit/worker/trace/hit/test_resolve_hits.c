/* What sixteen rays met: panels of several materials side by side, and nothing between them. */
#include <stdlib.h>

#include "tests/random.h"
#include "tests/unit/worker/trace/hit/panel_scene.h"
#include "tests/unit/worker/trace/isa_fixture.h"

/* Panel k covers x from k to k + 0.9, y from -0.5 to 0.5. */
enum panel { TEXTURED, TEXTURED_UNLIT, UNLIT, LAMBERT, GLOSSY, TEXTURED_GLOSSY, SHINING, PLACED };
enum { PANELS = PLACED + 1 };

static const uint8_t texel[4] = {51, 102, 204, 255};

static void add_panel(int kind)
{
    const uint32_t m = fixture_material(f, 0.5f, 0.25f, 1.0f);
    struct scene_material *material = &f->materials[m];
    const bool textured = kind == TEXTURED || kind == TEXTURED_UNLIT || kind == TEXTURED_GLOSSY;
    if (textured) material->base_color_texture.texture = fixture_texture(f, 1, 1, texel, 0);
    if (kind == UNLIT || kind == TEXTURED_UNLIT) material->flags |= MATERIAL_UNLIT;
    if (kind == GLOSSY || kind == TEXTURED_GLOSSY) material->specular = 1.0f;
    if (kind == SHINING) material->emission[1] = 3.0f;
    const uint32_t mesh = fixture_mesh(f, m, 0);
    const float x = kind == PLACED ? 0.45f : (float)kind + 0.45f;
    fixture_quad(f, (float[]){x, 0, 0}, (float[]){0.45f, 0, 0}, (float[]){0, 0.5f, 0});
    if (kind == PLACED)
        fixture_place_at(f, mesh, (float[]){1, 0, 0, PLACED, 0, 1, 0, 0, 0, 0, 1, 0});
    else
        fixture_place(f, mesh);
}

static int open_scene(void **state)
{
    (void)state;
    return open_panels(PANELS, add_panel);
}

ALL_TESTS(open_scene, close_panels);

static void expect_panel(const struct surface *s, int i, enum panel kind)
{
    static const float light[3] = {0.5f * 51 / 255, 0.25f * 102 / 255, 204.0f / 255};
    assert_int_equal(s->id[i], kind + 1);
    assert_true(fabsf(s->distance[i] - 3.0f) < 1e-5f);
    if (kind == TEXTURED)
        expect_color(&s->albedo, i, light[0], light[1], light[2]);
    else if (kind == LAMBERT || kind == SHINING || kind == PLACED)
        expect_color(&s->albedo, i, 0.5f, 0.25f, 1.0f);
    else if (kind == GLOSSY || kind == TEXTURED_GLOSSY)
        expect_color(&s->albedo, i, 1, 1, 1);
    else
        expect_color(&s->albedo, i, 0, 0, 0);
    if (kind == TEXTURED_UNLIT)
        expect_color(&s->emission, i, light[0], light[1], light[2]);
    else if (kind == UNLIT)
        expect_color(&s->emission, i, 0.5f, 0.25f, 1.0f);
    else
        expect_color(&s->emission, i, 0, kind == SHINING ? 3.0f : 0.0f, 0);
}

static void expect_lane(const struct surface *s, int i, bool hit, enum panel kind)
{
    assert_int_equal(s->hit.on[i], hit ? -1 : 0);
    assert_int_equal(s->mesh[i] != NULL, hit);
    if (hit) {
        expect_panel(s, i, kind);
        return;
    }
    assert_true(s->id[i] == 0 && s->distance[i] == 0.0f);
    expect_color(&s->albedo, i, 0, 0, 0);
    expect_color(&s->emission, i, 0, 0, 0);
}

/* Lanes that look at panels first .. last, of which some pass beside. */
static void look(const struct hit_kernels *kernels, struct random *r, int first, int last)
{
    static struct surface s;
    struct queries q;
    struct lanes_mask valid;
    _Alignas(LANES_ALIGN) struct RTCRayHit16 rays;
    enum panel kind[LANES];
    bool hit[LANES], any_bsdf = false, any_emission = false;
    const uint32_t beside = (uint32_t)(random_bits(r) % 3); /* none, some, half of them */
    queries_init(&q);
    q.scene = scene;
    q.kernels = kernels;
    queries_init_rays(&rays);
    memset(&s, 0x40, sizeof s); /* what was there before is nobody's */
    for (int i = 0; i < LANES; i++) {
        kind[i] = (enum panel)(first + (int)(random_bits(r) % (uint32_t)(last - first + 1)));
        valid.on[i] = random_bits(r) % 16 ? -1 : 0;
        const bool off = beside && random_bits(r) % 8 < 2 * beside;
        hit[i] = valid.on[i] && !off;
        rays.ray.org_x[i] = (float)kind[i] + 0.1f + 0.7f * random_unit(r);
        rays.ray.org_y[i] = off ? 0.7f : 0.8f * (random_unit(r) - 0.5f);
        rays.ray.org_z[i] = 3.0f;
        rays.ray.dir_z[i] = -1.0f;
        rays.ray.tfar[i] = INFINITY;
        any_bsdf |= hit[i] && (kind[i] == GLOSSY || kind[i] == TEXTURED_GLOSSY);
        any_emission |=
            hit[i] && (kind[i] == SHINING || kind[i] == UNLIT || kind[i] == TEXTURED_UNLIT);
    }
    queries_closest(&q, QUERY_CAMERA, &valid, &rays);
    hit_resolve(&q, &valid, &rays, &s);
    for (int i = 0; i < LANES; i++) expect_lane(&s, i, hit[i], kind[i]);
    assert_int_equal(s.any_bsdf, any_bsdf);
    assert_int_equal(s.any_emission, any_emission);
}

TEST(surfaces_are_the_panels)
{
    struct random r = {1};
    for (int k = 0; k < isa_count(); k++)
        for (int round = 0; round < 40; round++) {
            const struct hit_kernels *kernels = KERNELS_FOR(hit_kernels, all_isas[k]);
            for (int one = 0; one < PANELS; one++) look(kernels, &r, one, one);
            look(kernels, &r, 0, PANELS - 1);
            look(kernels, &r, UNLIT, GLOSSY);
            look(kernels, &r, SHINING, PLACED);
        }
}
