/* EXR's chunks, deflated: what came before leaves no trace in them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "server/image/exr_zip.h"

enum { MOST_BYTES = 3000, TRIALS = 20000 };

static uint64_t state_of_random = 3;

static uint32_t random_bits(void)
{
    state_of_random =
        state_of_random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(state_of_random >> 32);
}

/* Bytes that repeat after a while, with some noise: pairs of equal ones, since these are taken
 * apart. */
static size_t fill(uint8_t *bytes)
{
    const size_t size_bytes = 1 + random_bits() % MOST_BYTES, period = 1 + random_bits() % 1200;
    const uint32_t noise = random_bits() % 3;
    for (size_t i = 0; i < size_bytes; i++) {
        const bool fresh = i < 2 * period || (noise > 0 && random_bits() % (60 * noise) == 0);
        bytes[i] = fresh ? (uint8_t)(random_bits() % 11) : bytes[i - 2 * period];
    }
    return size_bytes;
}

static size_t compress(struct exr_zip *zip, uint8_t *bytes, size_t size_bytes, uint8_t *out)
{
    exr_encode_pipeline_t encoder = {
        .packed_buffer = bytes, .packed_bytes = size_bytes, .encoding_user_data = zip};
    assert_int_equal(exr_zip_compress(&encoder), EXR_ERR_SUCCESS);
    assert_in_range(encoder.compressed_bytes, 1, size_bytes);
    memcpy(out, encoder.compressed_buffer, encoder.compressed_bytes);
    free(encoder.compressed_buffer);
    free(encoder.scratch_buffer_1);
    return encoder.compressed_bytes;
}

/* A deflater that has seen other chunks gives what a fresh one does. */
static void chunks_do_not_depend_on_those_before(void **state)
{
    static uint8_t bytes[MOST_BYTES], other[MOST_BYTES], a[MOST_BYTES], b[MOST_BYTES];
    struct exr_zip *used = exr_zip_create();
    uint32_t smaller = 0;
    (void)state;
    assert_non_null(used);
    for (int trial = 0; trial < TRIALS; trial++) {
        struct exr_zip *fresh = exr_zip_create();
        const size_t size_bytes = fill(bytes), other_bytes = fill(other);
        assert_non_null(fresh);
        compress(used, other, other_bytes, a);
        const size_t a_bytes = compress(used, bytes, size_bytes, a);
        assert_int_equal(compress(fresh, bytes, size_bytes, b), a_bytes);
        assert_memory_equal(a, b, a_bytes);
        smaller += a_bytes < size_bytes;
        exr_zip_destroy(fresh);
    }
    assert_in_range(smaller, TRIALS / 2, TRIALS);
    exr_zip_destroy(used);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chunks_do_not_depend_on_those_before),
    };
    return cmocka_run_group_tests_name("exr_zip", tests, NULL, NULL);
}
