#include "server/compare/convolve.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

static void fill_line(const float *row, int32_t width, int32_t radius, enum convolve_border border,
                      double *line)
{
    const double first = border == CONVOLVE_ZERO ? 0.0 : (double)row[0];
    const double last = border == CONVOLVE_ZERO ? 0.0 : (double)row[width - 1];
    for (int32_t i = 0; i < radius; i++) {
        line[i] = first;
        line[radius + width + i] = last;
    }
    for (int32_t x = 0; x < width; x++) line[radius + x] = (double)row[x];
}

static void sum_across(const float *in, int32_t width, int32_t height,
                       const struct convolve_weights *w, enum convolve_border border, double *line,
                       float *out)
{
    for (int32_t y = 0; y < height; y++) {
        const size_t at = (size_t)y * (size_t)width;
        fill_line(in + at, width, w->radius, border, line);
        for (int32_t x = 0; x < width; x++) {
            double sum = 0.0;
            for (int32_t k = 0; k <= 2 * w->radius; k++) sum += w->weight[k] * line[x + k];
            out[at + (size_t)x] = (float)sum;
        }
    }
}

static void sum_down(const float *in, int32_t width, int32_t height,
                     const struct convolve_weights *w, enum convolve_border border, double *line,
                     float *out)
{
    for (int32_t y = 0; y < height; y++) {
        memset(line, 0, (size_t)width * sizeof *line);
        for (int32_t k = 0; k <= 2 * w->radius; k++) {
            int32_t v = y + k - w->radius;
            if (border == CONVOLVE_ZERO && (v < 0 || v >= height)) continue;
            v = v < 0 ? 0 : v >= height ? height - 1 : v;
            const float *row = in + (size_t)v * (size_t)width;
            const double weight = w->weight[k];
            for (int32_t x = 0; x < width; x++) line[x] += weight * (double)row[x];
        }
        for (int32_t x = 0; x < width; x++)
            out[(size_t)y * (size_t)width + (size_t)x] = (float)line[x];
    }
}

int convolve(const float *in, int32_t width, int32_t height, const struct convolve_weights *across,
             const struct convolve_weights *down, enum convolve_border border, float *out)
{
    const size_t area = (size_t)width * (size_t)height;
    float *between = malloc(area * sizeof *between);
    double *line = malloc(((size_t)width + 2 * CONVOLVE_RADIUS_MAX) * sizeof *line);
    const int error = between && line ? 0 : ERR_MEMORY;
    if (!error) {
        sum_across(in, width, height, across, border, line, between);
        sum_down(between, width, height, down, border, line, out);
    }
    free(between);
    free(line);
    return error;
}
