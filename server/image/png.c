#include "server/image/png.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

/* Pictures for people: a fifth of the time of zlib's default, some percent larger. Strategy 3 is
 * zlib's Z_RLE, made for filtered pictures. */
#define COMPRESSION_LEVEL    1
#define COMPRESSION_STRATEGY 3

/* What libpng has written so far. */
struct output {
    uint8_t *data; /* owned */
    size_t size_bytes, capacity_bytes;
};

struct png_rows {
    struct png_shader shader;
    int32_t width_px, height_px;
    struct output output;
    png_structp png;
    png_infop info;
    uint8_t *row;  /* owned */
    int32_t next;  /* the first row that is not written */
    bool is_begun; /* the header is written */
};

static void write_bytes(png_structp png, png_bytep data, size_t size_bytes)
{
    struct output *o = png_get_io_ptr(png);
    if (o->capacity_bytes - o->size_bytes < size_bytes) {
        size_t capacity = (o->size_bytes + size_bytes) * 2;
        uint8_t *grown = realloc(o->data, capacity);
        if (!grown) png_error(png, "memory is exhausted");
        o->data = grown;
        o->capacity_bytes = capacity;
    }
    memcpy(o->data + o->size_bytes, data, size_bytes);
    o->size_bytes += size_bytes;
}

static void flush_bytes(png_structp png)
{
    (void)png;
}

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

/* Numbers that are no colours say nothing of a colour space. */
static void write_header(const struct png_rows *p)
{
    const bool is_deep = p->shader.is_deep;
    png_set_IHDR(p->png, p->info, (png_uint_32)p->width_px, (png_uint_32)p->height_px,
                 is_deep ? 16 : 8, p->shader.alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (p->shader.shade == PNG_SHADE_COLOR)
        png_set_sRGB_gAMA_and_cHRM(p->png, p->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(p->png, COMPRESSION_LEVEL);
    png_set_compression_strategy(p->png, COMPRESSION_STRATEGY);
    png_set_filter(p->png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_write_info(p->png, p->info);
}

/* Everything between setjmp and a possible longjmp: no local of the caller changes here. */
static int write_rows(struct png_rows *p, int32_t end)
{
    if (setjmp(png_jmpbuf(p->png))) return ERR_MEMORY; /* writing to memory fails in no other way */
    if (!p->is_begun) {
        png_shader_begin(&p->shader);
        write_header(p);
        p->is_begun = true;
    }
    for (; p->next < end; p->next++) {
        png_shader_row(&p->shader, p->next, p->row);
        png_write_row(p->png, p->row);
    }
    if (end == p->height_px) png_write_end(p->png, NULL);
    return 0;
}

int png_rows_begin(const struct image *image, const char *layer, const struct png_options *options,
                   struct png_rows **out)
{
    struct png_rows *p = calloc(1, sizeof *p);
    *out = NULL;
    if (!p) return ERR_MEMORY;
    int error = png_shader_bind(&p->shader, image, layer, options);
    p->width_px = image->width_px;
    p->height_px = image->height_px;
    p->row = error ? NULL : malloc(png_shader_row_bytes(&p->shader));
    p->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, on_error, on_warning);
    p->info = p->png ? png_create_info_struct(p->png) : NULL;
    if (!error && (!p->row || !p->info)) error = ERR_MEMORY;
    if (error) {
        png_rows_abort(&p);
        return error;
    }
    png_set_write_fn(p->png, &p->output, write_bytes, flush_bytes);
    *out = p;
    return 0;
}

int png_rows_write(struct png_rows *p, int32_t end)
{
    if (end > p->height_px) end = p->height_px;
    const bool waits = end < p->height_px && !png_shader_is_local(&p->shader);
    return end <= p->next || waits ? 0 : write_rows(p, end);
}

int png_rows_finish(struct png_rows **rows, uint8_t **out, size_t *size_bytes)
{
    struct png_rows *p = *rows;
    const int error = png_rows_write(p, p->height_px);
    *out = NULL;
    *size_bytes = 0;
    if (!error) {
        *out = p->output.data;
        *size_bytes = p->output.size_bytes;
        p->output.data = NULL;
    }
    png_rows_abort(rows);
    return error;
}

void png_rows_abort(struct png_rows **rows)
{
    struct png_rows *p = *rows;
    *rows = NULL;
    if (!p) return;
    png_destroy_write_struct(&p->png, &p->info);
    free(p->output.data);
    free(p->row);
    free(p);
}

int png_encode(const struct image *image, const char *layer, const struct png_options *options,
               uint8_t **out, size_t *size_bytes)
{
    struct png_rows *rows;
    *out = NULL;
    *size_bytes = 0;
    const int error = png_rows_begin(image, layer, options, &rows);
    return error ? error : png_rows_finish(&rows, out, size_bytes);
}
