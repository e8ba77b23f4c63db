/* Which pixels trace at half resolution, and whom they stand for. */
#include "proto/half_field.h"

#include <string.h>

#include "tests/unit/proto/plan_case.h"
#include "tests/unit/unit.h"

static struct plan plan;
static struct surface_view view;

static int set_up(void **state)
{
    (void)state;
    plan_case(&plan);
    plan.camera.aperture_radius = 0;
    surface_view_init(&view, &plan);
    return 0;
}

EACH_TEST(set_up, NULL);

/* A lobe at pixel (x, y) of a wall four units away, turned by `turn` about the up axis. */
static struct half_field_lobe lobe_at(float x, float y, float turn)
{
    const float cosine = cosf(turn), sine = sinf(turn);
    struct half_field_lobe out = {.alpha = 0.1f};
    shown_surface_init(&view, x + 0.5f, y + 0.5f, 4.0f, (const float[3]){sine, 0, cosine}, 1,
                       &out.surface);
    return out;
}

TEST(nodes_of_a_pixel_lie_in_its_sixteen)
{
    for (int32_t y = 0; y < 16; y++)
        for (int32_t x = 0; x < 16; x++) {
            int nodes = 0;
            for (int32_t v = y & ~3; v < (y & ~3) + 4; v++)
                for (int32_t u = x & ~3; u < (x & ~3) + 4; u++)
                    nodes += half_field_is_node(u, v) && u - x <= 1 && x - u <= 1 && v - y <= 1 &&
                             y - v <= 1;
            assert_true(nodes >= 1 && nodes <= 4);
            if (half_field_is_node(x, y)) assert_int_equal(nodes, 1);
        }
}

TEST(halves_alternate_over_nodes)
{
    for (int32_t y = 1; y < 16; y += 2)
        for (int32_t x = 1; x < 16; x += 2) {
            assert_true(half_field_part(x, y) != half_field_part(x + 2, y));
            assert_true(half_field_part(x, y) != half_field_part(x, y + 2));
        }
}

TEST(lobes_part_as_they_turn)
{
    const struct half_field_lobe own = lobe_at(360, 240, 0.3f);
    assert_true(half_field_apart2(&view, &own, &own) == 0.0f);
    float before = 0.0f;
    for (int k = 1; k < 5; k++) {
        const struct half_field_lobe other = lobe_at(360, 240, 0.3f + 0.01f * (float)k);
        const float apart2 = half_field_apart2(&view, &own, &other);
        assert_true(apart2 > before);
        before = apart2;
    }
    /* A normal turned by t turns what is mirrored by 2 t. */
    const float width = 2.0f * 0.665190105f * 0.1f * cosf(0.3f);
    assert_true(fabsf(sqrtf(before) * width - 2.0f * sinf(0.04f)) < 1e-3f);
}

/* What is near moves more from pixel to pixel. */
TEST(parallax_parts_lobes)
{
    const struct half_field_lobe own = lobe_at(360, 240, 0.0f);
    struct half_field_lobe far = lobe_at(361, 240, 0.0f), near = far;
    near.nearness = 10.0f;
    assert_true(half_field_apart2(&view, &own, &near) > half_field_apart2(&view, &own, &far));
}

TEST(other_lobes_are_no_neighbours)
{
    const struct half_field_lobe own = lobe_at(360, 240, 0.3f), grazing = lobe_at(360, 240, 1.53f);
    struct half_field_lobe other = own;
    other.alpha = 0.12f;
    assert_true(half_field_apart2(&view, &own, &other) == INFINITY);
    assert_true(half_field_apart2(&view, &own, &grazing) == INFINITY);
    assert_true(half_field_apart2(&view, &grazing, &own) == INFINITY);
}

/* Errors vanish as rays grow: ever fewer pixels take what others have. */
TEST(tolerances_shrink_as_rays_grow)
{
    for (uint32_t l = 1; l < 16; l++) {
        assert_true(half_field_near_px(l + 1) > half_field_near_px(l));
        assert_true(half_field_apart2_most(l + 1) < half_field_apart2_most(l));
    }
}
