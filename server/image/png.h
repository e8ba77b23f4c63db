#pragma once
/* PNG for people: a layer as a view shows it, of 8 or 16 bits a sample. */
#include "server/image/png_shade.h"

/* Encodes a layer (as image_layer_planes names them) into memory that the caller frees. Layers of
 * light are exposed, go through the view and the sRGB curve; albedo and errors through the exposure
 * and the sRGB curve; normals are shown as (n + 1) / 2; depth, id, samples are scaled to their
 * largest value. With alpha, colours are those of what covers a pixel (C / A); where an environment
 * is behind, they stay as they are. ERR_NOT_FOUND for a layer that is not there. */
int png_encode(const struct image *image, const char *layer, const struct png_options *options,
               uint8_t **out, size_t *size_bytes);

/* Encodes the same bytes from the top while the image forms. Rows that are written may change no
 * more. The image is borrowed until finish or abort. One thread at a time. ERR_NOT_FOUND,
 * ERR_MEMORY. */
struct png_rows;
int png_rows_begin(const struct image *image, const char *layer, const struct png_options *options,
                   struct png_rows **out);
/* Encodes rows before `end`. A picture that is scaled to its largest value, or has alpha, waits for
 * the last row. After an error only abort may be called. */
int png_rows_write(struct png_rows *rows, int32_t end);
/* Encodes the remaining rows. Frees and nulls, also on an error; the caller owns the bytes. */
int png_rows_finish(struct png_rows **rows, uint8_t **out, size_t *size_bytes);
/* Frees and nulls an encoder. NULL is ignored. */
void png_rows_abort(struct png_rows **rows);
