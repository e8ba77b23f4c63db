#include <png.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/image/image_decoder.h"

/* libpng's view of the input, and what it complains about. */
struct png_source {
    const uint8_t *at;
    size_t left;
    char message[128];
};

static void on_error(png_structp png, png_const_charp message)
{
    struct png_source *source = png_get_error_ptr(png);
    snprintf(source->message, sizeof source->message, "%s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png; /* colour profiles and the like, which are not used */
    (void)message;
}

static void on_read(png_structp png, png_bytep out, size_t size_bytes)
{
    struct png_source *source = png_get_io_ptr(png);
    if (size_bytes > source->left) png_error(png, "the data ends too early");
    memcpy(out, source->at, size_bytes);
    source->at += size_bytes;
    source->left -= size_bytes;
}

/* Asks for RGBA8 whatever the file holds. */
static void convert_to_rgba8(png_structp png, png_infop info)
{
    png_set_scale_16(png);
    png_set_expand(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
}

/* Asks for samples of 16 bits as this machine has them. */
static void convert_to_grey16(png_structp png, png_infop info)
{
    if (png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY || png_get_bit_depth(png, info) != 16)
        png_error(png, "it is no grey of 16 bits");
    png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
}

/* Reads the rows, between setjmp and its return. Only libpng owns memory here. */
static int read_rows(png_structp png, png_infop info, const struct image_header *header,
                     bool is_grey16, png_bytepp rows)
{
    if (setjmp(png_jmpbuf(png)) != 0) return ERR_CORRUPT;
    png_set_user_limits(png, LIMIT_TEXTURE_SIDE_PX, LIMIT_TEXTURE_SIDE_PX);
    png_set_chunk_malloc_max(png, 16u << 20);
    png_read_info(png, info);
    if (png_get_image_width(png, info) != header->width_px ||
        png_get_image_height(png, info) != header->height_px)
        png_error(png, "its header changed");
    if (is_grey16)
        convert_to_grey16(png, info);
    else
        convert_to_rgba8(png, info);
    if (png_get_rowbytes(png, info) != (size_t)header->width_px * (is_grey16 ? 2 : 4))
        png_error(png, "its rows have an unexpected size");
    png_read_image(png, rows);
    return 0;
}

static int decode(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                  bool is_grey16, const char *place, uint8_t *out, struct fault *fault)
{
    const size_t row_bytes = (size_t)header->width_px * (is_grey16 ? 2 : 4);
    struct png_source source = {data, size_bytes, "out of memory"};
    png_infop info = NULL;
    int rc = ERR_MEMORY;
    png_bytepp rows = malloc(header->height_px * sizeof *rows);
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, on_error, on_warning);
    if (png != NULL) info = png_create_info_struct(png);
    if (rows != NULL && info != NULL) {
        for (size_t y = 0; y < header->height_px; y++) rows[y] = out + y * row_bytes;
        png_set_read_fn(png, &source, on_read);
        rc = read_rows(png, info, header, is_grey16, rows);
    }
    png_destroy_read_struct(&png, &info, NULL);
    free(rows);
    if (rc == 0) return 0;
    return fault_set(fault, rc, place, "the PNG image cannot be decoded: %s", source.message);
}

int image_decode_png(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                     const char *place, uint8_t *rgba, struct fault *fault)
{
    return decode(data, size_bytes, header, false, place, rgba, fault);
}

int image_decode_grey16(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                        const char *place, uint16_t *grey, struct fault *fault)
{
    if (header->kind != IMAGE_PNG)
        return fault_set(fault, ERR_UNSUPPORTED, place, "it is no PNG of 16 bits");
    return decode(data, size_bytes, header, true, place, (uint8_t *)grey, fault);
}
