/* Lone sub-samples: which they are. */
#include <stdlib.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "proto/surface_match.h"
#include "tests/unit/worker/trace/field/lone_strips.h"
#include "worker/shade/lanes.h"

static bool pixel_surface(const struct surface_view *view, const struct samples *s, int32_t x,
                          int32_t y, struct shown_surface *out)
{
    float n[3];
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE) return false;
    const size_t e = (size_t)(y * SIDE + x);
    const float depth = samples_f32(s, PLANE_DEPTH, 0)[e];
    if (!(depth > 0.0f)) return false;
    octahedron_unpack16(samples_u32(s, PLANE_NORMAL, 0)[e], n);
    shown_surface_init(view, (float)x + 0.5f, (float)y + 0.5f, depth, n,
                       surface_sub_id(samples_u32(s, PLANE_ID, 0)[e]), out);
    return true;
}

/* What the planes have of a sub-sample, and how much that is its own pixel's surface. False: it
 * shows none. */
static bool sub_surface(const struct plan *p, const struct surface_view *view,
                        const struct samples *s, uint32_t place, float at[2],
                        struct shown_surface *sub, float *own)
{
    const int32_t pixel = (int32_t)(place / 3), x = pixel % SIDE, y = pixel / SIDE;
    const uint32_t k = place % 3;
    struct shown_surface shown;
    float n[3];
    const uint16_t id = samples_u16(s, PLANE_SUB_ID, k)[pixel];
    if (id == 0) return false;
    const float depth = samples_f32(s, PLANE_DEPTH, 0)[pixel];
    const float relative = half_to_float(samples_u16(s, PLANE_SUB_DEPTH, k)[pixel]);
    octahedron_unpack8(samples_u16(s, PLANE_SUB_NORMAL, k)[pixel], n);
    pattern_pixel(&p->pattern, x, y, k, 3, at);
    shown_surface_init(view, (float)x + at[0], (float)y + at[1],
                       surface_sub_distance(relative, depth, p->length_unit), n, id, sub);
    *own = pixel_surface(view, s, x, y, &shown) ? surface_match(view, sub, &shown) : 0.0f;
    return true;
}

/* By the definition, without any short cut. */
static bool is_lone(const struct plan *p, const struct samples *s, uint32_t place)
{
    const int32_t pixel = (int32_t)(place / 3), x = pixel % SIDE, y = pixel / SIDE;
    struct surface_view view;
    struct shown_surface sub, shown;
    float at[2], own;
    surface_view_init(&view, p);
    if (!sub_surface(p, &view, s, place, at, &sub, &own)) return false;
    float sum = own;
    for (int32_t dy = -1; dy <= 1; dy++)
        for (int32_t dx = -1; dx <= 1; dx++)
            if ((dx || dy) && pixel_surface(&view, s, x + dx, y + dy, &shown))
                sum +=
                    (1.0f - own) * surface_share(at, dx, dy) * surface_match(&view, &sub, &shown);
    return sum < SURFACE_WEIGHT_MIN;
}

static bool is_listed(const struct sparse_list *list, uint32_t place)
{
    for (uint32_t e = 0; list && e < list->count; e++)
        if (list->words[e] == place) return true;
    return false;
}

TEST(those_that_nobody_shows_are_found)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = strips_plan(f, 0.5f);
    struct traced t = trace_all(f, &p);
    assert_non_null(t.samples->lone);
    assert_in_range(t.samples->lone->count, 100, 600);
    uint32_t shown = 0;
    for (uint32_t place = 0; place < SIDE * SIDE * 3; place++) {
        const bool lone = is_lone(&p, t.samples, place);
        if (lone != is_listed(t.samples->lone, place))
            fail_msg("sub-sample %u of pixel %u is %s", place % 3, place / 3,
                     lone ? "missing" : "no lone one");
        shown += !lone;
    }
    assert_true(shown > 0);
    assert_true(count(&t, COUNTER_RAYS_LONE) > t.samples->lone->count);
    traced_fini(&t);
    free(f);
}

/* Entries of a tile, as places in the whole picture. */
static void expect_same(const struct samples *tile, struct rect r, const struct sparse_list *all,
                        bool *found)
{
    const uint32_t width = (uint32_t)rect_width(r);
    for (uint32_t e = 0; tile->lone && e < tile->lone->count; e++) {
        const uint32_t place = tile->lone->words[e], pixel = place / 3;
        const uint32_t x = (uint32_t)r.x0 + pixel % width, y = (uint32_t)r.y0 + pixel / width;
        const uint32_t there = (y * SIDE + x) * 3 + place % 3;
        uint32_t i = 0;
        while (i < all->count && all->words[i] != there) i++;
        if (i == all->count) fail_msg("(%u, %u) is lone only in a tile", x, y);
        found[i] = true;
        for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
            for (uint32_t c = 0; c < 3; c++) {
                const float *a = lone_values(tile->lone, part, c), *b = lone_values(all, part, c);
                if (a) assert_memory_equal(a + e, b + i, sizeof *a);
            }
    }
}

/* What lies beside a tile is looked at; its borders show nowhere. */
TEST(tiles_do_not_matter)
{
    static const int32_t sides[] = {4, 8, 12, 11, 17, 31};
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    fixture_bounces(&p, 2);
    struct traced all = trace_all(f, &p);
    const struct sparse_list *list = all.samples->lone;
    assert_non_null(list);
    assert_int_equal(list->parts,
                     1u << LONE_DIRECT | 1u << LONE_INDIRECT | 1u << LONE_INDIRECT_HALF);
    for (size_t i = 0; i < sizeof sides / sizeof sides[0]; i++) {
        bool found[3 * SIDE * SIDE] = {false};
        for (int32_t y = 0; y < SIDE; y += sides[i])
            for (int32_t x = 0; x < SIDE; x += sides[i]) {
                const struct rect r =
                    rect_intersect((struct rect){x, y, x + sides[i], y + sides[i]}, whole);
                struct traced t = trace(f, &p, r);
                expect_same(t.samples, r, list, found);
                traced_fini(&t);
            }
        for (uint32_t e = 0; e < list->count; e++)
            if (!found[e])
                fail_msg("place %u is not lone in tiles of %d", list->words[e], sides[i]);
    }
    traced_fini(&all);
    free(f);
}

TEST(plain_surfaces_have_none)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    f->instance_count = 1; /* the floor alone */
    struct traced t = trace(f, &p, (struct rect){5, 6, 20, 17});
    assert_null(t.samples->lone);
    assert_int_equal(count(&t, COUNTER_RAYS_LONE), 0);
    traced_fini(&t);
    free(f);
}

/* Those that reflect nothing need no light. */
TEST(black_ones_are_left)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = strips_plan(f, 0.0f);
    struct traced t = trace_all(f, &p);
    assert_null(t.samples->lone);
    traced_fini(&t);
    free(f);
}

/* Whether a sub-sample is otherwise in `s` than it was traced: then it lies and faces as its pixel
 * does, and is that pixel's surface altogether, as it was traced, too. */
static bool is_settled(const struct plan *p, const struct samples *s, const struct samples *traced,
                       uint32_t place)
{
    const uint32_t pixel = place / 3, k = place % 3;
    const uint16_t depth = samples_u16(s, PLANE_SUB_DEPTH, k)[pixel];
    const uint16_t normal = samples_u16(s, PLANE_SUB_NORMAL, k)[pixel];
    struct surface_view view;
    struct shown_surface sub;
    float at[2], own;
    if (depth == samples_u16(traced, PLANE_SUB_DEPTH, k)[pixel] &&
        normal == samples_u16(traced, PLANE_SUB_NORMAL, k)[pixel])
        return false;
    assert_int_equal(depth, 0);
    assert_int_equal(normal, octahedron_coarsen(samples_u32(s, PLANE_NORMAL, 0)[pixel]));
    surface_view_init(&view, p);
    for (int n = 0; n < 2; n++) {
        assert_true(sub_surface(p, &view, n ? s : traced, place, at, &sub, &own));
        assert_true(own == 1.0f);
    }
    return true;
}

/* Without all planes that tell, nothing is settled. */
TEST(what_surely_shows_its_pixel_says_only_so)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    uint32_t settled = 0;
    struct traced all = trace_all(f, &p);
    p.planes &= ~(PLANE_BIT(LONE) | PLANE_BIT(SUB_ALBEDO));
    struct traced bare = trace_all(f, &p);
    for (uint32_t place = 0; place < 3 * SIDE * SIDE; place++) {
        assert_int_equal(samples_u16(all.samples, PLANE_SUB_ID, place % 3)[place / 3],
                         samples_u16(bare.samples, PLANE_SUB_ID, place % 3)[place / 3]);
        settled += is_settled(&p, all.samples, bare.samples, place);
    }
    assert_in_range(settled, SIDE * SIDE, 3 * SIDE * SIDE);
    traced_fini(&all);
    traced_fini(&bare);
    free(f);
}

/* Without the list nothing else is traced, and with it planes stay what they are. */
TEST(planes_stay_as_they_are)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    struct traced with = trace_all(f, &p);
    p.planes &= ~PLANE_BIT(LONE);
    struct traced without = trace_all(f, &p);
    assert_null(without.samples->lone);
    assert_int_equal(count(&without, COUNTER_RAYS_LONE), 0);
    assert_int_equal(with.samples->layout.total_bytes, without.samples->layout.total_bytes);
    assert_memory_equal(with.samples->data, without.samples->data,
                        with.samples->layout.total_bytes);
    for (uint32_t i = 0; i < COUNTER_COUNT; i++)
        if (i != COUNTER_RAYS_LONE && i != COUNTER_TRACE_CPU_US)
            assert_int_equal(with.counters.value[i], without.counters.value[i]);
    traced_fini(&with);
    traced_fini(&without);
    free(f);
}
