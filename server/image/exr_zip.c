#include "server/image/exr_zip.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* Fewer bytes are not judged alone: a block's Huffman table costs some eighty. */
#define PIECE_BYTES 512u

/* Bits a byte from which on coding is not worth its time; for n random bytes of 256 values the
 * estimate falls short of 8 by 255 / (2 n ln 2) on average (Miller 1955). */
#define NOISE_BITS 7.9f
#define SHORTFALL  184.0f

/* Even bytes first, then odd ones: those of equal weight come together. */
static void split(const uint8_t *in, uint8_t *out, size_t size_bytes)
{
    uint8_t *even = out, *odd = out + (size_bytes + 1) / 2;
    size_t pairs = size_bytes / 2;
    for (size_t i = 0; i < pairs; i++) {
        even[i] = in[2 * i];
        odd[i] = in[2 * i + 1];
    }
    if (size_bytes % 2) even[pairs] = in[size_bytes - 1];
}

/* Each byte as its difference to the one before, around 128. From the end: in place. */
static void differ(uint8_t *bytes, size_t size_bytes)
{
    for (size_t i = size_bytes; i-- > 1;) bytes[i] = (uint8_t)(bytes[i] - bytes[i - 1] + 128);
}

/* Bits a byte that an ideal code of single bytes would take. */
static float entropy_bits(const uint8_t *bytes, size_t size_bytes)
{
    uint32_t counts[4][256] = {0}; /* four, so that equal neighbours do not wait for each other */
    float sum = 0.0f;
    for (size_t i = 0; i < size_bytes; i++) counts[i & 3][bytes[i]]++;
    for (int v = 0; v < 256; v++) {
        uint32_t n = counts[0][v] + counts[1][v] + counts[2][v] + counts[3][v];
        if (n > 0) sum += (float)n * log2f((float)size_bytes / (float)n);
    }
    return sum / (float)size_bytes; /* pieces are not empty */
}

static bool is_noise(const uint8_t *bytes, size_t size_bytes)
{
    return entropy_bits(bytes, size_bytes) > NOISE_BITS - SHORTFALL / (float)size_bytes;
}

/* A zlib stream being written. */
struct stream {
    z_stream z;
    const uint8_t *start; /* of the piece that is being gathered */
    size_t size_bytes;    /* of it */
    int code;
};

/* Codes or stores what is gathered. deflateParams ends the block before when the level changes. */
static void end_piece(struct stream *s, int flush)
{
    if (s->code != Z_OK) return;
    int level = s->size_bytes > 0 && is_noise(s->start, s->size_bytes) ? 0 : 1;
    s->code = deflateParams(&s->z, level, Z_RLE);
    if (s->code != Z_OK) return;
    s->z.next_in = (Bytef *)(uintptr_t)s->start;
    s->z.avail_in = (uInt)s->size_bytes;
    s->code = deflate(&s->z, flush);
    if (s->code == Z_OK && s->z.avail_out == 0) s->code = Z_BUF_ERROR;
    s->start += s->size_bytes;
    s->size_bytes = 0;
}

/* The split bytes are, twice, row after row the halves of each channel's row: each is as noisy as
 * it is all along, so pieces end where they do. */
static void deflate_rows(struct stream *s, const exr_encode_pipeline_t *encoder)
{
    const uint8_t *end = s->start + encoder->packed_bytes;
    int32_t rows = encoder->chunk.height * 2;
    for (int32_t row = 0; row < rows; row++) {
        for (int16_t c = 0; c < encoder->channel_count; c++) {
            const exr_coding_channel_info_t *channel = &encoder->channels[c];
            /* Values of 2 or 4 bytes: rows halve evenly. */
            s->size_bytes += (size_t)channel->width * (size_t)channel->bytes_per_element / 2;
            if (s->size_bytes >= PIECE_BYTES) end_piece(s, Z_NO_FLUSH);
        }
    }
    assert(s->start + s->size_bytes == end); /* no subsampling: rows are all there is */
    end_piece(s, Z_FINISH);
}

/* False when `in` does not get smaller, or memory is missing. */
static bool deflate_all(const exr_encode_pipeline_t *encoder, const uint8_t *in, uint8_t *out,
                        size_t *out_bytes)
{
    struct stream s = {.start = in};
    if (deflateInit2(&s.z, 1, Z_DEFLATED, 15, 9, Z_RLE) != Z_OK) return false;
    s.z.next_out = out;
    s.z.avail_out = (uInt)encoder->packed_bytes;
    deflate_rows(&s, encoder);
    *out_bytes = s.z.total_out;
    deflateEnd(&s.z);
    return s.code == Z_STREAM_END && *out_bytes < encoder->packed_bytes;
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
    size_t size_bytes = encoder->packed_bytes, out_bytes = 0;
    if (!make_room(&encoder->scratch_buffer_1, &encoder->scratch_alloc_size_1, size_bytes) ||
        !make_room(&encoder->compressed_buffer, &encoder->compressed_alloc_size, size_bytes))
        return EXR_ERR_OUT_OF_MEMORY;
    uint8_t *scratch = encoder->scratch_buffer_1, *out = encoder->compressed_buffer;
    split(encoder->packed_buffer, scratch, size_bytes);
    differ(scratch, size_bytes);
    if (!deflate_all(encoder, scratch, out, &out_bytes)) {
        memcpy(out, encoder->packed_buffer, size_bytes);
        out_bytes = size_bytes;
    }
    encoder->compressed_bytes = out_bytes;
    return EXR_ERR_SUCCESS;
}
