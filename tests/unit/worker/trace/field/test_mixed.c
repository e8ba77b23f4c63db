/* Mixed pixels: which they are, how exactly surfaces cover them, and that tiles do not matter. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#define SIDE 32

static const struct rect whole = {0, 0, SIDE, SIDE};

/* A panel over the left part of the floor, half-way between it and the camera, where a pixel is
 * 1/16 wide: left of pixel EDGE_PX + LEAN y. */
#define EDGE_PX 11.3f
#define LEAN    0.271f

static void add_panel(struct scene_fixture *f, uint32_t material, float edge_px, float lean)
{
    const float middle = (edge_px + lean * 16.0f) / 16.0f - 1.0f; /* of the edge */
    fixture_panel(f, material, (float[]){middle - 2.0f, 2.0f, 0}, (float[]){2.0f, 0, 0},
                  (float[]){-lean * 2.0f, 0, -2.0f});
}

static struct plan panel_plan(struct scene_fixture *f, uint32_t l)
{
    struct plan p = floor_plan(f, 4, SIDE);
    add_panel(f, fixture_material(f, 0.75f, 0.25f, 0.5f), EDGE_PX, LEAN);
    p.sub_samples = 3;
    p.planes = PLANES_COMPARED | PLANE_BIT(ALBEDO) | PLANE_BIT(MIXED) | PLANE_BIT(INDIRECT_MEAN);
    p.bounces = 1;
    p.indirect_strata_per_axis = l;
    return p;
}

/* Leaves paths, and what finds their mixed pixels. */
static void paths_only(struct plan *p)
{
    p->sub_samples = p->indirect_strata_per_axis = 0;
    p->planes = PLANES_CENTRE | PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(MIXED);
    p->paths.spp = 8;
}

/* How much of pixel (x, y) lies left of the edge. */
static double coverage(int32_t x, int32_t y, double edge_px, double lean)
{
    double sum = 0.0;
    for (int i = 0; i < 512; i++) {
        const double at = edge_px + lean * (y + (i + 0.5) / 512) - x;
        sum += at < 0 ? 0 : at > 1 ? 1 : at;
    }
    return sum / 512;
}

/* Which of a pixel's entries show the panel, which is nearer. */
static bool is_panel(const struct traced *t, uint32_t place)
{
    const uint32_t pixel = place / MIXED_SLOTS, slot = place % MIXED_SLOTS;
    const size_t lender = pixel + (slot / 3) * SIDE + slot % 3 - SIDE - 1;
    return samples_f32(t->samples, PLANE_DEPTH, 0)[lender] < 3.0f;
}

static double share_of_panel(const struct traced *t, uint32_t pixel, bool *mixed)
{
    const struct sparse_list *list = t->samples->mixed;
    double sum = 0.0;
    *mixed = false;
    for (uint32_t e = 0; e < list->count; e++) {
        if (list->words[e] / MIXED_SLOTS != pixel) continue;
        *mixed = true;
        if (is_panel(t, list->words[e])) sum += (double)sparse_list_numbers(list, MIXED_SHARE)[e];
    }
    return sum;
}

/* RMS error of coverage over the pixels that the edge crosses, all of which must be mixed. */
static double coverage_error(uint32_t l)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = panel_plan(f, l);
    struct traced t = trace_all(f, &p);
    double squares = 0.0;
    uint32_t crossed = 0;
    assert_non_null(t.samples->mixed);
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            bool mixed;
            const double exact = coverage(x, y, (double)EDGE_PX, (double)LEAN);
            const double got = share_of_panel(&t, (uint32_t)(y * SIDE + x), &mixed);
            if (exact <= 0.0 || exact >= 1.0) {
                assert_true(!mixed || fabs(got - exact) < 1e-6);
                continue;
            }
            if (!mixed) fail_msg("(%d, %d) is crossed, but not mixed", x, y);
            squares += (got - exact) * (got - exact);
            crossed++;
        }
    assert_in_range(crossed, SIDE, 2 * SIDE);
    traced_fini(&t);
    free(f);
    return sqrt(squares / crossed);
}

TEST(coverage_converges)
{
    const double error[] = {coverage_error(2), coverage_error(8), coverage_error(16)};
    if (!(error[0] < 0.05)) fail_msg("16 samples err by %g", error[0]);
    if (!(error[1] < error[0] / 2)) fail_msg("64 samples err by %g, 16 by %g", error[1], error[0]);
    if (!(error[2] < error[1] / 2)) fail_msg("256 samples err by %g, 64 by %g", error[2], error[1]);
}

/* Shares add up, and albedos are those of what is seen. */
TEST(entries_are_means)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = panel_plan(f, 4);
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->mixed;
    static const float panel[3] = {0.75f, 0.25f, 0.5f};
    uint32_t entries = 0;
    assert_non_null(list);
    assert_int_equal(list->values, MIXED_REFLECTANCE); /* no lobes */
    for (uint32_t e = 0; e < list->count; e++) {
        const float share = sparse_list_numbers(list, MIXED_SHARE)[e];
        for (uint32_t c = 0; c < 3; c++) {
            const float albedo = is_panel(&t, list->words[e]) ? panel[c] : 0.5f;
            assert_true(fabsf(sparse_list_numbers(list, MIXED_ALBEDO + c)[e] - share * albedo) <
                        1e-5f);
        }
        entries += share > 0.0f;
    }
    assert_in_range(entries, 3 * SIDE, 9 * 3 * SIDE);
    for (uint32_t e = 0; e < list->count;) {
        const uint32_t pixel = list->words[e] / MIXED_SLOTS;
        float sum = 0.0f;
        for (; e < list->count && list->words[e] / MIXED_SLOTS == pixel; e++)
            sum += sparse_list_numbers(list, MIXED_SHARE)[e];
        assert_true(fabsf(sum - 1.0f) < 1e-5f);
    }
    traced_fini(&t);
    free(f);
}

/* Entries of a tile, as places in the whole picture; returns how many there are. */
static uint32_t expect_same(const struct samples *tile, struct rect r,
                            const struct sparse_list *all)
{
    const uint32_t width = (uint32_t)rect_width(r);
    if (!tile->mixed) return 0;
    for (uint32_t e = 0; e < tile->mixed->count; e++) {
        const uint32_t place = tile->mixed->words[e], pixel = place / MIXED_SLOTS;
        const uint32_t x = (uint32_t)r.x0 + pixel % width, y = (uint32_t)r.y0 + pixel / width;
        const uint32_t there = (y * SIDE + x) * MIXED_SLOTS + place % MIXED_SLOTS;
        uint32_t i = 0;
        while (i < all->count && all->words[i] != there) i++;
        if (i == all->count) fail_msg("(%u, %u) is mixed only in a tile", x, y);
        for (uint32_t v = 0; v < all->values; v++)
            assert_memory_equal(sparse_list_numbers(tile->mixed, v) + e,
                                sparse_list_numbers(all, v) + i, sizeof(float));
    }
    return tile->mixed->count;
}

TEST(tiles_do_not_matter)
{
    static const int32_t sides[] = {4, 8, 12, 11, 17, 31};
    struct scene_fixture *f = fixture_new();
    const struct plan p = panel_plan(f, 4);
    struct traced all = trace_all(f, &p);
    assert_non_null(all.samples->mixed);
    for (size_t i = 0; i < sizeof sides / sizeof sides[0]; i++) {
        uint32_t entries = 0;
        for (int32_t y = 0; y < SIDE; y += sides[i])
            for (int32_t x = 0; x < SIDE; x += sides[i]) {
                const struct rect r =
                    rect_intersect((struct rect){x, y, x + sides[i], y + sides[i]}, whole);
                struct traced t = trace(f, &p, r);
                entries += expect_same(t.samples, r, all.samples->mixed);
                traced_fini(&t);
            }
        assert_int_equal(entries, all.samples->mixed->count);
    }
    traced_fini(&all);
    free(f);
}

/* Paths have no sub-samples, and know what covers a pixel: the list is of the pixels that centres
 * find, whatever a tile begins with, and of the rays of geometry none is traced. */
TEST(centres_find_mixed_pixels_of_paths)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 4);
    struct traced fields = trace_all(f, &p);
    paths_only(&p);
    struct traced paths = trace_all(f, &p);
    const struct sparse_list *list = paths.samples->mixed, *all = fields.samples->mixed;
    uint32_t own = 0, entries = 0;
    for (uint32_t e = 0; e < all->count; e++) own += all->words[e] % MIXED_SLOTS == MIXED_SLOT_OWN;
    assert_int_equal(list->count, own);
    for (uint32_t e = 0; e < list->count; e++) {
        assert_int_equal(list->words[e] % MIXED_SLOTS, MIXED_SLOT_OWN);
        assert_true(sparse_list_numbers(list, MIXED_SHARE)[e] == 0.0f);
    }
    assert_int_equal(count(&paths, COUNTER_RAYS_ANTIALIAS), 0);
    for (int32_t x = 0; x < SIDE; x += 8) {
        const struct rect r = {x, 0, x + 8, SIDE};
        struct traced t = trace(f, &p, r);
        entries += expect_same(t.samples, r, list);
        traced_fini(&t);
    }
    assert_int_equal(entries, list->count);
    traced_fini(&paths);
    traced_fini(&fields);
    free(f);
}

/* How many entries pixels of a column have. */
static uint32_t count_entries(const struct traced *t, uint32_t column)
{
    const struct sparse_list *list = t->samples->mixed;
    uint32_t entries = 0;
    for (uint32_t e = 0; list && e < list->count; e++)
        entries += list->words[e] / MIXED_SLOTS % SIDE == column;
    return entries;
}

/* A strip beside an edge, 3/10 of a pixel wide, that no pixel's centre shows. It is black to
 * diffuse light, which is all that fields bring; along paths beside them comes light of other
 * lobes, too, and the pixels are left to these. */
TEST(black_strips_are_left_to_paths)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 4);
    f->instance_count = 1;
    add_panel(f, fixture_material(f, 0.75f, 0.25f, 0.5f), 11.3f, 0.0f);
    fixture_panel(f, fixture_material(f, 0.0f, 0.0f, 0.0f), (float[]){-0.1328f, 3.0f, 0},
                  (float[]){0.0047f, 0, 0}, (float[]){0, 0, -0.6f});
    struct traced fields = trace_all(f, &p);
    assert_true(count_entries(&fields, 11) >= 2 * SIDE);
    traced_fini(&fields);
    paths_only(&p);
    p.paths.without_diffuse_direct = DIRECT_LEFT_LISTED;
    struct traced paths = trace_all(f, &p);
    assert_int_equal(count_entries(&paths, 11), 0);
    assert_true(count_entries(&paths, 10) >= SIDE);
    traced_fini(&paths);
    free(f);
}

TEST(plain_surfaces_have_none)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = panel_plan(f, 4);
    f->instance_count = 1; /* the floor alone */
    struct traced t = trace_all(f, &p);
    assert_null(t.samples->mixed);
    traced_fini(&t);
    free(f);
}

/* Nothing else changes with the list. */
TEST(planes_stay_as_they_are)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 4);
    struct traced with = trace_all(f, &p);
    p.planes &= ~PLANE_BIT(MIXED);
    struct traced without = trace_all(f, &p);
    assert_null(without.samples->mixed);
    assert_int_equal(with.samples->layout.total_bytes, without.samples->layout.total_bytes);
    assert_memory_equal(with.samples->data, without.samples->data,
                        with.samples->layout.total_bytes);
    assert_true(count(&with, COUNTER_RAYS_ANTIALIAS) >
                count(&without, COUNTER_RAYS_ANTIALIAS) + 16u * SIDE);
    traced_fini(&with);
    traced_fini(&without);
    free(f);
}

/* A strip that no pixel's centre shows has light of its own: its pixels keep their samples. */
TEST(narrow_things_are_left)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 4);
    f->instance_count = 1;
    fixture_panel(f, fixture_material(f, 0.5f, 0.5f, 0.5f), (float[]){-0.005f, 2.0f, 0},
                  (float[]){0.004f, 0, 0}, (float[]){0, 0, -0.9f});
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->mixed;
    for (uint32_t e = 0; list && e < list->count; e++) {
        const uint32_t x = list->words[e] / MIXED_SLOTS % SIDE;
        const uint32_t y = list->words[e] / MIXED_SLOTS / SIDE;
        assert_true(x != 15 || y < 3 || y > 28);
    }
    traced_fini(&t);
    free(f);
}

/* A lamp covers a twentieth of a column of pixels that begins with a block: no sample of the
 * blocks may meet it, but what its neighbours show tells. */
TEST(slivers_of_lamps_are_found)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 4, SIDE);
    const uint32_t lamp = fixture_material(f, 0.0f, 0.0f, 0.0f);
    for (int c = 0; c < 3; c++) f->materials[lamp].emission[c] = 17.0f;
    add_panel(f, lamp, 8.05f, 0.0f);
    p.sub_samples = 3;
    p.planes = PLANES_COMPARED | PLANE_BIT(ALBEDO) | PLANE_BIT(EMISSION) | PLANE_BIT(MIXED);
    p.radiance_scale = 1.0f;
    struct traced t = trace_all(f, &p);
    double sum = 0.0;
    for (int32_t y = 0; y < SIDE; y++) {
        const uint16_t seen = samples_u16(t.samples, PLANE_EMISSION, 0)[y * SIDE + 8];
        assert_true(fabs((double)half_to_float(seen) / 17.0 - 0.05) < 0.03);
        sum += (double)half_to_float(seen) / 17.0 / SIDE;
    }
    assert_true(fabs(sum - 0.05) < 0.005);
    traced_fini(&t);
    free(f);
}

/* All samples of a pattern's edge lie on one surface, and take the light of one pixel. */
TEST(edges_of_textures_are_mixed)
{
    uint8_t halves[64 * 4];
    struct scene_fixture *f = fixture_new();
    struct plan p = panel_plan(f, 8);
    f->instance_count = 1;
    memset(halves, 255, sizeof halves);
    for (int i = 32; i < 64; i++) memset(halves + 4 * i, 10, 3);
    struct scene_material *m = &f->materials[0];
    m->base_color[0] = m->base_color[1] = m->base_color[2] = 1.0f;
    m->base_color_texture.texture = fixture_texture(f, 64, 1, halves, 0); /* a texel a pixel */
    struct traced t = trace_all(f, &p);
    const struct sparse_list *list = t.samples->mixed;
    assert_non_null(list);
    assert_in_range(list->count, SIDE, 2 * SIDE);
    for (uint32_t e = 0; e < list->count; e++) {
        assert_int_equal(list->words[e] % MIXED_SLOTS, MIXED_SLOT_OWN);
        assert_true(sparse_list_numbers(list, MIXED_SHARE)[e] == 1.0f);
    }
    traced_fini(&t);
    free(f);
}
