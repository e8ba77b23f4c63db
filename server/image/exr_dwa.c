#include "server/image/exr_dwa.h"

#include <stdlib.h>
#include <string.h>

#include "server/image/dwa/dwa_shim.h"
#include "server/image/image.h"

static exr_result_t result_of(enum dwa_status status)
{
    return status == DWA_OK          ? EXR_ERR_SUCCESS
           : status == DWA_NO_MEMORY ? EXR_ERR_OUT_OF_MEMORY
                                     : EXR_ERR_INVALID_ARGUMENT;
}

/* Room for a chunk as it is: what does not shrink is written so (the format's rule). */
static exr_result_t make_room(exr_encode_pipeline_t *encoder, size_t size_bytes)
{
    if (encoder->compressed_alloc_size >= size_bytes) return EXR_ERR_SUCCESS;
    free(encoder->compressed_buffer);
    encoder->compressed_buffer = malloc(size_bytes);
    encoder->compressed_alloc_size = encoder->compressed_buffer ? size_bytes : 0;
    return encoder->compressed_buffer ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
}

exr_result_t exr_dwa_compress(exr_encode_pipeline_t *encoder)
{
    struct dwa_channel channels[IMAGE_CHANNELS];
    const int count = encoder->channel_count;
    if (count < 1 || count > IMAGE_CHANNELS) return EXR_ERR_INVALID_ARGUMENT;
    exr_result_t r = make_room(encoder, encoder->packed_bytes);
    if (r) return r;
    for (int c = 0; c < count; c++)
        channels[c] = (struct dwa_channel){encoder->channels[c].channel_name,
                                           encoder->channels[c].data_type == EXR_PIXEL_HALF,
                                           encoder->channels[c].p_linear};
    size_t size_bytes = 0;
    r = result_of(dwa_shim_compress(
        channels, count, encoder->channels[0].width, encoder->channels[0].height,
        encoder->packed_buffer, encoder->compressed_buffer, encoder->packed_bytes, &size_bytes));
    encoder->compressed_bytes = size_bytes;
    return r;
}
