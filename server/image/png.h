#pragma once
/* 8-bit PNG for display, by exposure and the sRGB curve. */
#include "server/image/image.h"

/* Encodes a layer (as image_layer_planes names them) into memory that the caller frees. Radiance
 * layers are multiplied by 2^exposure and clipped; albedo likewise; normals are shown as
 * (n + 1) / 2; depth, id, samples are scaled to their largest value. ERR_NOT_FOUND for a layer that
 * is not there. */
int png_encode(const struct image *image, const char *layer, float exposure, uint8_t **out,
               size_t *size_bytes);

/* Encodes the same bytes from the top while the image forms. Rows that are written may change no
 * more. The image is borrowed until finish or abort. One thread at a time. ERR_NOT_FOUND,
 * ERR_MEMORY. */
struct png_rows;
int png_rows_begin(const struct image *image, const char *layer, float exposure,
                   struct png_rows **out);
/* Encodes rows before `end`. A picture that is scaled to its largest value waits for the last row.
 * After an error only abort may be called. */
int png_rows_write(struct png_rows *rows, int32_t end);
/* Encodes the remaining rows. Frees and nulls, also on an error; the caller owns the bytes. */
int png_rows_finish(struct png_rows **rows, uint8_t **out, size_t *size_bytes);
/* Frees and nulls an encoder. NULL is ignored. */
void png_rows_abort(struct png_rows **rows);
