/* Sample buffers: sizes as promised, every way of packing comes back. */
#include "tests/unit/proto/golden.h"
#include "tests/unit/proto/samples_packed.h"

/* One rectangle light at 9 samples, one bounce, as the size formula of samples.h counts. */
static void plan_of_formula(uint64_t without)
{
    plan_case(&plan);
    plan.lights[0] = plan.lights[3];
    plan.light_count = 1;
    plan.planes &= ~(without | PLANES_PATH_ALL);
    if (!(plan.planes & PLANES_LENS)) plan.lens_strata_per_axis = 0;
    if (!(plan.planes & PLANES_LENS_SURFACE)) plan.lens_relight = LENS_RELIGHT_OWN;
    plan.shadow_filter = SHADOW_FILTER_SHEARED;
}

static uint32_t bytes_per_pixel(uint64_t without)
{
    struct samples_layout layout;
    plan_of_formula(without);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 32, 32), 0);
    assert_int_equal(layout.group_bytes[0] + layout.group_bytes[1] + layout.group_bytes[2],
                     layout.total_bytes);
    return layout.total_bytes / (32 * 32);
}

TEST(sizes_follow_the_formula)
{
    const uint64_t spare = BIT(EMISSION) | BIT(INDIRECT_MEAN) | BIT(AMBIENT_VISIBILITY) |
                           BIT(BOUNCE_DISTANCE_MAX) | PLANES_GLOSSY | PLANES_LENS |
                           BIT(GLOSSY_SPAN) | PLANES_MATTE | BIT(AMBIENT_DISTANCE_MIN);
    assert_int_equal(bytes_per_pixel(spare | BIT(INDIRECT_STRATA)), 76);
    assert_int_equal(bytes_per_pixel(spare | BIT(INDIRECT_HALVES)), 136);
    assert_true(bytes_per_pixel(spare | BIT(INDIRECT_STRATA)) < 80);
    assert_true(bytes_per_pixel(spare | BIT(INDIRECT_HALVES)) < 160);
    assert_int_equal(bytes_per_pixel(spare | BIT(INDIRECT_STRATA) | BIT(BOUNCE_DISTANCE_MIN)), 74);
    const uint64_t others = spare & ~PLANES_GLOSSY;
    assert_int_equal(bytes_per_pixel(others | BIT(INDIRECT_STRATA)),
                     76 + 8 + 8 + 8 + 2 + 4 + 2 + 3 * 6);
    assert_int_equal(bytes_per_pixel((spare & ~PLANES_MATTE) | BIT(INDIRECT_STRATA)), 76 + 2 * 36);
    /* four lens samples, lit by their own paths or by fields */
    const uint64_t lensless = spare & ~PLANES_LENS, surface = PLANES_LENS_SURFACE;
    assert_int_equal(bytes_per_pixel(lensless | surface | BIT(INDIRECT_STRATA)), 76 + 14 * 4 + 2);
    assert_int_equal(bytes_per_pixel(lensless | BIT(INDIRECT_STRATA)), 76 + 26 * 4 + 2);
    plan.planes |= BIT(LENS_LOBE);
    struct samples_layout lobes;
    assert_int_equal(samples_layout_init(&lobes, &plan, 0, 32, 32), 0);
    assert_int_equal(lobes.total_bytes, (76 + 30 * 4 + 2) * 32 * 32);
}

TEST(later_passes_hold_paths_alone)
{
    struct samples_layout layout;
    plan_case(&plan);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 32, 32), 0);
    assert_int_equal(layout.planes, PLANES_PATH_ALL);
    assert_int_equal(layout.total_bytes / (32 * 32), 176);
    assert_int_equal(layout.offset[PLANE_DEPTH], SAMPLES_ABSENT);
    for (uint32_t k = 0; k < 4; k++) assert_int_equal(layout.light_planes[k], 0);
    plan.planes &= ~BIT(PATH_M2);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 32, 32), 0);
    assert_int_equal(layout.total_bytes / (32 * 32), 164);
}

TEST(layouts_do_not_overlap)
{
    struct samples_layout layout;
    plan_case(&plan);
    plan.planes |= BIT(LENS_SECOND_SET) | BIT(LENS_LOBE);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 5, 3), 0);
    uint64_t sum = 0;
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++) {
        assert_true(layout.offset[p] < layout.total_bytes);
        for (uint32_t q = 0; q < p; q++) assert_true(layout.offset[p] != layout.offset[q]);
        sum += layout.offset[p];
    }
    assert_true(sum > 0);
    for (uint32_t k = 0; k < 3; k++)
        assert_int_equal(layout.offset[samples_light_slot(k, LIGHT_PLANE_SLOPES)], SAMPLES_ABSENT);
    assert_true(layout.offset[samples_light_slot(3, LIGHT_PLANE_SLOPES)] < layout.total_bytes);
}

TEST(large_layouts_are_refused)
{
    struct samples_layout layout;
    plan_case(&plan);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 0, 8), ERR_LIMIT);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 8, LIMIT_TILE_SIDE_PX + 1), ERR_LIMIT);
    plan.indirect_strata_per_axis = 16;
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 256, 256), ERR_LIMIT);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 128, 128), 0);
}

#define ANY UINT64_MAX /* small tiles may be zero by chance */

static void round_trip(struct samples *s, uint64_t expected_dropped)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    uint64_t dropped = 99;
    pack(s, &w, &dropped);
    if (expected_dropped != ANY) assert_int_equal(dropped, expected_dropped);
    if (unpack(w.data, w.size_bytes, s->layout.width_px, s->layout.height_px, &back, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_int_equal(back->layout.total_bytes, s->layout.total_bytes);
    assert_memory_equal(back->data, s->data, s->layout.total_bytes);
    assert_memory_equal(&back->layout, &s->layout, sizeof s->layout);
    samples_destroy(&back);
    assert_null(back);
    bytes_writer_fini(&w);
}

TEST(planes_round_trip)
{
    plan_case(&plan);
    plan.planes |= BIT(LENS_SECOND_SET) | BIT(LENS_LOBE);
    for (size_t i = 0; i < SIZES; i++) {
        struct samples *s = create(sizes[i][0], sizes[i][1]);
        samples_case_fill(s, UINT64_MAX, 15, i);
        round_trip(s, i == 0 ? ANY : 0);
        samples_destroy(&s);
    }
}

/* All sets of the light field's planes, each with some set of the paths'. */
#define LIGHT_FIELD_SETS PLANE_BIT(PATH_RADIANCE)

static uint64_t some_set(uint32_t i)
{
    return (i | i * UINT64_C(0x9e3779b97f4a7c15) << PLANE_PATH_RADIANCE) & PLAN_CASE_PLANES;
}

/* Planes that the buffer has but that hold nothing are left out on the way. */
TEST(every_set_of_filled_planes_round_trips)
{
    plan_case(&plan);
    plan.planes |= BIT(LENS_SECOND_SET) | BIT(LENS_LOBE);
    for (uint32_t i = 0; i < LIGHT_FIELD_SETS; i++) {
        const uint64_t planes = some_set(i);
        struct samples *s = create(7, 3);
        samples_case_fill(s, planes, (uint32_t)planes, planes);
        uint64_t dropped = (uint64_t)__builtin_popcountll(s->layout.planes & ~planes);
        for (uint32_t k = 0; k < 4; k++)
            if (!(planes >> k & 1)) dropped += k == 3 ? LIGHT_PLANE_COUNT : 1;
        round_trip(s, dropped);
        samples_destroy(&s);
    }
}

/* Any plan: what it does not ask for has no place. */
TEST(every_set_of_planned_planes_round_trips)
{
    for (uint32_t i = 0; i < LIGHT_FIELD_SETS; i++) {
        const uint64_t planes = some_set(i);
        plan_case(&plan);
        plan.planes = planes;
        plan.light_planes = (uint32_t)planes & PLAN_CASE_LIGHT_PLANES;
        plan.light_count = (uint32_t)(planes % 5);
        struct samples *s = create(5, 4);
        for (uint32_t p = 0; p < PLANE_ID_COUNT; p++)
            assert_true((s->layout.offset[p] == SAMPLES_ABSENT) == !(planes >> p & 1));
        samples_case_fill(s, UINT64_MAX, 15, planes);
        round_trip(s, 0);
        samples_destroy(&s);
    }
}

TEST(later_passes_round_trip)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    plan_case(&plan);
    struct samples *s = create_pass(2, 7, 3);
    samples_case_fill(s, UINT64_MAX, 0, 4);
    pack(s, &w, NULL);
    assert_int_equal(unpack_pass(w.data, w.size_bytes, 1, 7, 3, &back, &fault), 0);
    assert_memory_equal(&back->layout, &s->layout, sizeof s->layout);
    assert_memory_equal(back->data, s->data, s->layout.total_bytes);
    samples_destroy(&back);
    samples_destroy(&s);
    bytes_writer_fini(&w);
    s = create(7, 3); /* the planes of the first pass have no place in another */
    samples_case_fill(s, BIT(ID), 0, 4);
    pack(s, &w, NULL);
    assert_int_equal(unpack_pass(w.data, w.size_bytes, 1, 7, 3, &back, &fault), ERR_RANGE);
    samples_destroy(&s);
    bytes_writer_fini(&w);
}

TEST(absent_planes_have_no_address)
{
    plan_case(&plan);
    plan.planes = plan.light_planes = 0;
    struct samples *s = create(8, 8);
    assert_int_equal(s->layout.total_bytes, 0);
    assert_null(samples_f32(s, PLANE_DEPTH, 0));
    assert_null(samples_u32(s, PLANE_ID, 0));
    assert_null(samples_u16(s, PLANE_ALBEDO, 2));
    assert_null(samples_light_irradiance(s, 0));
    assert_null(samples_light_visibility(s, 3, 1));
    assert_null(samples_light_slope(s, 3, 1));
    samples_destroy(&s);
    samples_destroy(&s);
}

TEST(quiet_planes_compress)
{
    struct bytes_writer w;
    plan_of_formula(0);
    struct samples *s = create(64, 64);
    for (size_t i = 0; i < 64 * 64; i++) samples_f32(s, PLANE_DEPTH, 0)[i] = 3.0f;
    pack(s, &w, NULL);
    assert_true(w.size_bytes < 500);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* Surplus bits of the last visibility byte mean nothing and must not reach the coordinator. */
TEST(surplus_bits_are_cleared)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault;
    plan_of_formula(0);
    struct samples *s = create(7, 3);
    memset(samples_light_visibility(s, 0, 0), 0xff, 7 * 3 * 2);
    pack(s, &w, NULL);
    assert_int_equal(unpack(w.data, w.size_bytes, 7, 3, &back, &fault), 0);
    assert_int_equal(samples_light_visibility(back, 0, 0)[20], 0xff);
    assert_int_equal(samples_light_visibility(back, 0, 1)[20], 0x01);
    samples_destroy(&back);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* The compressor's bytes are a library's; what unpacks from old bytes must stay. */
TEST(bytes_are_golden)
{
    static uint8_t packed[1 << 16];
    struct bytes_writer w;
    struct samples *s, *back;
    struct fault fault = {0};
    plan_case(&plan);
    s = create(7, 3);
    samples_case_fill(s, 0x1fef | BIT(PATH_RADIANCE) | BIT(PATH_COVERAGE), 13, 42);
    pack(s, &w, NULL);
    golden_check(packing == PACKING_SMALL ? "tests/golden/wire/samples_small.bin"
                                          : "tests/golden/wire/samples.bin",
                 w.data, w.size_bytes);
    memcpy(packed, w.data, w.size_bytes);
    assert_int_equal(unpack(packed, w.size_bytes, 7, 3, &back, &fault), 0);
    assert_memory_equal(back->data, s->data, s->layout.total_bytes);
    samples_destroy(&back);
    samples_destroy(&s);
    bytes_writer_fini(&w);
}

/* Runs all tests for both ways of packing. */
int main(void)
{
    int failed = unit_run("samples, quick");
    packing = PACKING_SMALL;
    failed += unit_run("samples, small");
    return failed;
}
