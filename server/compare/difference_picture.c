#include "server/compare/difference_picture.h"

#include <math.h>

#include "server/compare/difference.h"

/* Encoded colours, as the screen shows them. */
static const double white[3] = {1, 1, 1}, red[3] = {0.62, 0.02, 0.10}, blue[3] = {0.02, 0.16, 0.58},
                    yellow[3] = {1, 0.85, 0}, black[3] = {0, 0, 0};

struct canvas {
    const struct plane *rgb[3];
};

/* Returns the number that IEC 61966-2-1 encodes to `v`. */
static float linear_of(double v)
{
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

static void put(const struct canvas *canvas, int32_t x, int32_t y, const double encoded[3])
{
    for (int c = 0; c < 3; c++) *plane_at(canvas->rgb[c], x, y) = linear_of(encoded[c]);
}

/* Writes the colour of t, from blue at -1 over white at 0 to red at 1. */
static void put_difference(const struct canvas *canvas, int32_t x, int32_t y, double t)
{
    double mixed[3], size = fmin(fabs(t), 1);
    const double *end = t < 0 ? blue : red;
    for (int c = 0; c < 3; c++) mixed[c] = white[c] + size * (end[c] - white[c]);
    put(canvas, x, y, isfinite(t) ? mixed : yellow);
}

static void put_legend(const struct canvas *canvas, int32_t top)
{
    int32_t width = canvas->rgb[0]->width_px;
    for (int32_t x = 0; x < width; x++)
        for (int32_t y = 0; y < DIFFERENCE_LEGEND_PX; y++)
            put_difference(canvas, x, top + y, (2.0 * x + 1) / width - 1);
    for (int32_t tick = 0; tick < 5 && width >= 5; tick++)
        for (int32_t y = 0; y < DIFFERENCE_LEGEND_PX / 3; y++)
            put(canvas, tick * (width - 1) / 4, top + y, black);
    for (int32_t x = 0; x < width; x++) put(canvas, x, top, black);
}

static double relative_at(const struct plane *reference[3], const struct plane *test[3],
                          double floor_squared, int32_t x, int32_t y)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        double r = (double)*plane_at(reference[c], x, y);
        double e = (double)*plane_at(test[c], x, y) - r, size = sqrt(r * r + floor_squared);
        sum += size > 0 ? e / size : e;
    }
    return sum / 3;
}

int difference_picture(const struct image *reference, const struct image *test, const char *layer,
                       double range, int32_t zoom, struct image **out, struct fault *fault)
{
    static const char *const names[] = {"R", "G", "B"};
    const struct plane *r[3], *t[3];
    struct difference d;
    struct canvas canvas;
    *out = NULL;
    if (!(range > 0) || zoom < 1)
        return fault_set(fault, ERR_RANGE, "", "range %g or zoom %d is not positive", range, zoom);
    int error = image_difference(reference, test, layer, &d, fault); /* it checks both images */
    if (error) return error;
    if (!image_layer_planes(reference, layer, r) || !image_layer_planes(test, layer, t))
        return fault_set(fault, ERR_NOT_FOUND, "", "there is no layer \"%s\"", layer);
    int64_t width = (int64_t)zoom * test->width_px, height = (int64_t)zoom * test->height_px;
    error = width > INT32_MAX || height > INT32_MAX - DIFFERENCE_LEGEND_PX
                ? ERR_LIMIT
                : image_create_named(names, 3, (int32_t)width,
                                     (int32_t)height + DIFFERENCE_LEGEND_PX, out);
    if (error) return fault_set(fault, error, "", "the difference picture cannot be made");
    for (int c = 0; c < 3; c++) canvas.rgb[c] = image_plane(*out, names[c]);
    for (int32_t y = 0; y < (int32_t)height; y++)
        for (int32_t x = 0; x < (int32_t)width; x++)
            put_difference(&canvas, x, y,
                           relative_at(r, t, 0.01 * d.mean * d.mean, x / zoom, y / zoom) / range);
    put_legend(&canvas, (int32_t)height);
    return 0;
}
