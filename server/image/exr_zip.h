#pragma once
/* EXR's ZIP codec by ISA-L instead of zlib: the library's own spends most of its time looking for
 * repetitions in noise. */
#include <OpenEXR/openexr.h>

/* Takes the place of the encoder's compress_fn. What it writes any reader of EXR files reads, and
 * the bytes depend on the input and the CPU's instruction set alone.
 *
 * The codec (OpenEXR's technical introduction, "ZIP"): even bytes, then odd ones; each as the
 * difference to the one before; then a zlib stream. */
exr_result_t exr_zip_compress(exr_encode_pipeline_t *encoder);
