/* Lists of lone sub-samples: as they travel beside a tile's planes, and what is refused. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/samples_case.h"
#include "tests/unit/unit.h"

#define BIT(plane) PLANE_BIT(plane)

enum { WIDTH = 7, HEIGHT = 3, PLACES = WIDTH * HEIGHT * 3 };

static struct plan plan;
static enum packing packing = PACKING_QUICK; /* all is tried with each */

/* Light fields alone, with every part of a list. */
static void lone_case(void)
{
    plan_case(&plan);
    plan.camera.aperture_radius = 0.0f;
    plan.paths = (struct plan_paths){0};
    plan.lens_strata_per_axis = plan.lens_relight = 0;
    plan.planes = (plan.planes & ~(PLANES_PATH | PLANES_LENS_ALL)) | BIT(LONE);
}

static struct samples *create(uint32_t count)
{
    struct samples_layout layout;
    struct samples *s;
    assert_int_equal(samples_layout_init(&layout, &plan, 0, WIDTH, HEIGHT), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    samples_case_fill(s, UINT64_MAX, 15, 1);
    for (uint32_t k = 0; k < 3; k++) /* all show a surface */
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) samples_u16(s, PLANE_SUB_DEPTH, k)[i] = 0;
    if (count == 0) return s;
    assert_int_equal(lone_create(layout.lone_parts, count, &s->lone), 0);
    for (uint32_t e = 0; e < count; e++) {
        s->lone->words[e] = e * PLACES / count;
        for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
            for (uint32_t c = 0; c < 3; c++) {
                float *light = lone_values(s->lone, part, c);
                if (light) light[e] = 0.25f * (float)(1 + e * 31 + part * 7 + c);
            }
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

static void round_trip(uint32_t count)
{
    struct bytes_writer w;
    struct samples *s = create(count), *back;
    struct fault fault = {0};
    pack(s, &w);
    if (unpack(w.data, w.size_bytes, &back, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_memory_equal(&back->layout, &s->layout, sizeof s->layout);
    assert_memory_equal(back->data, s->data, s->layout.total_bytes);
    assert_int_equal(samples_bytes(back), s->layout.total_bytes + sparse_list_bytes(s->lone));
    assert_true((back->lone == NULL) == (count == 0));
    if (count > 0) {
        assert_int_equal(back->lone->count, count);
        assert_int_equal(back->lone->parts, s->lone->parts);
        assert_memory_equal(back->lone->words, s->lone->words, sparse_list_bytes(s->lone));
    }
    samples_destroy(&back);
    samples_destroy(&s);
    bytes_writer_fini(&w);
}

TEST(lists_round_trip)
{
    static const uint32_t counts[] = {0, 1, 2, 17, PLACES};
    lone_case();
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) round_trip(counts[i]);
    plan.planes &= ~PLANES_GLOSSY; /* fewer parts */
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) round_trip(counts[i]);
}

/* Planes that are left out take no list with them. */
TEST(lists_travel_without_planes)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    lone_case();
    struct samples *s = create(5);
    memset(s->data, 0, s->layout.total_bytes);
    pack(s, &w);
    if (unpack(w.data, w.size_bytes, &back, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_non_null(back->lone);
    assert_memory_equal(back->lone->words, s->lone->words, sparse_list_bytes(s->lone));
    samples_destroy(&back);
    samples_destroy(&s);
    bytes_writer_fini(&w);
}

TEST(parts_follow_the_plan)
{
    lone_case();
    assert_int_equal(lone_parts(&plan), 31);
    plan.planes &= ~(BIT(INDIRECT_HALVES) | BIT(GLOSSY_HALF));
    assert_int_equal(lone_parts(&plan),
                     1u << LONE_DIRECT | 1u << LONE_INDIRECT | 1u << LONE_GLOSSY);
    assert_int_equal(lone_words(lone_parts(&plan)), 10);
    plan.paths.spp = 4; /* these bring direct light */
    assert_int_equal(lone_parts(&plan), 1u << LONE_INDIRECT | 1u << LONE_GLOSSY);
    plan.planes &= ~(PLANES_BOUNCE_LIGHT | PLANES_GLOSSY);
    assert_int_equal(lone_parts(&plan), 0);
}

/* Nothing of it costs a byte where the plan has none. */
TEST(other_plans_have_the_same_bytes)
{
    struct bytes_writer with, without;
    lone_case();
    struct samples *s = create(0);
    pack(s, &with);
    samples_destroy(&s);
    plan.planes &= ~BIT(LONE);
    s = create(0);
    pack(s, &without);
    samples_destroy(&s);
    assert_int_equal(with.size_bytes, without.size_bytes);
    assert_memory_equal(with.data, without.data, with.size_bytes);
    bytes_writer_fini(&with);
    bytes_writer_fini(&without);
}

/* Packs 9 entries after a change, and expects a fault. */
#define EXPECT(change, expected, place)                                                            \
    do {                                                                                           \
        struct bytes_writer w;                                                                     \
        struct samples *back, *s;                                                                  \
        struct fault fault = {0};                                                                  \
        lone_case();                                                                               \
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

#define LIGHT(part, c) lone_values(s->lone, LONE_##part, c)

TEST(hostile_entries_are_refused)
{
    EXPECT(s->lone->words[0] = 0, ERR_OK, "");
    EXPECT(s->lone->words[8] = PLACES - 1, ERR_OK, "");
    EXPECT(s->lone->words[8] = PLACES, ERR_RANGE, "lone");
    EXPECT(s->lone->words[8] = UINT32_MAX, ERR_RANGE, "lone");
    EXPECT(s->lone->words[4] = s->lone->words[3], ERR_RANGE, "lone");
    EXPECT(s->lone->words[4] = s->lone->words[3] - 1, ERR_RANGE, "lone");
    EXPECT(s->lone->words[0] = s->lone->words[1], ERR_RANGE, "lone");
    EXPECT(LIGHT(DIRECT, 0)[2] = NAN, ERR_NOT_FINITE, "lone.direct[0]");
    EXPECT(LIGHT(DIRECT, 2)[8] = INFINITY, ERR_NOT_FINITE, "lone.direct[2]");
    EXPECT(LIGHT(INDIRECT, 1)[0] = -1e-20f, ERR_RANGE, "lone.indirect[1]");
    EXPECT(LIGHT(INDIRECT_HALF, 1)[3] = -INFINITY, ERR_NOT_FINITE, "lone.indirect_half[1]");
    EXPECT(LIGHT(GLOSSY, 0)[5] = 2e30f, ERR_RANGE, "lone.glossy[0]");
    EXPECT(LIGHT(GLOSSY, 0)[5] = LONE_RADIANCE_MAX, ERR_OK, "");
    EXPECT(LIGHT(GLOSSY_HALF, 2)[5] = NAN, ERR_NOT_FINITE, "lone.glossy_half[2]");
    EXPECT(samples_u16(s, PLANE_SUB_DEPTH, s->lone->words[4] % 3)[s->lone->words[4] / 3] =
               half_from_float(SUB_DEPTH_MISS),
           ERR_RANGE, "lone");
}

/* The list's head lies before its packed bytes, which end the samples. */
static size_t head_of(const struct bytes_writer *w)
{
    for (size_t packed = 1; packed + 8 <= w->size_bytes; packed++) {
        const uint8_t *p = w->data + w->size_bytes - packed - 8;
        const uint32_t count = (uint32_t)(p[0] | p[1] << 8 | p[2] << 16) | (uint32_t)p[3] << 24;
        const uint32_t bytes = (uint32_t)(p[4] | p[5] << 8 | p[6] << 16) | (uint32_t)p[7] << 24;
        if (count == 9 && bytes == packed) return w->size_bytes - packed - 8;
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
    lone_case();
    struct samples *s = create(9);
    pack(s, &w);
    const size_t head = head_of(&w);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        const bool possible = counts[i] > 0 && counts[i] <= PLACES;
        memcpy(w.data + head, &counts[i], 4);
        assert_int_equal(unpack(w.data, w.size_bytes, &back, &fault),
                         possible ? ERR_CORRUPT : ERR_LIMIT);
        assert_string_equal(fault.pointer, "lone");
    }
    memcpy(w.data + head, &(uint32_t){9}, 4);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        memcpy(w.data + head + 4, &sizes[i], 4);
        assert_true(unpack(w.data, w.size_bytes, &back, &fault) != 0);
        assert_string_equal(fault.pointer, "lone");
    }
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

TEST(cut_and_foreign_lists_fail)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    lone_case();
    struct samples *s = create(9);
    pack(s, &w);
    for (size_t size_bytes = head_of(&w); size_bytes < w.size_bytes; size_bytes++)
        assert_int_equal(unpack(w.data, size_bytes, &back, &fault), ERR_TRUNCATED);
    plan.planes &= ~BIT(LONE); /* not asked for */
    assert_int_equal(unpack(w.data, w.size_bytes, &back, &fault), ERR_RANGE);
    plan.planes |= BIT(LONE);
    bytes_write_u8(&w, 0);
    assert_int_equal(unpack(w.data, w.size_bytes, &back, &fault), ERR_TRAILING);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* Damaged bytes are refused or unpack to numbers that are still allowed. */
TEST(damage_does_no_harm)
{
    struct bytes_writer w;
    uint64_t random = 7;
    uint32_t refused = 0;
    lone_case();
    struct samples *s = create(40);
    pack(s, &w);
    const size_t tail = 1500;
    for (int i = 0; i < 4000; i++) {
        struct samples *back;
        struct fault fault;
        const size_t at = w.size_bytes - 1 - samples_case_random(&random) % tail;
        const uint8_t flip = (uint8_t)(1 + samples_case_random(&random) % 255);
        w.data[at] ^= flip;
        refused += unpack(w.data, w.size_bytes, &back, &fault) != 0;
        for (uint32_t e = 0; back && back->lone && e < back->lone->count; e++)
            assert_true(back->lone->words[e] < PLACES);
        samples_destroy(&back);
        w.data[at] ^= flip;
    }
    assert_in_range(refused, 100, 3999);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* A tile must fit a frame were all its sub-samples lone. */
TEST(room_is_kept_for_all)
{
    struct samples_layout layout;
    uint32_t l = 1;
    lone_case();
    plan.planes &= ~BIT(LONE);
    for (plan.indirect_strata_per_axis = l; samples_layout_init(&layout, &plan, 0, 256, 256) == 0;
         l++)
        plan.indirect_strata_per_axis = l + 1;
    plan.indirect_strata_per_axis = l - 1; /* the most that fits */
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 256, 256), 0);
    const uint64_t left = LIMIT_FRAME_BYTES - layout.total_bytes;
    plan.planes |= BIT(LONE);
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 256, 256),
                     left > 256u * 256 * 3 * 16 * 4 + 8192 ? 0 : ERR_LIMIT);
    plan.indirect_strata_per_axis = 1;
    assert_int_equal(samples_layout_init(&layout, &plan, 0, 256, 256), 0);
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
    int failed = unit_run("lone sub-samples, quick");
    packing = PACKING_SMALL;
    failed += unit_run("lone sub-samples, small");
    return failed;
}
