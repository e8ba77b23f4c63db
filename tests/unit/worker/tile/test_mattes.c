/* Which objects and materials cover a pixel. */
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "proto/scene/matte.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

enum { SIDE = 8 };

static float share_of(const struct samples *s, int32_t x, int32_t y, const char *object)
{
    const size_t at = (size_t)(y * SIDE + x);
    for (uint32_t r = 0; r < MATTE_RANKS; r++) {
        float share;
        half_to_floats(samples_u16(s, PLANE_MATTE_OBJECT_SHARES, r) + at, &share, 1);
        if (share > 0.0f && samples_u32(s, PLANE_MATTE_OBJECTS, r)[at] == matte_id(object))
            return share;
    }
    return 0.0f;
}

static float material_at(const struct samples *s, int32_t x, int32_t y, uint32_t *id)
{
    const size_t at = (size_t)(y * SIDE + x);
    float share;
    *id = samples_u32(s, PLANE_MATTE_MATERIALS, 0)[at];
    half_to_floats(samples_u16(s, PLANE_MATTE_MATERIAL_SHARES, 0) + at, &share, 1);
    return share;
}

/* A floor, and above it a panel from x in pixels on; seen from far above, so that both agree. */
static struct plan panel_plan(struct scene_fixture *f, float from_px)
{
    struct plan p = floor_plan(f, 3.0f, SIDE);
    const uint32_t red = fixture_material(f, 1, 0, 0);
    const float x = (from_px / SIDE - 0.5f) * 4.0f;
    fixture_panel(f, red, (float[]){x + 2, 1e-3f, 0}, (float[]){2, 0, 0}, (float[]){0, 0, -3});
    p.planes |= PLANES_MATTE;
    return p;
}

TEST(a_pixel_is_covered_by_half)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = panel_plan(f, 4.5f);
    struct traced t = trace_all(f, &p);
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            const float expected = x < 4 ? 0.0f : x > 4 ? 1.0f : 0.5f;
            const float floor = share_of(t.samples, x, y, "object 0"),
                        panel = share_of(t.samples, x, y, "object 1");
            assert_true(floor + panel == 1.0f);
            assert_float_equal(panel, expected, 1.0f / 64.0f);
        }
    traced_fini(&t);
    free(f);
}

TEST(shares_of_what_stands_in_the_open_are_those_it_covers)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 1.125f, SIDE); /* from pixel 1.75 to pixel 6.25 */
    p.planes |= PLANES_MATTE;
    struct traced t = trace_all(f, &p);
    assert_true(share_of(t.samples, 0, 0, "object 0") == 0.0f);
    assert_true(share_of(t.samples, 4, 4, "object 0") == 1.0f);
    assert_float_equal(share_of(t.samples, 1, 4, "object 0"), 0.25, 1.0 / 64);
    assert_float_equal(share_of(t.samples, 6, 6, "object 0"), 0.0625, 1.0 / 32);
    traced_fini(&t);
    free(f);
}

TEST(what_is_blended_covers_its_alpha)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = panel_plan(f, 0.0f);
    float sum = 0.0f;
    f->materials[1].alpha_mode = ALPHA_BLEND;
    f->materials[1].base_color[3] = 0.25f;
    struct traced t = trace_all(f, &p);
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            const float panel = share_of(t.samples, x, y, "object 1");
            assert_true(panel + share_of(t.samples, x, y, "object 0") == 1.0f);
            sum += panel;
        }
    assert_float_equal(sum / (SIDE * SIDE), 0.25, 0.02);
    traced_fini(&t);
    free(f);
}

/* Ten panels cross a pixel, two of one name, with one material: the six names that cover most. */
TEST(the_largest_six_are_kept)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 3.0f, SIDE);
    const uint32_t red = fixture_material(f, 1, 0, 0);
    uint32_t id;
    f->names = "\0pair\0red";
    f->materials[red].name = 6;
    for (int k = 0; k < 10; k++) {
        const float from = 0.5f * (float)k / 10.0f; /* in pixel 4 */
        const uint32_t at = fixture_panel(f, red, (float[]){from + 0.025f, 1e-3f, 0},
                                          (float[]){0.025f, 0, 0}, (float[]){0, 0, -3});
        if (k == 2 || k == 7) f->instances[at].name = 1;
    }
    p.planes |= PLANES_MATTE;
    struct traced t = trace_all(f, &p);
    assert_float_equal(share_of(t.samples, 4, 4, "pair"), 0.2, 1.0 / 32);
    assert_int_equal(samples_u32(t.samples, PLANE_MATTE_OBJECTS, 0)[4 * SIDE + 4],
                     matte_id("pair"));
    for (uint32_t r = 1; r < MATTE_RANKS; r++) {
        const uint16_t *shares = samples_u16(t.samples, PLANE_MATTE_OBJECT_SHARES, r);
        assert_true(shares[4 * SIDE + 4] > 0); /* positive halves are ordered like their bits */
        assert_true(shares[4 * SIDE + 4] <=
                    samples_u16(t.samples, PLANE_MATTE_OBJECT_SHARES, r - 1)[4 * SIDE + 4]);
    }
    assert_true(material_at(t.samples, 4, 4, &id) == 1.0f);
    assert_int_equal(id, matte_id("red"));
    traced_fini(&t);
    free(f);
}

/* Through a lens out of focus, things share a pixel that they would not share in focus. */
TEST(a_lens_blurs_shares)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 4.0f);
    p.camera.aperture_radius = 0.5f;
    p.camera.focus_distance = 8.0f; /* a disc of a half unit: one pixel */
    struct traced t = trace_all(f, &p);
    const float panel = share_of(t.samples, 3, 4, "object 1");
    assert_in_range(panel * 1000, 50, 450);
    assert_true(panel + share_of(t.samples, 3, 4, "object 0") == 1.0f);
    assert_true(share_of(t.samples, 0, 4, "object 1") == 0.0f);
    traced_fini(&t);
    free(f);
}

TEST(no_other_plane_changes)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 4.5f);
    fixture_ceiling_light(&p, 0, 2, 0, 0.5f, 2);
    struct traced with = trace_all(f, &p);
    p.planes &= ~PLANES_MATTE;
    struct traced without = trace_all(f, &p);
    for (uint32_t slot = 0; slot < without.samples->layout.slots; slot++) {
        const uint32_t bytes = samples_type_bytes(samples_plane(slot)->type);
        for (uint32_t c = 0; c < without.samples->layout.components[slot]; c++)
            assert_memory_equal(samples_component(with.samples, slot, c),
                                samples_component(without.samples, slot, c),
                                (size_t)SIDE * SIDE * bytes);
    }
    assert_true(count(&with, COUNTER_RAYS_PRIMARY) > count(&without, COUNTER_RAYS_PRIMARY));
    assert_int_equal(count(&with, COUNTER_PATHS), count(&without, COUNTER_PATHS));
    traced_fini(&with);
    traced_fini(&without);
    free(f);
}
