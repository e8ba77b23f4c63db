/* EXR's chunks, deflated: they hold what went in, and what came before leaves no trace in them. */
#include <isa-l/igzip_lib.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "server/image/exr_zip.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

enum { SMALL_BYTES = 3000, LARGE_BYTES = 1 << 17, TRIALS = 8000, ROUNDS = 400 };

/* Bytes that repeat after a while, with some noise: pairs of equal ones, since these are taken
 * apart. */
static void fill(struct random *r, uint8_t *bytes, size_t size_bytes)
{
    const size_t period = 1 + random_bits(r) % 1200, noise = random_bits(r) % 3;
    for (size_t i = 0; i < size_bytes; i++) {
        const bool fresh = i < 2 * period || (noise > 0 && random_bits(r) % (60 * noise) == 0);
        bytes[i] = fresh ? (uint8_t)(random_bits(r) % 11) : bytes[i - 2 * period];
    }
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
TEST(chunks_do_not_depend_on_those_before)
{
    static uint8_t bytes[SMALL_BYTES], other[SMALL_BYTES], a[SMALL_BYTES], b[SMALL_BYTES];
    struct random r = {3};
    struct exr_zip *used = exr_zip_create();
    uint32_t smaller = 0;
    assert_non_null(used);
    for (int trial = 0; trial < TRIALS; trial++) {
        struct exr_zip *fresh = exr_zip_create();
        const size_t size_bytes = 1 + random_bits(&r) % SMALL_BYTES;
        const size_t other_bytes = 1 + random_bits(&r) % SMALL_BYTES;
        assert_non_null(fresh);
        fill(&r, bytes, size_bytes);
        fill(&r, other, other_bytes);
        compress(used, other, other_bytes, a);
        const size_t a_bytes = compress(used, bytes, size_bytes, a);
        assert_int_equal(compress(fresh, bytes, size_bytes, b), a_bytes);
        assert_memory_equal(a, b, a_bytes);
        smaller += a_bytes < size_bytes;
        exr_zip_destroy(&fresh);
    }
    assert_in_range(smaller, TRIALS / 2, TRIALS);
    exr_zip_destroy(&used);
}

/* What a reader makes of a chunk: the format's codec, backwards. */
static void restore(uint8_t *in, size_t in_bytes, uint8_t *out, size_t size_bytes)
{
    static uint8_t parts[LARGE_BYTES];
    struct inflate_state inflater;
    if (in_bytes == size_bytes) { /* as it is */
        memcpy(out, in, size_bytes);
        return;
    }
    isal_inflate_init(&inflater);
    inflater.crc_flag = ISAL_ZLIB;
    inflater.next_in = in;
    inflater.avail_in = (uint32_t)in_bytes;
    inflater.next_out = parts;
    inflater.avail_out = sizeof parts;
    assert_int_equal(isal_inflate(&inflater), ISAL_DECOMP_OK);
    assert_int_equal(inflater.total_out, size_bytes);
    for (size_t i = 1; i < size_bytes; i++) parts[i] = (uint8_t)(parts[i - 1] + parts[i] - 128);
    for (size_t i = 0; i < size_bytes; i++)
        out[i] = parts[i / 2 + (i % 2) * ((size_bytes + 1) / 2)];
}

/* Memory of LARGE_BYTES behind which nothing may be read. */
static uint8_t *guarded(void)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uint8_t *memory =
        mmap(NULL, LARGE_BYTES + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(memory, MAP_FAILED);
    assert_int_equal(mprotect(memory + LARGE_BYTES, page, PROT_NONE), 0);
    return memory;
}

/* The first sizes there are, and larger ones; noise does not shrink. */
TEST(chunks_hold_what_went_in)
{
    static uint8_t deflated[LARGE_BYTES], back[LARGE_BYTES];
    uint8_t *memory = guarded();
    struct random r = {5};
    struct exr_zip *zip = exr_zip_create();
    assert_non_null(zip);
    for (size_t round = 1; round <= ROUNDS; round++) {
        const size_t any = 1 + random_bits(&r) % LARGE_BYTES;
        const size_t size_bytes = round < ROUNDS / 2 ? round : any;
        uint8_t *bytes = memory + LARGE_BYTES - size_bytes;
        fill(&r, bytes, size_bytes);
        for (size_t i = 0; round % 7 == 0 && i < size_bytes; i++)
            bytes[i] = (uint8_t)random_bits(&r);
        if (round % 11 == 0) memset(bytes, 0, size_bytes);
        const size_t out_bytes = compress(zip, bytes, size_bytes, deflated);
        restore(deflated, out_bytes, back, size_bytes);
        assert_memory_equal(back, bytes, size_bytes);
    }
    exr_zip_destroy(&zip);
    assert_null(zip);
    munmap(memory, LARGE_BYTES + (size_t)sysconf(_SC_PAGESIZE));
}
