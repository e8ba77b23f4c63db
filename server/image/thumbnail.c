#include "server/image/thumbnail.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include "proto/limits.h"
#include "server/image/tonemap.h"

#define SAMPLES_PER_AXIS 4

/* One side of the small picture: at least a pixel, and never more than there were. */
static int32_t small_side(int32_t side_px, int32_t longest_px)
{
    if (longest_px <= THUMBNAIL_SIDE_PX) return side_px;
    const int64_t scaled =
        ((int64_t)side_px * THUMBNAIL_SIDE_PX + longest_px / 2) / (int64_t)longest_px;
    return scaled < 1 ? 1 : (int32_t)scaled;
}

static void fit(int32_t width_px, int32_t height_px, int32_t *width, int32_t *height)
{
    const int32_t longest = width_px > height_px ? width_px : height_px;
    *width = small_side(width_px, longest);
    *height = small_side(height_px, longest);
}

/* Where the k-th of `count` parts of a side begins. */
static int32_t part(int32_t k, int32_t count, int32_t side_px)
{
    return (int32_t)((int64_t)k * side_px / count);
}

static float mean_of(const struct plane *from, int32_t x0, int32_t x1, int32_t y0, int32_t y1)
{
    const int32_t nx = x1 - x0 < SAMPLES_PER_AXIS ? x1 - x0 : SAMPLES_PER_AXIS;
    const int32_t ny = y1 - y0 < SAMPLES_PER_AXIS ? y1 - y0 : SAMPLES_PER_AXIS;
    float sum = 0.0f;
    for (int32_t j = 0; j < ny; j++) {
        const float *row = plane_row(from, y0 + (2 * j + 1) * (y1 - y0) / (2 * ny));
        for (int32_t i = 0; i < nx; i++) sum += row[x0 + (2 * i + 1) * (x1 - x0) / (2 * nx)];
    }
    return sum / (float)(nx * ny);
}

static void shrink(const struct plane *from, const struct plane *to)
{
    for (int32_t y = 0; y < to->height_px; y++)
        for (int32_t x = 0; x < to->width_px; x++)
            plane_row(to, y)[x] = mean_of(from, part(x, to->width_px, from->width_px),
                                          part(x + 1, to->width_px, from->width_px),
                                          part(y, to->height_px, from->height_px),
                                          part(y + 1, to->height_px, from->height_px));
}

int thumbnail_of_image(const struct image *image, struct image **out)
{
    static const char *const names[] = {"R", "G", "B"};
    const struct plane *rgb[3];
    int32_t width, height;
    *out = NULL;
    if (!image_layer_planes(image, image_main_layer(image), rgb)) return ERR_NOT_FOUND;
    fit(image->width_px, image->height_px, &width, &height);
    const int error = image_create_named(names, 3, width, height, out);
    for (int c = 0; !error && c < 3; c++) shrink(rgb[c], &(*out)->channels[c].plane);
    return error;
}

/* ---- from a PNG, row by row ---- */

struct shrinking {
    FILE *file;
    png_structp png;
    png_infop info;
    int32_t width_px, height_px, width, height;
    uint8_t *row;   /* of the large picture */
    float *sums;    /* of the small picture's row: red, green, blue of each pixel */
    uint8_t *small; /* the small picture */
    float linear[256];
};

static void on_error(png_structp png, png_const_charp text)
{
    (void)text;
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

/* IEC 61966-2-1 decoding, as the inverse of tonemap_srgb. */
static void fill_linear(float linear[256])
{
    float low = 0.0f;
    for (int i = 0; i < 256; i++) {
        float high = 1.0f;
        for (int k = 0; k < 24; k++) {
            const float middle = 0.5f * (low + high);
            if (tonemap_srgb(middle) * 255.0f < (float)i)
                low = middle;
            else
                high = middle;
        }
        linear[i] = high;
    }
}

static void add_row(struct shrinking *s)
{
    for (int32_t x = 0; x < s->width; x++) {
        const int32_t x0 = part(x, s->width, s->width_px), x1 = part(x + 1, s->width, s->width_px);
        for (int32_t at = x0; at < x1; at++)
            for (int c = 0; c < 3; c++)
                s->sums[3 * x + c] += s->linear[s->row[3 * at + c]] / (float)(x1 - x0);
    }
}

static void end_row(struct shrinking *s, int32_t y, int32_t rows)
{
    uint8_t *to = s->small + (size_t)3 * (size_t)s->width * (size_t)y;
    for (int32_t i = 0; i < 3 * s->width; i++) {
        to[i] = tonemap_byte(s->sums[i], 1.0f / (float)rows);
        s->sums[i] = 0.0f;
    }
}

/* What is transparent shows black. */
static void ask_for_bytes(const struct shrinking *s, int type)
{
    const png_color_16 black = {0};
    png_set_scale_16(s->png);
    if (type == PNG_COLOR_TYPE_RGB_ALPHA)
        png_set_background(s->png, &black, PNG_BACKGROUND_GAMMA_SCREEN, 0, 1.0);
    png_read_update_info(s->png, s->info);
}

/* Returns whether it is a picture as png.h writes it. */
static bool read_header(struct shrinking *s)
{
    png_read_info(s->png, s->info);
    const png_uint_32 width = png_get_image_width(s->png, s->info);
    const png_uint_32 height = png_get_image_height(s->png, s->info);
    const int type = png_get_color_type(s->png, s->info);
    if (width > LIMIT_IMAGE_SIDE_PX || height > LIMIT_IMAGE_SIDE_PX ||
        (type != PNG_COLOR_TYPE_RGB && type != PNG_COLOR_TYPE_RGB_ALPHA) ||
        png_get_interlace_type(s->png, s->info) != PNG_INTERLACE_NONE)
        return false;
    ask_for_bytes(s, type);
    s->width_px = (int32_t)width;
    s->height_px = (int32_t)height;
    fit(s->width_px, s->height_px, &s->width, &s->height);
    return true;
}

static bool allocate(struct shrinking *s)
{
    s->row = malloc((size_t)s->width_px * 3);
    s->sums = calloc((size_t)s->width * 3, sizeof *s->sums);
    s->small = malloc((size_t)s->width * (size_t)s->height * 3);
    return s->row && s->sums && s->small;
}

/* Everything between setjmp and a possible longjmp: no local of the caller changes here. */
static int read_small(struct shrinking *s)
{
    if (setjmp(png_jmpbuf(s->png))) return ERR_CORRUPT;
    png_init_io(s->png, s->file);
    if (!read_header(s)) return ERR_CORRUPT;
    if (!allocate(s)) return ERR_MEMORY;
    for (int32_t y = 0; y < s->height; y++) {
        const int32_t rows =
            part(y + 1, s->height, s->height_px) - part(y, s->height, s->height_px);
        for (int32_t k = 0; k < rows; k++) {
            png_read_row(s->png, s->row, NULL);
            add_row(s);
        }
        end_row(s, y, rows);
    }
    return 0;
}

static int write_small(const struct shrinking *s, uint8_t **out, size_t *size_bytes)
{
    png_image picture = {.version = PNG_IMAGE_VERSION,
                         .width = (png_uint_32)s->width,
                         .height = (png_uint_32)s->height,
                         .format = PNG_FORMAT_RGB};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(picture);
    uint8_t *bytes = malloc(size);
    if (!bytes) return ERR_MEMORY;
    if (!png_image_write_to_memory(&picture, bytes, &size, 0, s->small, 0, NULL)) {
        free(bytes);
        return ERR_MEMORY;
    }
    *out = bytes;
    *size_bytes = size;
    return 0;
}

int thumbnail_of_png(const char *path, uint8_t **out, size_t *size_bytes)
{
    struct shrinking s = {.file = fopen(path, "rbe")};
    *out = NULL;
    *size_bytes = 0;
    if (!s.file) return ERR_IO;
    fill_linear(s.linear);
    s.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, on_error, on_warning);
    s.info = s.png ? png_create_info_struct(s.png) : NULL;
    int error = s.info ? read_small(&s) : ERR_MEMORY;
    if (!error) error = write_small(&s, out, size_bytes);
    png_destroy_read_struct(&s.png, &s.info, NULL);
    free(s.row);
    free(s.sums);
    free(s.small);
    fclose(s.file);
    return error;
}
