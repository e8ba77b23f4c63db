#pragma once
/* EXR's ZIP codec by libdeflate instead of zlib: the library's own spends most of its time looking
 * for repetitions in noise. (ISA-L is thrice as fast, but one file in some hundreds came out with
 * other bytes for the same values: it lost a match with the chunk's first bytes.) */
#include <OpenEXR/openexr.h>

/* Takes the place of the encoder's compress_fn. What it writes any reader of EXR files reads, and
 * the bytes depend on the input alone.
 *
 * The codec (OpenEXR's technical introduction, "ZIP"): even bytes, then odd ones; each as the
 * difference to the one before; then a zlib stream. */
exr_result_t exr_zip_compress(exr_encode_pipeline_t *encoder);
