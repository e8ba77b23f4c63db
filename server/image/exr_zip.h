#pragma once
/* EXR's ZIP codec by ISA-L instead of zlib: the library's own spends most of its time looking for
 * repetitions in noise. ISA-L takes a third of the time of libdeflate's fastest level for 2 to 3 %
 * more bytes. */
#include <OpenEXR/openexr.h>

/* What one file's chunks are deflated with. */
struct exr_zip;

/* NULL: memory is exhausted. */
struct exr_zip *exr_zip_create(void);

/* Nulls the pointer, which may be NULL. */
void exr_zip_destroy(struct exr_zip **zip);

/* Takes the place of the encoder's compress_fn; its encoding_user_data is a struct exr_zip that no
 * other thread uses. What it writes any reader of EXR files reads, and the bytes depend on the
 * input and the CPU alone.
 *
 * The codec (OpenEXR's technical introduction, "ZIP"): even bytes, then odd ones; each as the
 * difference to the one before; then a zlib stream. */
exr_result_t exr_zip_compress(exr_encode_pipeline_t *encoder);
