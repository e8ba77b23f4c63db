/* Radiance pictures (Ward, "Real Pixels", Graphics Gems II, 1991; the format as the Radiance manual
 * describes it). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/image/panorama.h"

#define HEADER_BYTES  65536 /* of the header, at most; it holds a few lines */
#define LINE_BYTES    512   /* of a line that is looked at */
#define RUN_WIDTH_MIN 8     /* px; rows outside these widths are never coded the new way */
#define RUN_WIDTH_MAX 32767

struct reader {
    const uint8_t *at, *end;
    const char *name;
    struct warnings *warnings;
    struct fault *fault;
    double exposure; /* the product of all */
    uint32_t width, height;
    bool from_bottom, from_right;
    uint8_t *row;     /* 4 * width: red, green, blue, exponent */
    float scale[256]; /* by exponent */
};

bool panorama_is_radiance(const struct file_view *file)
{
    static const char *const marks[] = {"#?RADIANCE", "#?RGBE"};
    for (size_t i = 0; i < 2; i++) {
        const size_t length = strlen(marks[i]);
        if (file->size_bytes > length && memcmp(file->data, marks[i], length) == 0) return true;
    }
    return false;
}

/* ---- the header ---- */

static int refuse(const struct reader *r, int code, const char *why)
{
    return fault_set(r->fault, code, r->name, "%s", why);
}

/* The next line, cut to what fits, without its end. */
static int read_line(struct reader *r, char line[LINE_BYTES])
{
    const uint8_t *end = memchr(r->at, '\n', (size_t)(r->end - r->at));
    if (end == NULL) return refuse(r, ERR_TRUNCATED, "the header has no end");
    size_t length = (size_t)(end - r->at);
    if (length >= LINE_BYTES) length = LINE_BYTES - 1;
    memcpy(line, r->at, length);
    if (length > 0 && line[length - 1] == '\r') length--;
    line[length] = 0;
    r->at = end + 1;
    return 0;
}

static int take_exposure(struct reader *r, const char *text)
{
    char *end;
    const double value = strtod(text, &end);
    if (end == text || !(value > 0.0) || !isfinite(value))
        return fault_set(r->fault, ERR_RANGE, r->name, "EXPOSURE \"%.100s\" is no positive number",
                         text);
    r->exposure *= value;
    return 0;
}

static int take_variable(struct reader *r, const char *line)
{
    if (strncmp(line, "EXPOSURE=", 9) == 0) return take_exposure(r, line + 9);
    if (strncmp(line, "COLORCORR=", 10) == 0)
        warnings_add(r->warnings, "COLORCORR", "a correction of colours is ignored");
    if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
        return fault_set(r->fault, ERR_UNSUPPORTED, r->name,
                         "the format \"%.100s\" is not read, 32-bit_rle_rgbe is", line + 7);
    return 0;
}

static int take_resolution(struct reader *r, const char *line)
{
    char row_sign, row_axis, column_sign, column_axis;
    long long rows, columns;
    int used = 0;
    const int n = sscanf(line, "%c%c %9lld %c%c %9lld%n", &row_sign, &row_axis, &rows, &column_sign,
                         &column_axis, &columns, &used);
    if (n != 6 || line[used] != 0 || rows < 1 || columns < 1 ||
        (row_sign != '-' && row_sign != '+') || (column_sign != '-' && column_sign != '+'))
        return fault_set(r->fault, ERR_SYNTAX, r->name, "\"%.100s\" is no resolution", line);
    if (row_axis != 'Y' || column_axis != 'X')
        return fault_set(r->fault, ERR_UNSUPPORTED, r->name,
                         "pictures stored by columns (\"%.100s\") are not read", line);
    if (rows > LIMIT_ENVIRONMENT_SIDE_PX || columns > LIMIT_ENVIRONMENT_SIDE_PX)
        return fault_set(r->fault, ERR_LIMIT, r->name,
                         "%lld x %lld px; a map has up to %u on each side", columns, rows,
                         LIMIT_ENVIRONMENT_SIDE_PX);
    r->width = (uint32_t)columns;
    r->height = (uint32_t)rows;
    r->from_bottom = row_sign == '+';
    r->from_right = column_sign == '-';
    return 0;
}

static int read_header(struct reader *r)
{
    char line[LINE_BYTES] = "";
    const uint8_t *const start = r->at;
    int rc = read_line(r, line); /* the mark */
    while (rc == 0) {
        if (r->at - start > HEADER_BYTES) return refuse(r, ERR_LIMIT, "the header is too long");
        rc = read_line(r, line);
        if (rc != 0 || line[0] == 0) break;
        rc = take_variable(r, line);
    }
    if (rc == 0) rc = read_line(r, line);
    if (rc == 0) rc = take_resolution(r, line);
    if (rc == 0 && !(r->exposure >= 1e-12 && r->exposure <= 1e12))
        rc = fault_set(r->fault, ERR_RANGE, r->name, "an EXPOSURE of %g is out of range",
                       r->exposure);
    return rc;
}

/* ---- rows ---- */

static int refuse_row(const struct reader *r, int code, uint32_t y, const char *why)
{
    char place[LIMIT_POINTER_BYTES];
    snprintf(place, sizeof place, "%.200s: row %u", r->name, y);
    return fault_set(r->fault, code, place, "%s", why);
}

/* One component of a row: runs of one byte and stretches of different ones. */
static int read_component(struct reader *r, uint32_t y, uint32_t component)
{
    uint8_t *to = r->row + component;
    for (uint32_t x = 0; x < r->width;) {
        if (r->end - r->at < 2) return refuse_row(r, ERR_TRUNCATED, y, "the file ends within it");
        const bool is_run = r->at[0] > 128;
        const uint32_t count = is_run ? r->at[0] - 128u : r->at[0];
        const size_t used = is_run ? 2 : 1 + (size_t)count;
        if (count == 0 || count > r->width - x)
            return refuse_row(r, ERR_CORRUPT, y, "a run does not fit in the row");
        if ((size_t)(r->end - r->at) < used)
            return refuse_row(r, ERR_TRUNCATED, y, "the file ends within it");
        for (uint32_t i = 0; i < count; i++, x++) to[4 * (size_t)x] = r->at[is_run ? 1 : 1 + i];
        r->at += used;
    }
    return 0;
}

/* Flat pixels, among which red = green = blue = 1 means the last pixel again, with counts of eight
 * binary digits each from the lowest on. */
static int read_flat_row(struct reader *r, uint32_t y)
{
    uint32_t shift = 0;
    for (uint32_t x = 0; x < r->width;) {
        if (r->end - r->at < 4) return refuse_row(r, ERR_TRUNCATED, y, "the file ends within it");
        const uint8_t *pixel = r->at;
        r->at += 4;
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            memcpy(r->row + 4 * (size_t)x++, pixel, 4);
            shift = 0;
            continue;
        }
        const uint32_t count = shift <= 16 ? (uint32_t)pixel[3] << shift : UINT32_MAX;
        if (x == 0 || count > r->width - x)
            return refuse_row(r, ERR_CORRUPT, y, "a run does not fit in the row");
        for (uint32_t i = 0; i < count; i++, x++)
            memcpy(r->row + 4 * (size_t)x, r->row + 4 * (size_t)x - 4, 4);
        shift += 8;
    }
    return 0;
}

static int read_row(struct reader *r, uint32_t y)
{
    const bool is_new = r->width >= RUN_WIDTH_MIN && r->width <= RUN_WIDTH_MAX &&
                        r->end - r->at >= 4 && r->at[0] == 2 && r->at[1] == 2 && r->at[2] < 128;
    if (!is_new) return read_flat_row(r, y);
    if ((uint32_t)r->at[2] << 8 != (r->width & 0xff00u) || r->at[3] != (r->width & 0xffu))
        return refuse_row(r, ERR_CORRUPT, y, "its length is not the picture's width");
    r->at += 4;
    int rc = 0;
    for (uint32_t component = 0; rc == 0 && component < 4; component++)
        rc = read_component(r, y, component);
    return rc;
}

static void store_row(const struct reader *r, uint32_t y, struct panorama *out)
{
    const size_t row = r->from_bottom ? r->height - 1 - y : y;
    for (uint32_t x = 0; x < r->width; x++) {
        const uint8_t *pixel = r->row + 4 * (size_t)x;
        float *to = out->texels + 3 * (row * r->width + (r->from_right ? r->width - 1 - x : x));
        for (int c = 0; c < 3; c++) to[c] = (float)pixel[c] * r->scale[pixel[3]];
    }
}

static int read_rows(struct reader *r, struct panorama *out)
{
    int rc = panorama_create(out, r->width, r->height, r->name, r->fault);
    if (rc != 0) return rc;
    r->row = malloc(4 * (size_t)r->width);
    if (r->row == NULL) return refuse(r, ERR_MEMORY, "no memory for a row");
    for (int e = 1; e < 256; e++) r->scale[e] = (float)(ldexp(1.0, e - 136) / r->exposure);
    for (uint32_t y = 0; rc == 0 && y < r->height; y++) {
        rc = read_row(r, y);
        if (rc == 0) store_row(r, y, out);
    }
    free(r->row);
    return rc;
}

int panorama_read_radiance(const struct file_view *file, const char *name, struct panorama *out,
                           struct warnings *warnings, struct fault *fault)
{
    struct reader r = {.at = file->data,
                       .end = file->data + file->size_bytes,
                       .name = name,
                       .warnings = warnings,
                       .fault = fault,
                       .exposure = 1.0,
                       .width = 1, /* until the header tells */
                       .height = 1};
    *out = (struct panorama){0};
    int rc = read_header(&r);
    if (rc == 0) rc = read_rows(&r, out);
    if (rc != 0) panorama_destroy(out);
    return rc;
}
