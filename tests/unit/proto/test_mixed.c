/* Lists of mixed pixels: as they travel beside a tile's planes, and what is refused. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/samples_case.h"
#include "tests/unit/unit.h"

#define BIT(plane) PLANE_BIT(plane)

enum { WIDTH = 7, HEIGHT = 3, PLACES = WIDTH * HEIGHT * MIXED_SLOTS };

static struct plan plan;
static enum packing packing = PACKING_QUICK; /* all is tried with each */

/* Light fields alone, with both lists. */
static void mixed_case(void)
{
    plan_case(&plan);
    plan.camera.aperture_radius = 0.0f;
    plan.paths = (struct plan_paths){0};
    plan.lens_strata_per_axis = plan.lens_relight = 0;
    plan.planes = (plan.planes & ~(PLANES_PATH | PLANES_LENS_ALL)) | BIT(MIXED) | BIT(LONE);
}

static struct samples *create(uint32_t count)
{
    struct samples_layout layout;
    struct samples *s;
    assert_int_equal(samples_layout_init(&layout, &plan, 0, WIDTH, HEIGHT), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    samples_case_fill(s, UINT64_MAX, 15, 1);
    if (count == 0) return s;
    assert_int_equal(sparse_list_create(layout.mixed_values, count, &s->mixed), 0);
    for (uint32_t e = 0; e < count; e++) {
        s->mixed->words[e] = e * PLACES / count;
        for (uint32_t v = 0; v < s->mixed->values; v++)
            sparse_list_numbers(s->mixed, v)[e] = (float)((e * 31 + v * 7) % 64) / 63.0f;
    }
    return s;
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static int unpack(const uint8_t *data, size_t size_bytes, struct samples **out, struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    *out = NULL;
    const int error = samples_unpack(exact, size_bytes, &plan, 0, WIDTH, HEIGHT, out, fault);
    assert_true((error == 0) == (*out != NULL));
    free(exact);
    return error;
}

static void pack(struct samples *s, struct bytes_writer *w)
{
    bytes_writer_init(w);
    assert_int_equal(samples_pack(s, packing, w, NULL), 0);
}

static void round_trip(struct samples *s, uint32_t count)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    pack(s, &w);
    if (unpack(w.data, w.size_bytes, &back, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_memory_equal(&back->layout, &s->layout, sizeof s->layout);
    assert_memory_equal(back->data, s->data, s->layout.total_bytes);
    assert_int_equal(samples_bytes(back), s->layout.total_bytes + sparse_list_bytes(s->mixed) +
                                              sparse_list_bytes(s->lone));
    assert_true((back->mixed == NULL) == (count == 0));
    assert_true((back->lone == NULL) == (s->lone == NULL));
    if (count > 0) {
        assert_int_equal(back->mixed->count, count);
        assert_int_equal(back->mixed->values, s->mixed->values);
        assert_memory_equal(back->mixed->words, s->mixed->words, sparse_list_bytes(s->mixed));
    }
    samples_destroy(&back);
    samples_destroy(&s);
    bytes_writer_fini(&w);
}

TEST(lists_round_trip)
{
    static const uint32_t counts[] = {0, 1, 2, 17, PLACES};
    mixed_case();
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
        round_trip(create(counts[i]), counts[i]);
    plan.planes &= ~PLANES_GLOSSY; /* fewer values */
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
        round_trip(create(counts[i]), counts[i]);
}

TEST(lists_travel_beside_the_other_and_without_planes)
{
    mixed_case();
    struct samples *s = create(5);
    memset(s->data, 0, s->layout.total_bytes);
    round_trip(s, 5);
    s = create(5);
    for (uint32_t k = 0; k < 3; k++)
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) samples_u16(s, PLANE_SUB_DEPTH, k)[i] = 0;
    assert_int_equal(lone_create(s->layout.lone_parts, 1, &s->lone), 0);
    round_trip(s, 5);
}

TEST(samples_follow_the_plan)
{
    mixed_case();
    plan.light_count = 2;
    plan.indirect_strata_per_axis = 2;
    plan.lights[0].strata_per_axis = 1;
    plan.lights[1].strata_per_axis = 3;
    assert_int_equal(mixed_samples(&plan), 16);
    assert_int_equal(mixed_glow_samples(&plan), 64);
    plan.lights[1].strata_per_axis = 5;
    assert_int_equal(mixed_samples(&plan), 32);
    assert_int_equal(mixed_glow_samples(&plan), 64);
    plan.indirect_strata_per_axis = 9;
    assert_int_equal(mixed_samples(&plan), 96);
    assert_int_equal(mixed_glow_samples(&plan), 96);
    plan.paths.spp = 4; /* whatever layers there are besides */
    assert_int_equal(mixed_samples(&plan), 16);
    plan.paths.spp = 25;
    assert_int_equal(mixed_samples(&plan), 64);
}

/* Packs 9 entries after a change, and expects a fault. */
#define EXPECT(change, expected, place)                                                            \
    do {                                                                                           \
        struct bytes_writer w;                                                                     \
        struct samples *back, *s;                                                                  \
        struct fault fault = {0};                                                                  \
        mixed_case();                                                                              \
        s = create(9);                                                                             \
        change;                                                                                    \
        pack(s, &w);                                                                               \
        const int error = unpack(w.data, w.size_bytes, &back, &fault);                             \
        if (error != (expected) || strcmp(fault.pointer, place) != 0)                              \
            fail_msg(#change " gives %s at \"%s\": %s", error_name(error), fault.pointer,          \
                     fault.detail);                                                                \
        samples_destroy(&back);                                                                    \
        bytes_writer_fini(&w);                                                                     \
        samples_destroy(&s);                                                                       \
    } while (0)

TEST(hostile_entries_are_refused)
{
    EXPECT(s->mixed->words[8] = PLACES - 1, ERR_OK, "");
    EXPECT(s->mixed->words[8] = PLACES, ERR_RANGE, "mixed");
    EXPECT(s->mixed->words[8] = UINT32_MAX, ERR_RANGE, "mixed");
    EXPECT(s->mixed->words[4] = s->mixed->words[3], ERR_RANGE, "mixed");
    EXPECT(s->mixed->words[0] = s->mixed->words[1], ERR_RANGE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_SHARE)[2] = NAN, ERR_NOT_FINITE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_SHARE)[0] = 1.01f, ERR_RANGE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_ALBEDO + 2)[8] = INFINITY, ERR_NOT_FINITE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_REFLECTANCE + 2)[8] = -0.01f, ERR_RANGE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_REFLECTANCE)[3] = 1.0f, ERR_OK, "");
}

/* The list's head lies before its packed bytes, which end the samples. */
static size_t head_of(const struct bytes_writer *w)
{
    for (size_t packed = 1; packed + 8 <= w->size_bytes; packed++) {
        uint32_t words[2];
        memcpy(words, w->data + w->size_bytes - packed - 8, sizeof words);
        if (words[0] == 9 && words[1] == packed) return w->size_bytes - packed - 8;
    }
    fail_msg("no list at the end");
    return 0;
}

/* Neither count nor size decides what is allocated or written. */
TEST(declared_sizes_are_not_believed)
{
    static const uint32_t counts[] = {0, 8, 10, PLACES, PLACES + 1, 0x7fffffff, 0xffffffff};
    static const uint32_t sizes[] = {0, 1, 15, 0x7fffffff, 0xffffffff};
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    mixed_case();
    struct samples *s = create(9);
    pack(s, &w);
    const size_t head = head_of(&w);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        const bool possible = counts[i] > 0 && counts[i] <= PLACES;
        memcpy(w.data + head, &counts[i], 4);
        assert_int_equal(unpack(w.data, w.size_bytes, &back, &fault),
                         possible ? ERR_CORRUPT : ERR_LIMIT);
        assert_string_equal(fault.pointer, "mixed");
    }
    memcpy(w.data + head, &(uint32_t){9}, 4);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        memcpy(w.data + head + 4, &sizes[i], 4);
        assert_true(unpack(w.data, w.size_bytes, &back, &fault) != 0);
        assert_string_equal(fault.pointer, "mixed");
    }
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

TEST(cut_and_foreign_lists_fail)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    mixed_case();
    struct samples *s = create(9);
    pack(s, &w);
    for (size_t size_bytes = head_of(&w); size_bytes < w.size_bytes; size_bytes++)
        assert_int_equal(unpack(w.data, size_bytes, &back, &fault), ERR_TRUNCATED);
    plan.planes &= ~BIT(MIXED); /* not asked for */
    assert_int_equal(unpack(w.data, w.size_bytes, &back, &fault), ERR_RANGE);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

TEST(frees_nothing_twice)
{
    struct sparse_list *none = NULL;
    sparse_list_destroy(&none);
    assert_int_equal(sparse_list_bytes(NULL), 0);
}

/* Runs all tests for both ways of packing. */
int main(void)
{
    int failed = unit_run("mixed pixels, quick");
    packing = PACKING_SMALL;
    failed += unit_run("mixed pixels, small");
    return failed;
}
