/* exr_calibration REFERENCE.exr REFERENCE.exr TEST.exr: how well a picture knows its own error. The
 * two references are independent: their mean is the truth, and their difference tells how far that
 * is off, which is taken from what the test seems to be off. Prints one JSON line:
 *   error     RMS over pixels and R, G, B of test less truth, over the truth's mean luminance
 *   estimate  that of the test's layer `error`
 *   within    the share of all numbers that are off by at most two of their estimates, where the
 *             truth's own error, as it is around, is added to the estimate, and the rounding of
 *             references that are half floats
 *   mean      the truth's mean luminance
 *   samples   the mean of the test's layer `samples`, if it has one */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "server/image/exr.h"

struct calibration {
    struct image *images[3]; /* owned: two references, the test */
    double off, noise, estimate, luminance;
    int64_t numbers, within;
};

static int complain(const char *path, const char *text)
{
    fprintf(stderr, "exr_calibration: %s: %s\n", path, text);
    return -1;
}

static int read_all(char **paths, struct calibration *c)
{
    struct fault fault = {0};
    for (int k = 0; k < 3; k++) {
        if (exr_read(paths[k], &c->images[k], &fault)) return complain(paths[k], fault.detail);
        if (c->images[k]->width_px != c->images[0]->width_px ||
            c->images[k]->height_px != c->images[0]->height_px)
            return complain(paths[k], "another size than the first");
    }
    return 0;
}

static double at(const struct plane *plane, int32_t x, int32_t y)
{
    return (double)*plane_at(plane, x, y);
}

/* The truth's squared error, from the references' difference over 7 x 7 pixels. */
static double noise_at(const struct plane *a, const struct plane *b, int32_t x, int32_t y)
{
    double sum = 0;
    int count = 0;
    for (int32_t v = y > 3 ? y - 3 : 0; v <= y + 3 && v < a->height_px; v++)
        for (int32_t u = x > 3 ? x - 3 : 0; u <= x + 3 && u < a->width_px; u++, count++) {
            const double apart = at(a, u, v) - at(b, u, v);
            sum += 0.25 * apart * apart;
        }
    return sum / count;
}

/* The squared error of a number that was rounded to a half float, 0 where it has more bits. */
static double rounding_at(const struct plane *plane, int32_t x, int32_t y)
{
    const float v = *plane_at(plane, x, y);
    const double most = (double)v * 0x1p-11;
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits & 0x1fffu ? 0.0 : most * most / 3;
}

static void add(const struct plane *const a, const struct plane *const b,
                const struct plane *const test, const struct plane *const error, double weight,
                struct calibration *c)
{
    for (int32_t y = 0; y < a->height_px; y++)
        for (int32_t x = 0; x < a->width_px; x++) {
            const double truth = 0.5 * (at(a, x, y) + at(b, x, y)), off = at(test, x, y) - truth;
            const double apart = at(a, x, y) - at(b, x, y), estimate = at(error, x, y);
            c->off += off * off;
            c->noise += 0.25 * apart * apart;
            c->estimate += estimate * estimate;
            c->luminance += weight * truth;
            const double allowed =
                estimate * estimate + noise_at(a, b, x, y) + rounding_at(a, x, y);
            c->within += off * off <= 4 * allowed + 1e-12 * truth * truth;
            c->numbers++;
        }
}

static int compare(char **paths, struct calibration *c)
{
    static const double weights[] = {0.2126, 0.7152, 0.0722};
    const struct plane *colour[3][3], *error[3];
    if (read_all(paths, c)) return -1;
    for (int k = 0; k < 3; k++)
        if (!image_layer_planes(c->images[k], "beauty", colour[k]))
            return complain(paths[k], "no layer beauty");
    if (!image_layer_planes(c->images[2], "error", error))
        return complain(paths[2], "no layer error");
    for (int i = 0; i < 3; i++)
        add(colour[0][i], colour[1][i], colour[2][i], error[i], weights[i], c);
    return 0;
}

/* Below 0: the picture does not tell. */
static double mean_samples(const struct image *image)
{
    const struct plane *plane = image_plane(image, "samples.N");
    double sum = 0;
    if (!plane) return -1;
    for (int32_t y = 0; y < image->height_px; y++)
        for (int32_t x = 0; x < image->width_px; x++) sum += at(plane, x, y);
    return sum / ((double)image->width_px * image->height_px);
}

int main(int argc, char **argv)
{
    struct calibration c = {.off = 0};
    if (argc != 4) {
        fprintf(stderr, "usage: exr_calibration REFERENCE.exr REFERENCE.exr TEST.exr\n");
        return 2;
    }
    int rc = compare(argv + 1, &c) ? 1 : 0;
    if (rc == 0) {
        const double n = (double)c.numbers, mean = c.luminance / (n / 3);
        const double samples = mean_samples(c.images[2]);
        printf("{\"error\":%.6g,\"estimate\":%.6g,\"within\":%.4f,\"mean\":%.6g",
               sqrt(fmax(c.off - c.noise, 0) / n) / mean, sqrt(c.estimate / n) / mean,
               (double)c.within / n, mean);
        if (samples >= 0) printf(",\"samples\":%.6g", samples);
        printf("}\n");
    }
    for (int k = 0; k < 3; k++) image_destroy(&c.images[k]);
    return rc;
}
