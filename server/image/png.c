#include "server/image/png.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/image/tonemap.h"

/* Pictures for people: a fifth of the time of zlib's default, some percent larger. Strategy 3 is
 * zlib's Z_RLE, made for filtered pictures. */
#define COMPRESSION_LEVEL    1
#define COMPRESSION_STRATEGY 3

/* The exposure beyond which a float's range ends. */
#define EXPOSURE_MAX 126.0f

/* How numbers become bytes. */
enum shade { SHADE_RADIANCE, SHADE_NORMAL, SHADE_SCALED };

struct shader {
    enum shade shade;
    float scale;
    struct tonemap_table table;
};

/* What libpng has written so far. */
struct output {
    uint8_t *data; /* owned */
    size_t size_bytes, capacity_bytes;
};

struct png_rows {
    const struct plane *rgb[3];
    char layer[LIMIT_NAME_BYTES];
    float exposure;
    struct shader shader;
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

/* The largest finite value of a plane, at least 0. */
static float plane_max(const struct plane *plane)
{
    float max = 0.0f;
    for (int32_t y = 0; y < plane->height_px; y++) {
        const float *row = plane_row(plane, y);
        for (int32_t x = 0; x < plane->width_px; x++) {
            if (row[x] > max && isfinite(row[x])) max = row[x];
        }
    }
    return max;
}

/* Numbers that are shares of 1 already. */
static bool is_share(const char *layer)
{
    return !strcmp(layer, "visibility");
}

static void shader_init(struct shader *s, const char *layer, const struct plane *rgb[3],
                        float exposure)
{
    bool scalar = rgb[0] == rgb[1];
    s->scale = 1.0f;
    if (!strcmp(layer, "normal")) {
        s->shade = SHADE_NORMAL;
    } else if (scalar) {
        float max = plane_max(rgb[0]);
        s->shade = SHADE_SCALED;
        /* A tiny maximum has no finite inverse. */
        s->scale = is_share(layer) ? 1.0f : max > 1e-30f ? 1.0f / max : 0.0f;
    } else {
        s->shade = SHADE_RADIANCE;
        s->scale = exp2f(fminf(fmaxf(exposure, -EXPOSURE_MAX), EXPOSURE_MAX));
        tonemap_table_init(&s->table);
    }
}

/* round(255 v) of v clipped to [0, 1]; NaN gives 0. */
static uint8_t linear_byte(float v)
{
    if (!(v > 0.0f)) return 0;
    return v >= 1.0f ? 255 : (uint8_t)lrintf(255.0f * v);
}

static void shade_row(const struct shader *s, const struct plane *rgb[3], int32_t y, uint8_t *out)
{
    int32_t width = rgb[0]->width_px;
    for (int c = 0; c < 3; c++) {
        const float *row = plane_row(rgb[c], y);
        uint8_t *to = out + c;
        for (int32_t x = 0; x < width; x++, to += 3) {
            if (s->shade == SHADE_RADIANCE)
                *to = tonemap_table_byte(&s->table, row[x], s->scale);
            else if (s->shade == SHADE_NORMAL)
                *to = linear_byte((row[x] + 1.0f) * 0.5f);
            else
                *to = linear_byte(row[x] * s->scale);
        }
    }
}

static void write_header(png_structp png, png_infop info, int32_t width_px, int32_t height_px)
{
    png_set_IHDR(png, info, (png_uint_32)width_px, (png_uint_32)height_px, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, COMPRESSION_LEVEL);
    png_set_compression_strategy(png, COMPRESSION_STRATEGY);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_write_info(png, info);
}

/* Returns whether rows can be encoded. A picture that is scaled by its largest value waits for all
 * rows. */
static bool can_begin(const struct png_rows *p, int32_t end)
{
    return end >= p->rgb[0]->height_px || p->rgb[0] != p->rgb[1] || is_share(p->layer);
}

/* Everything between setjmp and a possible longjmp: no local of the caller changes here. */
static int write_rows(struct png_rows *p, int32_t end)
{
    if (setjmp(png_jmpbuf(p->png))) return ERR_MEMORY; /* writing to memory fails in no other way */
    if (!p->is_begun) {
        shader_init(&p->shader, p->layer, p->rgb, p->exposure);
        write_header(p->png, p->info, p->rgb[0]->width_px, p->rgb[0]->height_px);
        p->is_begun = true;
    }
    for (; p->next < end; p->next++) {
        shade_row(&p->shader, p->rgb, p->next, p->row);
        png_write_row(p->png, p->row);
    }
    if (end == p->rgb[0]->height_px) png_write_end(p->png, NULL);
    return 0;
}

int png_rows_begin(const struct image *image, const char *layer, float exposure,
                   struct png_rows **out)
{
    struct png_rows *p = calloc(1, sizeof *p);
    *out = NULL;
    if (!p) return ERR_MEMORY;
    int error = image_layer_planes(image, layer, p->rgb) ? 0 : ERR_NOT_FOUND;
    snprintf(p->layer, sizeof p->layer, "%s", layer);
    p->exposure = exposure;
    p->row = malloc((size_t)image->width_px * 3);
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
    const int32_t height = p->rgb[0]->height_px;
    if (end > height) end = height;
    return end <= p->next || !can_begin(p, end) ? 0 : write_rows(p, end);
}

int png_rows_finish(struct png_rows **rows, uint8_t **out, size_t *size_bytes)
{
    struct png_rows *p = *rows;
    const int error = png_rows_write(p, p->rgb[0]->height_px);
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

int png_encode(const struct image *image, const char *layer, float exposure, uint8_t **out,
               size_t *size_bytes)
{
    struct png_rows *rows;
    *out = NULL;
    *size_bytes = 0;
    const int error = png_rows_begin(image, layer, exposure, &rows);
    return error ? error : png_rows_finish(&rows, out, size_bytes);
}
