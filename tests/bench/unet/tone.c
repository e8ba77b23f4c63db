#include "tests/bench/unet/tone.h"

#include <math.h>

#define KEY     0.18
#define BLACK   1e-8
#define CELL_PX 16

/* a y up to y_dark, then b y^c + d up to y_mid, then e ln(y + f) + g; x_dark and x_mid are their
 * values there. */
static const float a = 1.41283765e+03f, b = 1.64593172f, c = 4.31384981e-01f, d = -2.94139609e-03f,
                   e = 1.92653254e-01f, f = 6.26026094e-03f, g = 9.98620152e-01f,
                   y_dark = 1.57945760e-06f, y_mid = 3.22087631e-02f, x_dark = 2.23151711e-03f,
                   x_mid = 3.70974749e-01f, largest = 65504.0f;

static float curve(float y)
{
    if (y <= y_dark) return a * y;
    return y <= y_mid ? b * powf(y, c) + d : e * logf(y + f) + g;
}

static float curve_inverse(float x)
{
    if (x <= x_dark) return x / a;
    return x <= x_mid ? powf((x - d) / b, 1.0f / c) : expf((x - g) / e) - f;
}

float tone_forward(float linear)
{
    return curve(linear) / curve(largest);
}

float tone_inverse(float tone)
{
    return curve_inverse(tone * curve(largest));
}

static double luminance(const struct plane *const rgb[3], int32_t x, int32_t y)
{
    static const double weights[3] = {0.212671, 0.715160, 0.072169};
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        const double v = (double)*plane_at(rgb[i], x, y);
        if (v > 0) sum += weights[i] * v;
    }
    return sum;
}

/* The mean luminance of the cell (i, j) of columns * rows cells. */
static double cell_mean(const struct plane *const rgb[3], int32_t i, int32_t j, int32_t columns,
                        int32_t rows)
{
    const int32_t width = rgb[0]->width_px, height = rgb[0]->height_px;
    const int32_t left = i * width / columns, right = (i + 1) * width / columns;
    const int32_t top = j * height / rows, bottom = (j + 1) * height / rows;
    double sum = 0;
    for (int32_t y = top; y < bottom; y++)
        for (int32_t x = left; x < right; x++) sum += luminance(rgb, x, y);
    return sum / ((right - left) * (bottom - top));
}

float tone_exposure(const struct plane *const rgb[3])
{
    const int32_t columns = (rgb[0]->width_px + CELL_PX - 1) / CELL_PX;
    const int32_t rows = (rgb[0]->height_px + CELL_PX - 1) / CELL_PX;
    double sum = 0, count = 0;
    for (int32_t j = 0; j < rows; j++)
        for (int32_t i = 0; i < columns; i++) {
            const double mean = cell_mean(rgb, i, j, columns, rows);
            if (mean <= BLACK) continue;
            sum += log(mean);
            count++;
        }
    return count > 0 ? (float)(KEY / exp(sum / count)) : 1.0f;
}
