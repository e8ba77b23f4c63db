/* What lanes do with anti-aliasing rays: the bits of the functions that the coordinator reads them
 * by, on every instruction set. */
#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"

#include "proto/half.h"
#include "proto/octahedron.h"
#include "worker/trace/field/field_kernels.h"
#include "worker/trace/hit/hit_kernels.h"

static void block_anywhere(struct random *seed, struct block *b)
{
    const int32_t x = (int32_t)(random_bits(seed) % 16380u) & -LANES_ACROSS;
    const int32_t y = (int32_t)(random_bits(seed) % 16380u) & -LANES_ACROSS;
    block_init(b, x, y, 16384, 16384, (struct rect){x, y, x + 4, y + 4});
}

TEST(test_rays_go_where_the_pattern_says)
{
    struct random seed = {7};
    for (uint32_t round = 0; round < 600; round++) {
        const struct pattern p = {.seed = seed.state, .frame = round % 5};
        const uint32_t count = 1 + round % LIMIT_SUB_SAMPLES;
        struct pattern_pixels pixels;
        struct block b;
        block_anywhere(&seed, &b);
        pattern_pixels_init(&p, count, &pixels);
        for (int k = 0; k < isa_count(); k++)
            for (uint32_t ray = 0; ray < count; ray++) {
                _Alignas(LANES_ALIGN) float px[LANES], py[LANES];
                KERNELS_FOR(hit_kernels, all_isas[k])->place_subs(&pixels, &b, ray, px, py);
                for (int i = 0; i < LANES; i++) {
                    float at[2];
                    pattern_pixel(&p, b.x_px[i], b.y_px[i], ray, count, at);
                    assert_true(px[i] == (float)b.x_px[i] + at[0]);
                    assert_true(py[i] == (float)b.y_px[i] + at[1]);
                }
            }
    }
}

/* Codes that no packing makes are read as well. */
TEST(test_normals_are_read_as_they_are_packed)
{
    struct random seed = {11};
    _Alignas(LANES_ALIGN) uint32_t packed[LANES];
    for (int round = 0; round < 2000; round++) {
        for (int i = 0; i < LANES; i++) packed[i] = (uint32_t)random_bits(&seed);
        packed[3] = round % 2 ? 0x80008000u : 0;
        for (int k = 0; k < isa_count(); k++) {
            struct lanes3 n;
            KERNELS_FOR(field_kernels, all_isas[k])->unpack_normals(packed, &n);
            for (int i = 0; i < LANES; i++) {
                float expected[3];
                octahedron_unpack16(packed[i], expected);
                assert_true(n.x[i] == expected[0] && n.y[i] == expected[1]);
                assert_true(n.z[i] == expected[2]);
            }
        }
    }
}

/* Pairs of which about half match in each of the three. */
static void random_pixels(struct random *seed, struct lone_pixels *p)
{
    for (int i = 0; i < LANES; i++) {
        float n[3] = {random_unit(seed), random_unit(seed), 0.3f};
        p->normal[i] = octahedron_pack16(n);
        n[0] += 0.25f * random_unit(seed);
        p->coarse[i] = octahedron_coarsen(p->normal[i]);
        p->sub_depth[i] = 1 + (uint32_t)random_bits(seed) % 0x7bffu;
        p->sub_normal[i] = octahedron_pack8(n);
        p->id[i] = 1 + random_bits(seed) % 2;
        p->sub_id[i] = random_bits(seed) % 4 == 0 ? 0xffffu : p->id[i];
        p->depth[i] = 10.0f * random_unit(seed);
        p->distance[i] = p->depth[i] * (1.0f + 0.01f * random_unit(seed));
    }
    p->depth[2] = 0.0f;
    p->distance[5] = 0.0f;
    p->sub_normal[7] = 0x8080u;
    p->sub_id[8] = 0;
}

struct matched {
    uint32_t alike, open, settled, lanes;
};

/* What match_subs says of lane i of *p, by the functions that it stands for, and what it has made
 * of the sub-sample. */
static void check_match(const struct surface_view *view, const struct lanes_mask *kept,
                        const struct lone_pixels *p, const struct lone_pixels *now, int i,
                        struct matched *sum)
{
    float a[3], b[3];
    octahedron_unpack16(p->normal[i], a);
    octahedron_unpack8((uint16_t)p->sub_normal[i], b);
    const bool faces = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] >= SURFACE_COS_FULL;
    const bool seen = p->depth[i] > 0.0f && p->distance[i] > 0.0f;
    const bool alike = faces && seen && p->id[i] == p->sub_id[i];
    const bool own = alike && surface_near(view, p->depth[i], p->distance[i]) == SURFACE_NEAR;
    const bool shown = p->sub_id[i] != 0 && p->distance[i] > 0.0f;
    assert_int_equal(now->alike.on[i], -alike);
    assert_int_equal(now->open.on[i], kept->on[i] & -(shown && !own));
    assert_int_equal(now->sub_depth[i], own ? 0 : p->sub_depth[i]);
    assert_int_equal(now->sub_normal[i], own ? p->coarse[i] : p->sub_normal[i]);
    sum->alike += alike;
    sum->open += now->open.on[i] != 0;
    sum->settled += own;
    sum->lanes++;
}

TEST(test_matches_are_those_of_one_by_one)
{
    struct random seed = {13};
    struct matched sum = {0};
    struct lanes_mask kept;
    struct plan plan = fixture_plan(64, 48, (float[]){1, 2, 3}, 0.8f);
    for (int i = 0; i < LANES; i++) kept.on[i] = -(i != 9);
    for (int round = 0; round < 2000; round++) {
        struct surface_view view;
        struct lone_pixels p;
        plan.camera.type = (uint32_t)round % 2;
        surface_view_init(&view, &plan);
        random_pixels(&seed, &p);
        for (int k = 0; k < isa_count(); k++) {
            const struct matched before = sum;
            struct lone_pixels now = p;
            KERNELS_FOR(field_kernels, all_isas[k])->unpack_normals(now.normal, &now.facing);
            const bool any =
                KERNELS_FOR(field_kernels, all_isas[k])->match_subs(&view, &kept, &now);
            for (int i = 0; i < LANES; i++) check_match(&view, &kept, &p, &now, i, &sum);
            assert_int_equal(any, sum.open > before.open);
            assert_int_equal(now.settled, sum.settled > before.settled);
        }
    }
    assert_in_range(sum.alike, sum.lanes / 10, sum.lanes * 9 / 10);
    assert_in_range(sum.open, sum.lanes / 10, sum.lanes * 9 / 10);
}

static void random_surfaces(struct random *seed, struct surface *centre, struct surface *sub)
{
    memset(centre, 0, sizeof *centre);
    memset(sub, 0, sizeof *sub);
    for (int i = 0; i < LANES; i++) {
        centre->distance[i] = random_bits(seed) % 4 ? 5.0f * random_unit(seed) : 0.0f;
        sub->distance[i] = 5.0f * random_unit(seed);
        sub->hit.on[i] = -(int32_t)(random_bits(seed) % 4 != 0);
        sub->id[i] = random_bits(seed) % 3 ? (uint32_t)(random_bits(seed) % 9) : 0x10000u;
        sub->normal.x[i] = random_unit(seed);
        sub->normal.y[i] = sub->normal.z[i] = 0.5f;
        sub->albedo.x[i] = sub->albedo.y[i] = sub->albedo.z[i] = random_unit(seed);
    }
    sub->hit.on[1] = sub->hit.on[2] = sub->hit.on[3] = -1;
    centre->distance[1] = 4.0f;
    sub->distance[1] = 1e-5f; /* rounds to the number of a miss */
    sub->distance[2] = 1e30f; /* over the largest half */
    sub->id[3] = 0x30000u;
}

static void check_stored(const struct surface *centre, const struct surface *sub, int i,
                         float length_unit, const uint16_t stored[4])
{
    const bool hit = sub->hit.on[i];
    const float n[3] = {sub->normal.x[i], sub->normal.y[i], sub->normal.z[i]};
    const uint16_t low = (uint16_t)(sub->id[i] & 0xffffu);
    const float reference = centre->distance[i] > 0.0f ? centre->distance[i] : length_unit;
    uint16_t depth = half_from_float(sub->distance[i] / reference - 1.0f);
    if (depth == half_from_float(SUB_DEPTH_MISS)) depth--;
    assert_int_equal(stored[0], hit ? depth : half_from_float(SUB_DEPTH_MISS));
    assert_int_equal(stored[1], hit ? octahedron_pack8(n) : 0);
    assert_int_equal(stored[2], hit && low == 0 ? 0xffffu : low);
    assert_int_equal(stored[3], (uint16_t)(int32_t)(sub->albedo.x[i] * 65535.0f + 0.5f));
}

TEST(test_what_is_met_is_stored)
{
    struct random seed = {17};
    const float length_unit = 0.7f;
    const float miss = half_to_float(half_from_float(SUB_DEPTH_MISS));
    assert_true(miss == SUB_DEPTH_MISS);
    for (int round = 0; round < 1000; round++) {
        struct queries q = {.rejected = 0};
        struct surface centre, sub;
        struct block b;
        uint16_t depth[LANES], normal[LANES], id[LANES], albedo[3][LANES];
        const struct geometry_sub_planes planes = {
            depth, normal, id, {albedo[0], round % 2 ? albedo[1] : NULL, albedo[2]}};
        block_init(&b, 4, 8, 64, 64, (struct rect){4, 8, 8, 12});
        random_surfaces(&seed, &centre, &sub);
        for (int k = 0; k < isa_count(); k++) {
            q.kernels = KERNELS_FOR(hit_kernels, all_isas[k]);
            geometry_store_sub(&q, &b, length_unit, &centre, &sub, &planes);
            for (int i = 0; i < LANES; i++)
                check_stored(&centre, &sub, i, length_unit,
                             (uint16_t[]){depth[i], normal[i], id[i], albedo[0][i]});
        }
    }
}

/* Every plane of every sub-sample at its place. */
TEST(test_planes_are_looked_up_once)
{
    struct plan plan = fixture_plan(8, 8, (float[]){1, 2, 3}, 0.8f);
    struct samples_layout layout;
    struct geometry_planes planes;
    struct samples *s;
    plan.sub_samples = LIMIT_SUB_SAMPLES;
    plan.planes |= PLANE_BIT(DEPTH) | PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) |
                   PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 8, 8), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    geometry_planes_init(&planes, s);
    for (uint32_t k = 0; k < LIMIT_SUB_SAMPLES; k++) {
        assert_non_null(planes.sub[k].depth);
        assert_ptr_equal(planes.sub[k].depth, samples_u16(s, PLANE_SUB_DEPTH, k));
        assert_ptr_equal(planes.sub[k].normal, samples_u16(s, PLANE_SUB_NORMAL, k));
        assert_ptr_equal(planes.sub[k].id, samples_u16(s, PLANE_SUB_ID, k));
        for (uint32_t c = 0; c < 3; c++)
            assert_ptr_equal(planes.sub[k].albedo[c], samples_u16(s, PLANE_SUB_ALBEDO, 3 * k + c));
    }
    samples_destroy(&s);
}
