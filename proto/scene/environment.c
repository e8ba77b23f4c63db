#include "proto/scene/environment.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "proto/runtime/blob_file.h"
#include "proto/scene/scene.h"

#define ALIGN_BYTES 64u
#define TEXEL_BYTES 12u
#define PI          3.14159265358979323846

/* Returns sin(x) for 0 <= x <= pi/4 by its Taylor series; the first term left out is below
 * 1e-19. */
static double small_sine(double x)
{
    const double s = x * x;
    double sum = 1.0;
    for (int n = 17; n >= 3; n -= 2) sum = 1.0 - s / (double)(n * (n - 1)) * sum;
    return x * sum;
}

double environment_edge(uint32_t row, uint32_t height_px)
{
    if (row > height_px - row) return 2.0 - environment_edge(height_px - row, height_px);
    const double s = small_sine(PI * (double)row / (2.0 * (double)height_px));
    return 2.0 * s * s;
}

/* ---- texels ---- */

static int check_sides(uint32_t width_px, uint32_t height_px, struct fault *fault)
{
    if (width_px < 1 || height_px < 1 || width_px > LIMIT_ENVIRONMENT_SIDE_PX ||
        height_px > LIMIT_ENVIRONMENT_SIDE_PX)
        return fault_set(fault, ERR_LIMIT, "header.width_px",
                         "%u x %u px; a map has 1 to %u on each side", width_px, height_px,
                         LIMIT_ENVIRONMENT_SIDE_PX);
    if ((uint64_t)width_px * height_px > LIMIT_ENVIRONMENT_PIXELS)
        return fault_set(fault, ERR_LIMIT, "header.width_px", "%u x %u px; a map has %u at most",
                         width_px, height_px, LIMIT_ENVIRONMENT_PIXELS);
    return 0;
}

/* Finds what the scan of a row has seen. */
static int refuse_row(const float *row, uint32_t width_px, uint32_t y, struct fault *fault)
{
    uint32_t i = 0;
    while (i + 1 < 3 * width_px && row[i] >= 0.0f && row[i] <= LIMIT_RADIANCE) i++;
    const char *const why = !isfinite(row[i]) ? "is not finite"
                            : row[i] < 0.0f   ? "is negative"
                                              : "is above the limit of radiance";
    char place[LIMIT_POINTER_BYTES];
    snprintf(place, sizeof place, "texels[%u][%u].%c", y, i / 3, "RGB"[i % 3]);
    return fault_set(fault, isfinite(row[i]) ? ERR_RANGE : ERR_NOT_FINITE, place, "%.9g %s",
                     (double)row[i], why);
}

/* Scans a row for its sums and the map's maxima so far. Returns false if a texel is out of range.
 *  */
static bool scan_row(const float *row, uint32_t width_px, double sum[3], float maximum[3])
{
    bool good = true;
    for (int c = 0; c < 3; c++) sum[c] = 0.0;
    for (uint32_t x = 0; x < width_px; x++)
        for (int c = 0; c < 3; c++) {
            const float v = row[3 * x + (uint32_t)c];
            good &= v >= 0.0f && v <= LIMIT_RADIANCE;
            sum[c] += (double)v;
            maximum[c] = v > maximum[c] ? v : maximum[c];
        }
    return good;
}

int environment_describe(uint32_t width_px, uint32_t height_px, const float *texels,
                         struct environment_header *out, struct fault *fault)
{
    int error = check_sides(width_px, height_px, fault);
    if (error) return error;
    double mean[3] = {0.0, 0.0, 0.0};
    struct environment_header h = {
        .magic = ENVIRONMENT_MAGIC, .version = ENVIRONMENT_VERSION, width_px, height_px};
    for (uint32_t y = 0; y < height_px; y++) {
        const float *row = texels + 3 * (size_t)width_px * y;
        double sum[3];
        if (!scan_row(row, width_px, sum, h.maximum)) return refuse_row(row, width_px, y, fault);
        const double share = environment_edge(y + 1, height_px) - environment_edge(y, height_px);
        for (int c = 0; c < 3; c++) mean[c] += sum[c] * share / (2.0 * (double)width_px);
    }
    /* Rounding may lift the mean of a constant map above its only value. */
    for (int c = 0; c < 3; c++)
        h.mean[c] = (float)mean[c] < h.maximum[c] ? (float)mean[c] : h.maximum[c];
    *out = h;
    return 0;
}

/* ---- the blob ---- */

static int check_magic(const struct environment_header *h, struct fault *fault)
{
    if (memcmp(h->magic, SCENE_MAGIC, sizeof h->magic) == 0)
        return fault_set(fault, ERR_MAGIC, "header.magic",
                         "this is a scene, not an environment map");
    if (memcmp(h->magic, ENVIRONMENT_MAGIC, sizeof h->magic) != 0)
        return fault_set(fault, ERR_MAGIC, "header.magic", "this is no environment map");
    if (h->version != ENVIRONMENT_VERSION)
        return fault_set(fault, ERR_VERSION, "header.version",
                         "version %u, while this build reads %u: import the map again", h->version,
                         ENVIRONMENT_VERSION);
    return 0;
}

static int check_size(const struct environment_header *h, size_t size_bytes, struct fault *fault)
{
    int error = check_sides(h->width_px, h->height_px, fault);
    if (error) return error;
    const uint64_t whole_bytes =
        sizeof *h + (uint64_t)h->width_px * h->height_px * TEXEL_BYTES + h->warning_bytes;
    if (size_bytes < whole_bytes)
        return fault_set(fault, ERR_TRUNCATED, "texels", "%llu bytes of which %zu are there",
                         (unsigned long long)whole_bytes, size_bytes);
    if (size_bytes > whole_bytes)
        return fault_set(fault, ERR_TRAILING, "texels", "%llu bytes, but there are %zu",
                         (unsigned long long)whole_bytes, size_bytes);
    if (h->flags & ~(uint32_t)ENVIRONMENT_IS_PHOTOGRAPH)
        return fault_set(fault, ERR_RANGE, "header.flags", "%u has unknown bits", h->flags);
    for (size_t i = 0; i < sizeof h->reserved / sizeof h->reserved[0]; i++)
        if (h->reserved[i] != 0)
            return fault_set(fault, ERR_RANGE, "header.reserved", "%u is not 0", h->reserved[i]);
    return 0;
}

static int check_channel(const struct environment_header *h, const float maximum[3], int c,
                         struct fault *fault)
{
    char place[LIMIT_POINTER_BYTES];
    const float mean = h->mean[c];
    snprintf(place, sizeof place, "header.mean[%d]", c);
    if (!isfinite(mean))
        return fault_set(fault, ERR_NOT_FINITE, place, "%.9g is not finite", (double)mean);
    snprintf(place, sizeof place, "header.maximum[%d]", c);
    if (!isfinite(h->maximum[c]))
        return fault_set(fault, ERR_NOT_FINITE, place, "%.9g is not finite", (double)h->maximum[c]);
    if (!(h->maximum[c] >= maximum[c] && h->maximum[c] <= maximum[c]))
        return fault_set(fault, ERR_RANGE, place, "%.9g, but the texels' is %.9g",
                         (double)h->maximum[c], (double)maximum[c]);
    snprintf(place, sizeof place, "header.mean[%d]", c);
    if (mean < 0.0f || mean > maximum[c])
        return fault_set(fault, ERR_RANGE, place, "%.9g lies outside 0 .. %.9g", (double)mean,
                         (double)maximum[c]);
    return 0;
}

static int check_texels(const struct environment_blob *e, struct fault *fault)
{
    float maximum[3] = {0.0f, 0.0f, 0.0f};
    const uint32_t width_px = e->header->width_px;
    for (uint32_t y = 0; y < e->header->height_px; y++) {
        const float *row = e->texels + 3 * (size_t)width_px * y;
        double sum[3];
        if (!scan_row(row, width_px, sum, maximum)) return refuse_row(row, width_px, y, fault);
    }
    int error = 0;
    for (int c = 0; !error && c < 3; c++) error = check_channel(e->header, maximum, c, fault);
    return error;
}

int environment_open(const void *blob, size_t size_bytes, struct environment_blob *out,
                     struct fault *fault)
{
    const struct environment_header *h = blob;
    *out = (struct environment_blob){0};
    if ((uintptr_t)blob % ALIGN_BYTES != 0)
        return fault_set(fault, ERR_RANGE, "", "the blob does not lie on a 64-byte boundary");
    if (size_bytes < sizeof *h)
        return fault_set(fault, ERR_TRUNCATED, "header", "%zu bytes are no environment map",
                         size_bytes);
    int error = check_magic(h, fault);
    if (!error) error = check_size(h, size_bytes, fault);
    if (error) return error;
    const struct environment_blob e = {blob, size_bytes, h, (const float *)(const void *)(h + 1),
                                       (const char *)blob + size_bytes - h->warning_bytes};
    if (h->warning_bytes > 0 && e.warnings[h->warning_bytes - 1] != '\0')
        return fault_set(fault, ERR_CORRUPT, "warnings", "does not end with a NUL byte");
    error = check_texels(&e, fault);
    if (!error) *out = e;
    return error;
}

int environment_map(const char *path, struct environment_blob *out, struct fault *fault)
{
    const void *blob;
    size_t size_bytes;
    *out = (struct environment_blob){0};
    int error = blob_file_map(path, &blob, &size_bytes, fault);
    if (error) return error;
    error = environment_open(blob, size_bytes, out, fault);
    if (error) blob_file_unmap(blob, size_bytes);
    return error;
}

void environment_unmap(struct environment_blob *e)
{
    blob_file_unmap(e->blob, e->blob_bytes);
    *e = (struct environment_blob){0};
}
