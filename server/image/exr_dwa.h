#pragma once
/* EXR's DWAA codec, which loses of colours what people hardly see. Its bytes depend on the input,
 * the library and the CPU. */
#include <OpenEXR/openexr.h>

/* Replaces the encoder's compress_fn. */
exr_result_t exr_dwa_compress(exr_encode_pipeline_t *encoder);
