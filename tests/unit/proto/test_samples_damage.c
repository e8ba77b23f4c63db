/* Damaged sample buffers are refused, whatever is damaged. */
#include <math.h>

#include "proto/plane_filter.h"
#include "tests/unit/proto/samples_packed.h"

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
    plan.planes &= ~BIT(BOUNCE_DISTANCE_MIN);
    assert_int_equal(unpack(w.data, w.size_bytes, 8, 8, &back, &fault), ERR_RANGE);
    plan.planes |= BIT(BOUNCE_DISTANCE_MIN);
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
        plan.planes |= BIT(LENS_SECOND_SET);                                                       \
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
    EXPECT(samples_u16(s, PLANE_BOUNCE_DISTANCE_MIN, 0)[at] = 0xfc00, ERR_NOT_FINITE,
           "bounce_distance_min[0]");
    EXPECT(samples_u16(s, PLANE_INDIRECT_STRATA, 35)[at] = 0xffff, ERR_NOT_FINITE,
           "indirect_strata[35]");
    EXPECT(samples_f32(s, PLANE_PATH_RADIANCE, 2)[at] = NAN, ERR_NOT_FINITE, "path_radiance[2]");
    EXPECT(samples_f32(s, PLANE_PATH_M2, 1)[at] = -1e-30f, ERR_RANGE, "path_m2[1]");
    EXPECT(samples_f32(s, PLANE_PATH_VISIBILITY, 0)[at] = -INFINITY, ERR_NOT_FINITE,
           "path_visibility[0]");
    EXPECT(samples_f32(s, PLANE_LENS_RADIANCE, 11)[at] = -1.0f, ERR_RANGE, "lens_radiance[11]");
    EXPECT(samples_f32(s, PLANE_LENS_RADIANCE, 3)[at] = NAN, ERR_NOT_FINITE, "lens_radiance[3]");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 3)[at] = HALF_NEGATIVE, ERR_OK, "");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 3)[at] = 0xfbff, ERR_OK, "");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 3)[at] = 0xfc00, ERR_NOT_FINITE, "lens_slope[3]");
    EXPECT(samples_u16(s, PLANE_LENS_SLOPE, 0)[at] = HALF_NAN, ERR_NOT_FINITE, "lens_slope[0]");
    EXPECT(samples_u16(s, PLANE_LENS_DEPTH, 3)[at] = 0xfc00, ERR_NOT_FINITE, "lens_depth[3]");
    EXPECT(samples_u32(s, PLANE_LENS_ALBEDO, 3)[at] = UINT32_MAX, ERR_OK, "");
    EXPECT(samples_u32(s, PLANE_LENS_OWN_LIGHT, 3)[at] = 0xf5ffffffu, ERR_OK, "");
    EXPECT(samples_u32(s, PLANE_LENS_OWN_LIGHT, 3)[at] = 0xf6000000u, ERR_RANGE,
           "lens_own_light[3]");
    EXPECT(samples_u16(s, PLANE_LENS_COVERAGE, 0)[at] = HALF_NEGATIVE, ERR_RANGE,
           "lens_coverage[0]");
    EXPECT(samples_f32(s, PLANE_LENS_SECOND_SET, 3)[at] = -1.0f, ERR_RANGE, "lens_second_set[3]");
    EXPECT(samples_f32(s, PLANE_LENS_SECOND_SET, 0)[at] = NAN, ERR_NOT_FINITE,
           "lens_second_set[0]");
    EXPECT(samples_light_irradiance(s, 2)[at] = NAN, ERR_NOT_FINITE, "lights[2].irradiance");
    EXPECT(samples_light_irradiance(s, 2)[at] = -1e-30f, ERR_RANGE, "lights[2].irradiance");
    EXPECT(samples_light_slope(s, 3, 0)[at] = HALF_NEGATIVE, ERR_RANGE, "lights[3].slopes");
    EXPECT(samples_light_slope(s, 3, 1)[at] = HALF_INFINITE, ERR_NOT_FINITE, "lights[3].slopes");
    EXPECT((samples_light_slope(s, 3, 0)[at] = 2, samples_light_slope(s, 3, 1)[at] = 1), ERR_RANGE,
           "lights[3].slopes");
}

/* Runs all tests for both ways of packing. */
int main(void)
{
    int failed = unit_run("damaged samples, quick");
    packing = PACKING_SMALL;
    failed += unit_run("damaged samples, small");
    return failed;
}
