/* Sample buffers: sizes as promised, every way of packing comes back, damage is refused. */
#include <math.h>

#include "proto/plane_filter.h"
#include "tests/unit/proto/golden.h"
#include "tests/unit/proto/samples_case.h"
#include "tests/unit/unit.h"

static struct plan plan;
static enum packing packing = PACKING_QUICK; /* all is tried with each */
static const int32_t sizes[][2] = {{1, 1}, {7, 3}, {64, 64}, {33, 1}, {1, 19}};
#define SIZES (sizeof sizes / sizeof sizes[0])

#define BIT(plane) PLANE_BIT(plane)

/* One rectangle light at 9 samples, one bounce, as the size formula of samples.h counts. */
static void plan_of_formula(uint64_t without)
{
    plan_case(&plan);
    plan.lights[0] = plan.lights[3];
    plan.light_count = 1;
    plan.planes &= ~(without | PLANES_PATH_ALL);
    if (!(plan.planes & PLANES_LENS)) plan.lens_strata_per_axis = 0;
    if (!(plan.planes & PLANES_LENS_SURFACE)) plan.lens_light = LENS_LIGHT_OWN;
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
    const uint64_t spare = BIT(EMISSION) | BIT(INDIRECT_MEAN) | BIT(OPEN) | BIT(REFLECTOR_FAR) |
                           PLANES_GLOSSY | PLANES_LENS | BIT(GLOSSY_SPAN);
    assert_int_equal(bytes_per_pixel(spare | BIT(INDIRECT_STRATA)), 74);
    assert_int_equal(bytes_per_pixel(spare | BIT(INDIRECT_HALVES)), 134);
    assert_true(bytes_per_pixel(spare | BIT(INDIRECT_STRATA)) < 80);
    assert_true(bytes_per_pixel(spare | BIT(INDIRECT_HALVES)) < 160);
    assert_int_equal(bytes_per_pixel(spare | BIT(INDIRECT_STRATA) | BIT(REFLECTOR)), 72);
    const uint64_t others = spare & ~PLANES_GLOSSY;
    assert_int_equal(bytes_per_pixel(others | BIT(INDIRECT_STRATA)), 74 + 8 + 8 + 8 + 2 + 3 * 6);
    /* four lens samples, lit by their own paths or by fields */
    const uint64_t lensless = spare & ~PLANES_LENS, surface = PLANES_LENS_SURFACE;
    assert_int_equal(bytes_per_pixel(lensless | surface | BIT(INDIRECT_STRATA)), 74 + 14 * 4 + 2);
    assert_int_equal(bytes_per_pixel(lensless | BIT(INDIRECT_STRATA)), 74 + 26 * 4 + 2);
    plan.planes |= BIT(LENS_LOBE);
    struct samples_layout lobes;
    assert_int_equal(samples_layout_init(&lobes, &plan, 0, 32, 32), 0);
    assert_int_equal(lobes.total_bytes, (74 + 30 * 4 + 2) * 32 * 32);
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
    plan.planes &= ~BIT(PATH_SPREAD);
    assert_int_equal(samples_layout_init(&layout, &plan, 1, 32, 32), 0);
    assert_int_equal(layout.total_bytes / (32 * 32), 164);
}

TEST(layouts_do_not_overlap)
{
    struct samples_layout layout;
    plan_case(&plan);
    plan.planes |= BIT(LENS_MORE) | BIT(LENS_LOBE);
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

static struct samples *create_pass(uint32_t pass, int32_t width, int32_t height)
{
    struct samples_layout layout;
    struct samples *s;
    assert_int_equal(samples_layout_init(&layout, &plan, pass, width, height), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    assert_int_equal((uintptr_t)s->data % 64, 0);
    return s;
}

static struct samples *create(int32_t width, int32_t height)
{
    return create_pass(0, width, height);
}

static void pack(struct samples *s, struct bytes_writer *w, uint64_t *dropped)
{
    bytes_writer_init(w);
    assert_int_equal(samples_pack(s, packing, w, dropped), 0);
    assert_false(w->failed);
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static int unpack_pass(const uint8_t *data, size_t size_bytes, uint32_t pass, int32_t width,
                       int32_t height, struct samples **out, struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    *out = NULL;
    const int error = samples_unpack(exact, size_bytes, &plan, pass, width, height, out, fault);
    assert_true((error == 0) == (*out != NULL));
    free(exact);
    return error;
}

static int unpack(const uint8_t *data, size_t size_bytes, int32_t width, int32_t height,
                  struct samples **out, struct fault *fault)
{
    return unpack_pass(data, size_bytes, 0, width, height, out, fault);
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
    plan.planes |= BIT(LENS_MORE) | BIT(LENS_LOBE);
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
    plan.planes |= BIT(LENS_MORE) | BIT(LENS_LOBE);
    for (uint32_t i = 0; i < LIGHT_FIELD_SETS; i++) {
        const uint64_t planes = some_set(i);
        struct samples *s = create(7, 3);
        samples_case_fill(s, planes, (uint32_t)planes, planes);
        uint64_t dropped = (uint64_t)__builtin_popcountll(s->layout.planes & ~planes);
        for (uint32_t k = 0; k < 4; k++)
            if (!(planes >> k & 1)) dropped += k == 3 ? 3 : 1;
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

TEST(cut_samples_fail)
{
    struct bytes_writer w;
    struct samples *s, *back;
    struct fault fault;
    plan_case(&plan);
    for (size_t i = 0; i < 2; i++) {
        s = create(sizes[i][0] + 8, sizes[i][1]);
        samples_case_fill(s, UINT64_MAX, 15, i);
        pack(s, &w, NULL);
        for (size_t size_bytes = 0; size_bytes < w.size_bytes; size_bytes++)
            assert_int_equal(
                unpack(w.data, size_bytes, sizes[i][0] + 8, sizes[i][1], &back, &fault),
                ERR_TRUNCATED);
        bytes_write_u8(&w, 0);
        assert_int_equal(unpack(w.data, w.size_bytes, sizes[i][0] + 8, sizes[i][1], &back, &fault),
                         ERR_TRAILING);
        bytes_writer_fini(&w);
        samples_destroy(&s);
    }
}

TEST(foreign_sizes_and_planes_fail)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault;
    plan_case(&plan);
    struct samples *s = create(8, 8);
    samples_case_fill(s, UINT64_MAX, 15, 1);
    pack(s, &w, NULL);
    assert_int_equal(unpack(w.data, w.size_bytes, 8, 7, &back, &fault), ERR_MISMATCH);
    plan.planes &= ~BIT(REFLECTOR);
    assert_int_equal(unpack(w.data, w.size_bytes, 8, 8, &back, &fault), ERR_RANGE);
    plan.planes |= BIT(REFLECTOR);
    w.data[12 + 0] |= 1u << LIGHT_PLANE_SLOPES; /* of a point light */
    assert_int_equal(unpack(w.data, w.size_bytes, 8, 8, &back, &fault), ERR_RANGE);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* Of a tile with depth alone: where its filter is said, and where its blosc buffer begins. */
enum { FILTER = 12, BUFFER = FILTER + 1 + 4 };

TEST(filters_that_there_are_not_fail)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault;
    plan_case(&plan);
    plan.light_count = 0;
    plan.planes = BIT(DEPTH);
    struct samples *s = create(64, 64);
    for (size_t i = 0; i < 64 * 64; i++) samples_f32(s, PLANE_DEPTH, 0)[i] = 1.0f + (float)(i / 64);
    pack(s, &w, NULL);
    assert_int_equal(w.data[FILTER] != PLANE_FILTER_NONE, packing == PACKING_SMALL);
    for (unsigned filter = PLANE_FILTER_COUNT; filter <= 255; filter++) {
        w.data[FILTER] = (uint8_t)filter;
        assert_int_equal(unpack(w.data, w.size_bytes, 64, 64, &back, &fault), ERR_CORRUPT);
        assert_string_equal(fault.pointer, "group 4");
        assert_non_null(strstr(fault.detail, "component 0"));
    }
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* A group that declares sizes of its own: none may decide what is allocated or written. */
TEST(declared_sizes_are_not_believed)
{
    static const uint32_t declared[] = {0, 15, 16, 1000, 0x7fffffff, 0xffffffff};
    struct bytes_writer w;
    struct samples *back;
    struct fault fault;
    plan_case(&plan);
    plan.light_count = 0;
    plan.planes = BIT(DEPTH);
    struct samples *s = create(64, 64);
    for (size_t i = 0; i < 64 * 64; i++) samples_f32(s, PLANE_DEPTH, 0)[i] = (float)(i / 64);
    pack(s, &w, NULL);
    assert_true(w.size_bytes < 64 * 64 * 4);
    for (size_t field = BUFFER + 4; field <= BUFFER + 12; field += 4)
        for (size_t i = 0; i < sizeof declared / sizeof declared[0]; i++) {
            uint8_t kept[4];
            memcpy(kept, w.data + field, 4); /* blosc: size, block size, packed size */
            memcpy(w.data + field, &declared[i], 4);
            assert_int_equal(unpack(w.data, w.size_bytes, 64, 64, &back, &fault), ERR_CORRUPT);
            assert_string_equal(fault.pointer, "group 4");
            memcpy(w.data + field, kept, 4);
        }
    memset(w.data + BUFFER - 4, 0xff, 4); /* the group's own size */
    assert_int_equal(unpack(w.data, w.size_bytes, 64, 64, &back, &fault), ERR_TRUNCATED);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* Damaged bytes are refused or unpack to numbers that are still allowed. */
TEST(damage_does_no_harm)
{
    struct bytes_writer w;
    uint64_t random = 5;
    uint32_t refused = 0;
    plan_case(&plan);
    struct samples *s = create(24, 16);
    samples_case_fill(s, 0x1f0f, 15, 3);
    pack(s, &w, NULL);
    for (int i = 0; i < 4000; i++) {
        struct samples *back;
        struct fault fault;
        const size_t at = samples_case_random(&random) % w.size_bytes;
        const uint8_t flip = (uint8_t)(1 + samples_case_random(&random) % 255);
        w.data[at] ^= flip;
        refused += unpack(w.data, w.size_bytes, 24, 16, &back, &fault) != 0;
        samples_destroy(&back);
        w.data[at] ^= flip;
    }
    assert_in_range(refused, 100, 3999);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* Changes one number in a filled buffer and expects a fault at its plane and pixel (3, 2). */
#define EXPECT(change, expected, place)                                                            \
    do {                                                                                           \
        const size_t at = 2 * 7 + 3;                                                               \
        struct bytes_writer w;                                                                     \
        struct samples *s, *back;                                                                  \
        struct fault fault = {0};                                                                  \
        plan_case(&plan);                                                                          \
        plan.planes |= BIT(LENS_MORE);                                                             \
        s = create(7, 3);                                                                          \
        samples_case_fill(s, UINT64_MAX, 15, 1);                                                   \
        change;                                                                                    \
        pack(s, &w, NULL);                                                                         \
        const int error = unpack(w.data, w.size_bytes, 7, 3, &back, &fault);                       \
        if (error != (expected) || strcmp(fault.pointer, place) != 0)                              \
            fail_msg(#change " gives %s at \"%s\": %s", error_name(error), fault.pointer,          \
                     fault.detail);                                                                \
        if (expected) assert_non_null(strstr(fault.detail, "(3, 2)"));                             \
        samples_destroy(&back);                                                                    \
        bytes_writer_fini(&w);                                                                     \
        samples_destroy(&s);                                                                       \
    } while (0)

#define HALF_NAN        0x7e00
#define HALF_INFINITE   0x7c00
#define HALF_NEGATIVE   0x8001
#define HALF_MINUS_ZERO 0x8000

TEST(numbers_are_checked)
{
    EXPECT(samples_f32(s, PLANE_DEPTH, 0)[at] = NAN, ERR_NOT_FINITE, "depth[0]");
    EXPECT(samples_f32(s, PLANE_DEPTH, 0)[at] = INFINITY, ERR_NOT_FINITE, "depth[0]");
    EXPECT(samples_f32(s, PLANE_DEPTH, 0)[at] = -1, ERR_RANGE, "depth[0]");
    EXPECT(samples_u32(s, PLANE_ID, 0)[at] = LIMIT_INSTANCES + 1, ERR_RANGE, "id[0]");
    EXPECT(samples_u16(s, PLANE_SUB_DEPTH, 2)[at] = 0xbc01, ERR_RANGE, "sub_depth[2]");
    EXPECT(samples_u16(s, PLANE_SUB_DEPTH, 1)[at] = HALF_NAN, ERR_NOT_FINITE, "sub_depth[1]");
    EXPECT(samples_u16(s, PLANE_EMISSION, 1)[at] = HALF_NEGATIVE, ERR_RANGE, "emission[1]");
    EXPECT(samples_u16(s, PLANE_EMISSION, 1)[at] = HALF_MINUS_ZERO, ERR_OK, "");
    EXPECT(samples_u16(s, PLANE_INDIRECT_MEAN, 2)[at] = HALF_INFINITE, ERR_NOT_FINITE,
           "indirect_mean[2]");
    EXPECT(samples_u16(s, PLANE_INDIRECT_HALVES, 5)[at] = HALF_NAN, ERR_NOT_FINITE,
           "indirect_halves[5]");
    EXPECT(samples_u16(s, PLANE_REFLECTOR, 0)[at] = 0xfc00, ERR_NOT_FINITE, "reflector[0]");
    EXPECT(samples_u16(s, PLANE_INDIRECT_STRATA, 35)[at] = 0xffff, ERR_NOT_FINITE,
           "indirect_strata[35]");
    EXPECT(samples_f32(s, PLANE_PATH_RADIANCE, 2)[at] = NAN, ERR_NOT_FINITE, "path_radiance[2]");
    EXPECT(samples_f32(s, PLANE_PATH_SPREAD, 1)[at] = -1e-30f, ERR_RANGE, "path_spread[1]");
    EXPECT(samples_f32(s, PLANE_PATH_OCCLUSION, 0)[at] = -INFINITY, ERR_NOT_FINITE,
           "path_occlusion[0]");
    EXPECT(samples_f32(s, PLANE_LENS_RADIANCE, 11)[at] = -1.0f, ERR_RANGE, "lens_radiance[11]");
    EXPECT(samples_f32(s, PLANE_LENS_RADIANCE, 3)[at] = NAN, ERR_NOT_FINITE, "lens_radiance[3]");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 3)[at] = HALF_NEGATIVE, ERR_OK, "");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 3)[at] = 0xfbff, ERR_OK, "");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 3)[at] = 0xfc00, ERR_NOT_FINITE, "lens_slope[3]");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 0)[at] = HALF_NAN, ERR_NOT_FINITE, "lens_slope[0]");
    EXPECT(samples_u16(s, PLANE_LENS_DEPTH, 3)[at] = 0xfc00, ERR_NOT_FINITE, "lens_depth[3]");
    EXPECT(samples_u32(s, PLANE_LENS_ALBEDO, 3)[at] = UINT32_MAX, ERR_OK, "");
    EXPECT(samples_u32(s, PLANE_LENS_LIGHT, 3)[at] = 0xf5ffffffu, ERR_OK, "");
    EXPECT(samples_u32(s, PLANE_LENS_LIGHT, 3)[at] = 0xf6000000u, ERR_RANGE, "lens_light[3]");
    EXPECT(samples_u16(s, PLANE_LENS_COVERAGE, 0)[at] = HALF_NEGATIVE, ERR_RANGE,
           "lens_coverage[0]");
    EXPECT(samples_f32(s, PLANE_LENS_MORE, 3)[at] = -1.0f, ERR_RANGE, "lens_more[3]");
    EXPECT(samples_f32(s, PLANE_LENS_MORE, 0)[at] = NAN, ERR_NOT_FINITE, "lens_more[0]");
    EXPECT(samples_light_irradiance(s, 2)[at] = NAN, ERR_NOT_FINITE, "lights[2].irradiance");
    EXPECT(samples_light_irradiance(s, 2)[at] = -1e-30f, ERR_RANGE, "lights[2].irradiance");
    EXPECT(samples_light_slope(s, 3, 0)[at] = HALF_NEGATIVE, ERR_RANGE, "lights[3].slopes");
    EXPECT(samples_light_slope(s, 3, 1)[at] = HALF_INFINITE, ERR_NOT_FINITE, "lights[3].slopes");
    EXPECT((samples_light_slope(s, 3, 0)[at] = 2, samples_light_slope(s, 3, 1)[at] = 1), ERR_RANGE,
           "lights[3].slopes");
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
