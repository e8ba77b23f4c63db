#include "server/image/exr_zip.h"

#include <libdeflate.h>
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

/* Even bytes first, then odd ones: those of equal weight come together. The first is as it was. */
static void split(const uint8_t *in, uint8_t *out, size_t size_bytes)
{
    const size_t even = (size_bytes + 1) / 2;
    if (size_bytes == 0) return;
    differ(in, out, even, 128);
    differ(in + 1, out + even, size_bytes / 2, in[2 * (even - 1)]);
}

/* A zlib stream of `in`; of 0 bytes when there is no room for it. */
static exr_result_t deflate_all(const uint8_t *in, size_t size_bytes, uint8_t *out,
                                size_t *out_bytes)
{
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor(1);
    if (!compressor) return EXR_ERR_OUT_OF_MEMORY;
    *out_bytes = libdeflate_zlib_compress(compressor, in, size_bytes, out, size_bytes);
    libdeflate_free_compressor(compressor);
    return EXR_ERR_SUCCESS;
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
    exr_result_t result = deflate_all(scratch, size_bytes, out, &out_bytes);
    if (result == EXR_ERR_SUCCESS && (out_bytes == 0 || out_bytes == size_bytes)) {
        memcpy(out, encoder->packed_buffer, size_bytes);
        out_bytes = size_bytes;
    }
    encoder->compressed_bytes = out_bytes;
    return result;
}
