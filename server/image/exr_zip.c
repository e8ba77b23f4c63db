#include "server/image/exr_zip.h"

#include <isa-l/igzip_lib.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Every second byte, each as its difference to the one before, around 128. */
static void differ(const uint8_t *restrict in, uint8_t *restrict out, size_t count, uint8_t before)
{
    if (count == 0) return;
    out[0] = (uint8_t)(in[0] - before + 128);
    for (size_t i = 1; i < count; i++) out[i] = (uint8_t)(in[2 * i] - in[2 * i - 2] + 128);
}

/* Puts even bytes before odd ones, so that bytes of equal weight come together. The first stays. */
static void split(const uint8_t *in, uint8_t *out, size_t size_bytes)
{
    const size_t even = (size_bytes + 1) / 2;
    differ(in, out, even, 128);
    differ(in + 1, out + even, size_bytes / 2, in[2 * (even - 1)]);
}

/* Codes are made for what eight pieces of a chunk hold: for all of it up to 32 KiB, for an eighth
 * and 4 KiB a piece beyond. */
#define PIECES      8
#define PIECE_BYTES 4096

/* What ISA-L needs at its level 0. Its other levels are as quick, but their output depends on where
 * in memory they work: one stream in a thousand was different in the next process. */
struct exr_zip {
    struct isal_zstream stream;
    struct isal_huff_histogram histogram;
    struct isal_hufftables tables;
};

struct exr_zip *exr_zip_create(void)
{
    return malloc(sizeof(struct exr_zip));
}

void exr_zip_destroy(struct exr_zip **zip)
{
    free(*zip);
    *zip = NULL;
}

static size_t min_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Finds codes for the chunk. Returns whether it has some now. */
static bool find_codes(struct exr_zip *zip, uint8_t *in, size_t size_bytes)
{
    const size_t part = size_bytes / PIECES;
    const size_t piece = part < PIECE_BYTES ? part : part / PIECES + PIECE_BYTES;
    memset(&zip->histogram, 0, sizeof zip->histogram);
    if (part == 0) isal_update_histogram(in, (int)size_bytes, &zip->histogram);
    for (size_t k = 0; part > 0 && k < PIECES; k++)
        isal_update_histogram(in + k * part, (int)min_of(piece, part), &zip->histogram);
    return isal_create_hufftables(&zip->tables, &zip->histogram) == 0;
}

/* Writes a zlib stream of `in`. Returns its bytes, 0 without room for it. */
static size_t deflate_all(struct exr_zip *zip, uint8_t *in, size_t size_bytes, uint8_t *out)
{
    struct isal_zstream *s = &zip->stream;
    memset(s, 0, sizeof *s); /* the next line leaves part of it, which 1 stream of 20,000 shows */
    isal_deflate_stateless_init(s);
    if (!find_codes(zip, in, size_bytes) ||
        isal_deflate_set_hufftables(s, &zip->tables, IGZIP_HUFFTABLE_CUSTOM) != COMP_OK)
        return 0;
    s->gzip_flag = IGZIP_ZLIB;
    s->end_of_stream = 1;
    s->next_in = in;
    s->next_out = out;
    s->avail_in = s->avail_out = (uint32_t)size_bytes;
    return isal_deflate_stateless(s) == COMP_OK && s->avail_in == 0 ? s->total_out : 0;
}

/* Room for a chunk as it is: what does not shrink is written so (the format's rule). The library
 * frees both buffers with free(), as no allocator of ours is set. */
static bool make_room(void **buffer, size_t *capacity_bytes, size_t size_bytes)
{
    if (*capacity_bytes >= size_bytes) return true;
    free(*buffer);
    *buffer = malloc(size_bytes);
    *capacity_bytes = *buffer ? size_bytes : 0;
    return *buffer != NULL;
}

exr_result_t exr_zip_compress(exr_encode_pipeline_t *encoder)
{
    const size_t size_bytes = encoder->packed_bytes;
    if (size_bytes == 0 || size_bytes > INT32_MAX) return EXR_ERR_INVALID_ARGUMENT;
    if (!make_room(&encoder->scratch_buffer_1, &encoder->scratch_alloc_size_1, size_bytes) ||
        !make_room(&encoder->compressed_buffer, &encoder->compressed_alloc_size, size_bytes))
        return EXR_ERR_OUT_OF_MEMORY;
    uint8_t *scratch = encoder->scratch_buffer_1, *out = encoder->compressed_buffer;
    split(encoder->packed_buffer, scratch, size_bytes);
    size_t out_bytes = deflate_all(encoder->encoding_user_data, scratch, size_bytes, out);
    if (out_bytes == 0 || out_bytes == size_bytes) {
        memcpy(out, encoder->packed_buffer, size_bytes);
        out_bytes = size_bytes;
    }
    encoder->compressed_bytes = out_bytes;
    return EXR_ERR_SUCCESS;
}
