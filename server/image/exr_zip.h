#pragma once
/* EXR's ZIP codec, written for noisy floats: the library's own spends most of its time looking for
 * repetitions in noise. */
#include <OpenEXR/openexr.h>

/* Takes the place of the encoder's compress_fn. What it writes any reader of EXR files reads, and
 * the bytes depend on the input alone.
 *
 * The codec (OpenEXR's technical introduction, "ZIP"): even bytes, then odd ones; each as the
 * difference to the one before; then a zlib stream. Pieces of that stream whose bytes are as good
 * as random are stored, others are coded with runs and a Huffman table. */
exr_result_t exr_zip_compress(exr_encode_pipeline_t *encoder);
