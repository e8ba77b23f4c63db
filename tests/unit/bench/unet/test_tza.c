/* Archives of weights: what was written comes back, and what is cut off or wrong is refused. */
#include "tests/bench/unet/tza.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/bench/unet/archive.h"
#include "tests/unit/unit.h"

static const float numbers[6] = {1, -2, 0.5f, 1024, 0, -0.25f};

static const struct archive_tensor two[2] = {
    {.name = "a.weight", .layout = "oi", .sizes = {2, 3}, .type = 'h', .values = numbers},
    {.name = "a.bias", .layout = "x", .sizes = {2}, .type = 'f', .values = numbers + 3}};

static int parse(const struct bytes_writer *w, size_t size_bytes)
{
    struct tza tza;
    struct fault fault = {0};
    /* A copy of just that size, behind which sanitizers let nothing be read. */
    uint8_t *copy = malloc(size_bytes ? size_bytes : 1);
    assert_non_null(copy);
    memcpy(copy, w->data, size_bytes);
    int rc = tza_parse(copy, size_bytes, &tza, &fault);
    if (rc) assert_string_not_equal(fault.detail, "");
    tza_fini(&tza);
    free(copy);
    return rc;
}

static int parse_one(const struct archive_tensor *tensor)
{
    struct bytes_writer w;
    archive_write(tensor, 1, &w);
    int rc = parse(&w, w.size_bytes);
    bytes_writer_fini(&w);
    return rc;
}

TEST(what_was_written_comes_back)
{
    struct bytes_writer w;
    struct tza tza;
    struct fault fault = {0};
    archive_write(two, 2, &w);
    assert_int_equal(tza_parse(w.data, w.size_bytes, &tza, &fault), 0);
    const struct tza_tensor *weight = tza_find(&tza, "a.weight"), *bias = tza_find(&tza, "a.bias");
    assert_non_null(weight);
    assert_non_null(bias);
    assert_null(tza_find(&tza, "a"));
    assert_int_equal(weight->rank, 2);
    assert_int_equal(weight->sizes[1], 3);
    assert_string_equal(weight->layout, "oi");
    assert_int_equal(weight->count, 6);
    assert_memory_equal(weight->values, numbers, sizeof numbers);
    assert_int_equal(bias->count, 2);
    assert_memory_equal(bias->values, numbers + 3, 2 * sizeof *numbers);
    tza_fini(&tza);
    bytes_writer_fini(&w);
}

TEST(an_archive_cut_off_anywhere_is_refused)
{
    struct bytes_writer w;
    archive_write(two, 2, &w);
    assert_int_equal(parse(&w, w.size_bytes), 0);
    for (size_t size = 0; size < w.size_bytes; size++)
        assert_int_equal(parse(&w, size), ERR_TRUNCATED);
    bytes_writer_fini(&w);
}

TEST(another_magic_or_version_is_refused)
{
    struct bytes_writer w;
    archive_write(two, 2, &w);
    w.data[0] ^= 1;
    assert_int_equal(parse(&w, w.size_bytes), ERR_MAGIC);
    w.data[0] ^= 1;
    w.data[2] = 3;
    assert_int_equal(parse(&w, w.size_bytes), ERR_VERSION);
    bytes_writer_fini(&w);
}

TEST(places_beyond_the_end_are_refused)
{
    struct bytes_writer w;
    archive_write(two, 2, &w);
    memset(w.data + 4, 0xff, 8); /* the table's */
    assert_int_equal(parse(&w, w.size_bytes), ERR_TRUNCATED);
    bytes_writer_fini(&w);
    archive_write(two, 1, &w);
    memset(w.data + w.size_bytes - 6 * 2 - 8, 0xff, 8); /* the numbers' */
    assert_int_equal(parse(&w, w.size_bytes), ERR_TRUNCATED);
    bytes_writer_fini(&w);
}

TEST(too_much_is_refused)
{
    struct bytes_writer w;
    archive_write(two, 2, &w);
    w.data[12] = TZA_TENSORS_MAX + 1;
    assert_int_equal(parse(&w, w.size_bytes), ERR_LIMIT);
    w.data[12] = 2;
    w.data[16 + 2 + strlen(two[0].name)] = TZA_RANK_MAX + 1;
    assert_int_equal(parse(&w, w.size_bytes), ERR_LIMIT);
    bytes_writer_fini(&w);
    struct archive_tensor t = two[1];
    t.sizes[0] = TZA_SIZE_MAX + 1;
    float *zeros = calloc(TZA_SIZE_MAX + 1, sizeof *zeros);
    t.values = zeros;
    assert_int_equal(parse_one(&t), ERR_LIMIT);
    t.sizes[0] = 0;
    assert_int_equal(parse_one(&t), ERR_LIMIT);
    free(zeros);
}

TEST(another_type_is_refused)
{
    struct archive_tensor t = two[1];
    t.type = 'd';
    assert_int_equal(parse_one(&t), ERR_TYPE);
}

TEST(an_absent_file_is_refused)
{
    struct tza tza;
    struct fault fault = {0};
    assert_int_equal(tza_read("/nonexistent/weights.tza", &tza, &fault), ERR_IO);
    tza_fini(&tza);
}
