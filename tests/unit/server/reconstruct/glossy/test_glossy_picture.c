/* Planes of glossy lobes on their way to the picture: from tiles to patches, and into the resolve.
 */
#include "tests/unit/server/reconstruct/glossy/glossy_scene.h"
#include "tests/unit/unit.h"

#include "proto/half.h"
#include "proto/octahedron.h"
#include "server/film/gather.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/compose/resolve.h"

#define BIT(plane) PLANE_BIT(plane)

enum { SIDE = 24, INNER = 8 };

static const struct rect tile = {0, 0, SIDE, SIDE};

static void picture_plan(struct plan *plan, uint32_t filter)
{
    floor_plan(plan, SIDE, filter, 2);
    plan->planes |= PLANES_GLOSSY_LIGHT | BIT(SUB_REFLECTANCE) | BIT(ALBEDO) | BIT(SUB_DEPTH) |
                    BIT(SUB_NORMAL) | BIT(SUB_ALBEDO) | BIT(SUB_ID) | BIT(BOUNCE_DISTANCE_MIN);
    plan->sub_samples = 3;
}

static void fill(uint16_t *plane, uint16_t value)
{
    for (size_t i = 0; i < SIDE * SIDE; i++) plane[i] = value;
}

/* One floor of albedo 0.5 that sends on 0.25 and 2 (c + 1) of radiance by its lobe, of reflectance
 * 0.125 at the centre and 0.25 beside it. */
static struct samples *picture_tile(const struct plan *plan)
{
    struct samples_layout layout;
    struct samples *s;
    assert_int_equal(samples_layout_init(&layout, plan, 0, SIDE, SIDE), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    const float up[3] = {0, 1, 0};
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            const size_t i = (size_t)(y * SIDE + x);
            float at[3], d[3];
            samples_f32(s, PLANE_DEPTH, 0)[i] = floor_point(plan, x, y, at, d);
            samples_u32(s, PLANE_NORMAL, 0)[i] = octahedron_pack16(up);
            samples_u32(s, PLANE_ID, 0)[i] = 1;
        }
    for (uint32_t c = 0; c < 3; c++) {
        fill(samples_u16(s, PLANE_ALBEDO, c), 32768);
        fill(samples_u16(s, PLANE_INDIRECT_MEAN, c), half_from_float(0.5f));
        fill(samples_u16(s, PLANE_GLOSSY_MEAN, c), half_from_float(2.0f * (float)(c + 1)));
        fill(samples_u16(s, PLANE_GLOSSY_LOBE, c), 8192);
        fill(samples_u16(s, PLANE_BOUNCE_DISTANCE_MIN, 0), half_from_float(1.0f));
        for (uint32_t k = 0; k < 3; k++) {
            fill(samples_u16(s, PLANE_SUB_ALBEDO, 3 * k + c), 32768);
            fill(samples_u16(s, PLANE_SUB_REFLECTANCE, 3 * k + c), 16384);
            fill(samples_u16(s, PLANE_SUB_NORMAL, k), octahedron_pack8(up));
            fill(samples_u16(s, PLANE_SUB_ID, k), 1);
        }
    }
    fill(samples_u16(s, PLANE_GLOSSY_MEAN, 3), half_from_float(1.0f));
    fill(samples_u16(s, PLANE_GLOSSY_LOBE, 3), 6554);
    fill(samples_u16(s, PLANE_GLOSSY_NEARNESS, 0), half_from_float(0.5f));
    return s;
}

/* How far lobes see, and how many rays they have, also in the far halo. */
TEST(patches_tell_of_lobes_second_sets)
{
    struct plan plan;
    struct patch *p;
    uint8_t lobes[SIDE * SIDE] = {0};
    picture_plan(&plan, GLOSSY_FILTER_NONE);
    plan.indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    plan.planes |= PLANE_BIT(GLOSSY_SPAN);
    plan.length_unit = 8;
    struct samples *s = picture_tile(&plan);
    fill(samples_u16(s, PLANE_GLOSSY_SPAN, 0), half_from_float(0.5f));
    fill(samples_u16(s, PLANE_GLOSSY_SPAN, 1), half_from_float(2.0f));
    lobes[0] = 3;
    lobes[SIDE * SIDE - 1] = 255;
    assert_int_equal(patch_create(&plan, tile, &p), 0);
    p->core = (struct rect){INNER - 1, INNER - 1, SIDE - INNER + 1, SIDE - INNER + 1};
    gather_tile(&plan, s, (struct pass_counts){.paths = 4, .bounces = 4, .lobes = lobes}, tile, p);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int side = lobes[i];
        assert_true(p->glossy_near[i] == 4.0f && p->glossy_far[i] == 16.0f);
        assert_true(p->glossy_alpha[i] > 0.0f);
        assert_true(p->glossy_rays[i] == 4.0f + (float)(side * side));
    }
    assert_int_equal(patch_count_glossy(p, tile), SIDE * SIDE);
    patch_destroy(&p);
    samples_destroy(&s);
}

static struct patch *picture_patch(const struct plan *plan, const struct samples *s)
{
    struct patch *p;
    assert_int_equal(patch_create(plan, tile, &p), 0);
    p->core = (struct rect){INNER - 1, INNER - 1, SIDE - INNER + 1, SIDE - INNER + 1};
    const struct pass_counts counts = {.paths = 4, .bounces = 4};
    gather_tile(plan, s, counts, tile, p);
    return p;
}

/* What filters read is there in the far halo, too, and in the units of the scene. */
TEST(tiles_become_patches)
{
    struct plan plan;
    picture_plan(&plan, GLOSSY_FILTER_VIRTUAL_HIT);
    plan.radiance_scale = 0.25f;
    plan.length_unit = 8;
    struct samples *s = picture_tile(&plan);
    struct patch *p = picture_patch(&plan, s);
    const size_t far = 0, near = patch_pixel(p, SIDE / 2, SIDE / 2);
    for (size_t i = far;; i = near) {
        assert_int_equal(p->id[i], 1);
        for (int c = 0; c < 3; c++) assert_true(p->glossy[c][i] == 8.0f * (float)(c + 1));
        assert_true(p->glossy_weight[i] == 1.0f);
        assert_true(fabsf(p->glossy_alpha[i] - 0.1f) < 1e-4f);
        assert_true(p->glossy_nearness[i] == 0.0625f);
        if (i == near) break;
    }
    assert_true(fabsf(p->reflectance[1][near] - 0.125f) < 1e-5f);
    assert_true(fabsf(p->sub_reflectance[2][1][near] - 0.25f) < 1e-5f);
    patch_destroy(&p);
    samples_destroy(&s);
}

static void resolve(const struct plan *plan, const struct patch *patch, size_t i,
                    struct resolved *out)
{
    struct lighting lighting;
    struct lighting_statistics statistics = {.shadow_cpu_us = 0};
    struct resolver resolver;
    assert_int_equal(lighting_create(plan, patch, patch->core, false, &lighting, &statistics), 0);
    resolver_init(&resolver, plan, patch, &lighting);
    resolver.errors = patch_knows_glossy_errors(plan);
    resolve_pixel(&resolver, i, out);
    lighting_fini(&lighting);
}

/* The picture: albedo times diffuse light and reflectance times the lobes', each sample its own. */
TEST(lobes_are_in_the_picture)
{
    for (uint32_t filter = 0; filter <= GLOSSY_FILTER_LAST; filter++) {
        struct plan plan;
        struct resolved out;
        picture_plan(&plan, filter);
        struct samples *s = picture_tile(&plan);
        struct patch *p = picture_patch(&plan, s);
        resolve(&plan, p, patch_pixel(p, SIDE / 2, SIDE / 2), &out);
        const float reflectance = (0.125f + 3 * 0.25f) / 4;
        for (int c = 0; c < 3; c++) {
            const float truth = 0.25f + reflectance * 2.0f * (float)(c + 1);
            assert_true(fabsf(out.indirect[c] - truth) < 1e-4f * truth);
            assert_true(out.total[c] == out.indirect[c] && out.direct[c] == 0.0f);
        }
        patch_destroy(&p);
        samples_destroy(&s);
    }
}

/* Halves that are off by 0.5 everywhere: the light is known to that, and the picture to that times
 * what lobes reflect. What samples of a pixel send on differs by their reflectance. */
TEST(errors_are_in_the_picture)
{
    for (uint32_t filter = 0; filter <= GLOSSY_FILTER_LAST; filter++) {
        struct plan plan;
        struct resolved out;
        picture_plan(&plan, filter);
        plan.planes |= BIT(GLOSSY_HALF);
        struct samples *s = picture_tile(&plan);
        for (uint32_t c = 0; c < 3; c++)
            fill(samples_u16(s, PLANE_GLOSSY_HALF, c),
                 half_from_float(2.0f * (float)(c + 1) + 0.5f));
        fill(samples_u16(s, PLANE_GLOSSY_HALF, 3), half_from_float(1.0f));
        struct patch *p = picture_patch(&plan, s);
        resolve(&plan, p, patch_pixel(p, SIDE / 2, SIDE / 2), &out);
        const float reflectance = (0.125f + 3 * 0.25f) / 4, error = 0.5f * reflectance;
        for (int c = 0; c < 3; c++) {
            const float step = 0.125f * 2.0f * (float)(c + 1); /* of one sample to three others */
            const float spread = 0.5f * step * step * (0.25f - 0.0625f) / 3 - error * error;
            assert_true(fabsf(out.glossy_error[c] - error) < 1e-4f);
            assert_true(out.error[c] == 0.0f);
            assert_true(fabsf(out.spread[c] - fmaxf(spread, 0.0f)) < 1e-4f);
        }
        patch_destroy(&p);
        samples_destroy(&s);
    }
}

/* A sub-sample whose lobe no pixel around has sees what diffuse surfaces see. */
TEST(lobes_beside_centres_borrow)
{
    struct plan plan;
    struct resolved out;
    picture_plan(&plan, GLOSSY_FILTER_VIRTUAL_HIT);
    struct samples *s = picture_tile(&plan);
    fill(samples_u16(s, PLANE_GLOSSY_LOBE, 3), 0);
    for (uint32_t c = 0; c < 3; c++) {
        fill(samples_u16(s, PLANE_GLOSSY_LOBE, c), 0);
        fill(samples_u16(s, PLANE_GLOSSY_MEAN, c), 0);
    }
    struct patch *p = picture_patch(&plan, s);
    resolve(&plan, p, patch_pixel(p, SIDE / 2, SIDE / 2), &out);
    const float truth = 0.25f + 3 * 0.25f / 4 * 0.5f;
    for (int c = 0; c < 3; c++) assert_true(fabsf(out.indirect[c] - truth) < 1e-4f);
    patch_destroy(&p);
    samples_destroy(&s);
}

TEST(halos_hold_what_filters_read)
{
    struct plan plan;
    picture_plan(&plan, GLOSSY_FILTER_NONE);
    plan.height_px = plan.width_px = 1024;
    assert_int_equal(block_halo_px(&plan), PATCH_RING_PX);
    plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT;
    assert_int_equal(block_halo_px(&plan), PATCH_RING_PX + glossy_halo_px(&plan));
    assert_true(block_side_px(&plan) > 64);
}
