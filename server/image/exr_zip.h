#pragma once
/* EXR's ZIP codec by ISA-L instead of zlib, which spends most of its time on searching noise for
 * repetitions. ISA-L takes a third of the time of libdeflate's fastest level, for 2 to 3 % more
 * bytes. */
#include <OpenEXR/openexr.h>

/* The compressor of one file's chunks. */
struct exr_zip;

/* Creates a compressor; NULL on failed allocation. */
struct exr_zip *exr_zip_create(void);

/* Frees it and nulls the pointer, which may be NULL. */
void exr_zip_destroy(struct exr_zip **zip);

/* Replaces the encoder's compress_fn. encoding_user_data is a struct exr_zip that no other thread
 * uses. Any reader of EXR files can read the output. Its bytes depend on the input and the CPU
 * alone.
 *
 * The codec (OpenEXR's technical introduction, "ZIP"): even bytes, then odd ones; each as the
 * difference to the one before; then a zlib stream. */
exr_result_t exr_zip_compress(exr_encode_pipeline_t *encoder);
