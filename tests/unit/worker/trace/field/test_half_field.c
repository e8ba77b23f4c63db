/* Fields at half resolution: which pixels trace, that they bring the light that all pixels bring,
 * and that tiles do not matter. */
#include <stdlib.h>

#include "proto/half_field.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_room.h"

static bool has_rays(const struct samples *s, int i)
{
    return samples_u16(s, PLANE_BOUNCE_DISTANCE_MIN, 0)[i] != 0;
}

/* A floor under a roof at the given height, from above through a hole: the roof is what is near. */
static struct plan roofed(struct scene_fixture *f, float height, uint32_t l)
{
    struct plan p = floor_plan(f, 3, SIDE_PX);
    const uint32_t white = fixture_material(f, 0.8f, 0.8f, 0.8f);
    fixture_panel(f, white, (float[]){0, 5 + height, 0}, (float[]){9, 0, 0}, (float[]){0, 0, 9});
    fixture_light(&p, LIGHT_POINT, 1)->position[1] = 3.0f;
    p.light_planes = 0;
    p.planes = BIT(DEPTH) | BIT(NORMAL) | BIT(ALBEDO) | BIT(ID) | BIT(INDIRECT_MEAN) |
               BIT(BOUNCE_DISTANCE_MIN);
    p.bounces = 1;
    p.indirect_strata_per_axis = l;
    p.indirect_filter = INDIRECT_FILTER_CONSTANT;
    return p;
}

/* At the picture's upper and left border pixels lie between no nodes. */
static bool is_border(int i)
{
    return i % SIDE_PX == 0 || i / SIDE_PX == 0;
}

enum { BORDER = 2 * SIDE_PX - 1 };

TEST(nodes_trace_and_others_do_not)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = roofed(f, 0, 4);
    p.field_halved = 1;
    struct traced t = trace_all(f, &p);
    for (int i = 0; i < AREA; i++)
        assert_true(has_rays(t.samples, i) ==
                    (is_border(i) || half_field_is_node(i % SIDE_PX, i / SIDE_PX)));
    assert_int_equal(count(&t, COUNTER_RAYS_INDIRECT), (AREA / 4 + BORDER) * 16);
    assert_int_equal(count(&t, COUNTER_SKIPPED_HALF_FIELD), (AREA * 3 / 4 - BORDER) * 16);
    assert_int_equal(count(&t, COUNTER_RAYS_ANEW), BORDER * 16);
    traced_fini(&t);
    free(f);
}

/* Where something is as near as the floor's pixels are large, light changes between these. */
TEST(near_things_ask_for_all_rays)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = roofed(f, 0, 4);
    const uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    p.field_halved = 1;
    fixture_panel(f, grey, (float[]){-0.02f, 0.5f, 0}, (float[]){0, 0, 3}, (float[]){0, 0.5f, 0});
    struct traced t = trace_all(f, &p);
    assert_true(count(&t, COUNTER_RAYS_ANEW) > BORDER * 16);
    assert_true(count(&t, COUNTER_SKIPPED_HALF_FIELD) > 0);
    assert_int_equal(count(&t, COUNTER_RAYS_ANEW) + count(&t, COUNTER_SKIPPED_HALF_FIELD),
                     AREA * 3 / 4 * 16);
    traced_fini(&t);
    free(f);
}

/* Sticks as wide as a pixel, where no node is: their pixels have rays of their own. */
TEST(surfaces_without_a_node_trace)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = roofed(f, 0, 3);
    const uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    double at[3];
    p.field_halved = 1;
    floor_point(&p, 6, 8, at);
    fixture_panel(f, grey, (float[]){(float)at[0] * 0.5f, 2, 0}, (float[]){0, 0, 3},
                  (float[]){0.04f, 0, 0});
    struct traced t = trace_all(f, &p);
    const uint32_t *id = samples_u32(t.samples, PLANE_ID, 0);
    int sticks = 0;
    for (int i = 0; i < AREA; i++) {
        const bool node = half_field_is_node(i % SIDE_PX, i / SIDE_PX);
        sticks += id[i] == 3 && !node;
        if (id[i] == 3 || node) assert_true(has_rays(t.samples, i));
    }
    assert_true(sticks >= SIDE_PX / 2);
    traced_fini(&t);
    free(f);
}

/* The light is that of the field at full resolution. */
TEST(the_light_is_the_same)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, LAMBERT, SHINES_RECT);
    p.planes = 0;
    p.paths.spp = 0;
    p.bounces = 2;
    add_field(&p, 16);
    p.indirect_filter = INDIRECT_FILTER_CONSTANT;
    struct sums *full = trace_sums(f, &p);
    p.field_halved = 1;
    struct sums *half = trace_sums(f, &p);
    for (uint32_t c = 0; c < 3; c++) {
        double a[AREA], b[AREA]; /* a node's four times, so that both have as many */
        for (int i = 0; i < AREA; i++) {
            const int node = (i / SIDE_PX | 1) * SIDE_PX + (i % SIDE_PX | 1);
            a[i] = half_at(full->first, PLANE_INDIRECT_MEAN, c, i);
            b[i] = half_at(half->first, PLANE_INDIRECT_MEAN, c, node);
            assert_true(b[i] > 0.0);
        }
        expect_same("halved field", a, b, 0.02);
    }
    sums_free(&full);
    sums_free(&half);
    free(f);
}

/* A pixel's samples are the same bytes in a tile that cuts squares of four. */
TEST(tiles_may_cut_squares)
{
    const struct rect part = {3, 1, SIDE_PX - 2, SIDE_PX};
    for (enum kind kind = LAMBERT; kind <= COATED; kind++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = room(f, kind, SHINES_RECT | SHINES_SKY);
        p.bounces = 2;
        p.paths.spp = 1;
        add_field(&p, 4);
        p.planes |= kind == LAMBERT ? 0 : PLANES_GLOSSY & ~PLANES_GLOSSY_AXES;
        p.sub_samples = kind == LAMBERT ? 0 : 3;
        p.camera.half_width = p.camera.half_height = 0.3f;
        p.indirect_filter = INDIRECT_FILTER_LINEAR;
        p.field_halved = 1;
        struct traced all = trace_all(f, &p), cut = trace(f, &p, part);
        for (int32_t y = part.y0; y < part.y1; y++)
            for (int32_t x = part.x0; x < part.x1; x++) {
                const int i = y * SIDE_PX + x, k = (y - part.y0) * rect_width(part) + x - part.x0;
                for (uint32_t c = 0; c < 3; c++)
                    assert_int_equal(samples_u16(all.samples, PLANE_INDIRECT_MEAN, c)[i],
                                     samples_u16(cut.samples, PLANE_INDIRECT_MEAN, c)[k]);
                for (uint32_t c = 0; kind != LAMBERT && c < 4; c++)
                    assert_int_equal(samples_u16(all.samples, PLANE_GLOSSY_MEAN, c)[i],
                                     samples_u16(cut.samples, PLANE_GLOSSY_MEAN, c)[k]);
            }
        assert_true(count(&all, COUNTER_SKIPPED_HALF_FIELD) > 0);
        traced_fini(&cut);
        traced_fini(&all);
        free(f);
    }
}

/* Lobes that all see the same from one point share rays; what is brought is the same light. */
TEST(lobes_share_rays)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, COATED, SHINES_RECT);
    p.bounces = 2;
    p.paths.spp = 1;
    add_field(&p, 16);
    p.planes |= PLANES_GLOSSY & ~PLANES_GLOSSY_AXES;
    p.paths.without_glossy_indirect = 1;
    p.sub_samples = 3;
    p.indirect_filter = INDIRECT_FILTER_CONSTANT;
    struct sums *full = trace_sums(f, &p);
    p.field_halved = 1;
    struct sums *half = trace_sums(f, &p);
    for (uint32_t c = 0; c < 3; c++) {
        double a[AREA], b[AREA];
        for (int i = 0; i < AREA; i++) {
            const int x = i % SIDE_PX, y = i / SIDE_PX, node = (y | 1) * SIDE_PX + (x | 1);
            const bool own = is_border(i) || half_field_is_node(x, y);
            a[i] = half_at(full->first, PLANE_GLOSSY_MEAN, c, i);
            b[i] = half_at(half->first, PLANE_GLOSSY_MEAN, c, node);
            assert_true((half_at(half->first, PLANE_GLOSSY_MEAN, 3, i) > 0.0) == own);
        }
        expect_same("halved lobes", a, b, 0.02);
    }
    sums_free(&full);
    sums_free(&half);
    free(f);
}
