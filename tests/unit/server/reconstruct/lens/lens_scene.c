#include "tests/unit/server/reconstruct/lens/lens_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static float lens_texture(float x, float y, float f, float rgb[3])
{
    const float wave = 0.5f + 0.25f * sinf(x * f) + 0.25f * sinf(y * f * 0.8f + 1.0f);
    const float check = ((int)floorf(x * f * 0.25f) + (int)floorf(y * f * 0.25f)) & 1 ? 0.3f : 0.0f;
    rgb[0] = 0.2f + 0.6f * wave;
    rgb[1] = 0.1f + 0.5f * wave + check;
    rgb[2] = 0.6f - 0.4f * wave + check;
    return f;
}

/* What point (x, y) of the picture shows through point (u, v) of the lens; its slope. */
static float lens_shade(enum lens_scene scene, float x, float y, float u, float v, float rgb[3])
{
    const float cx = x + 5.0f * u, cy = y + 5.0f * v;
    switch (scene) {
    case LENS_PLANES:
        if (x + 4.5f * u < 32.0f) {
            lens_texture(x + 4.5f * u, y + 4.5f * v, 0.5f, rgb);
            return 4.5f;
        }
        if (x + 0.2f * u < 56.0f) {
            lens_texture(x + 0.2f * u, y + 0.2f * v, 0.2f, rgb);
            return 0.2f;
        }
        lens_texture(x - 2.7f * u, y - 2.7f * v, 0.6f, rgb);
        return -2.7f;
    case LENS_FENCE:
        if (fmodf(cx + 300.0f, 24.0f) < 5.0f) {
            rgb[0] = 0.1f, rgb[1] = 0.25f, rgb[2] = 0.1f;
            return 5.0f;
        }
        if (fabsf(x - 48.0f) < 20.0f && fabsf(y - 50.0f) < 30.0f) {
            lens_texture(x, y, 0.8f, rgb);
            return 0.0f;
        }
        lens_texture(x - 3.6f * u, y - 3.6f * v, 0.35f, rgb);
        return -3.6f;
    case LENS_LAMPS: {
        const float lx = x - 9.0f * u, ly = y - 9.0f * v;
        if ((cx - 30.0f) * (cx - 30.0f) + (cy - 62.0f) * (cy - 62.0f) < 300.0f) {
            lens_texture(cx, cy, 0.4f, rgb);
            return 5.0f;
        }
        const float dx = fmodf(lx + 340.0f, 34.0f) - 17.0f, dy = fmodf(ly + 290.0f, 29.0f) - 14.5f;
        const bool lamp = dx * dx + dy * dy < 2.0f;
        rgb[0] = lamp ? 30.0f : 0.05f, rgb[1] = lamp ? 24.0f : 0.06f, rgb[2] = lamp ? 12.0f : 0.1f;
        return -9.0f;
    }
    default: {
        const float k = 0.08f, row = (y - 48.0f * k * v) / (1.0f - k * v), s = (row - 48.0f) * k;
        lens_texture(x + s * u, row, 0.6f, rgb);
        return s;
    }
    }
}

void lens_picture_create_seeded(enum lens_scene scene, uint32_t l, uint32_t blades, uint32_t seed,
                                struct lens_picture *out)
{
    const size_t area = (size_t)LENS_SIDE * LENS_SIDE, n = (size_t)l * l;
    memset(out, 0, sizeof *out);
    out->plan.width_px = out->plan.height_px = LENS_SIDE;
    out->plan.pattern = (struct pattern){seed, 1};
    out->plan.camera.aperture_radius = 1.0f;
    out->plan.camera.blade_count = blades;
    out->plan.camera.blade_rotation_rad = 0.2f;
    out->plan.lens_strata_per_axis = l;
    out->plan.lens_filter = LENS_FILTER_SHEARED;
    out->plan.planes = PLANE_BIT(LENS_RADIANCE) | PLANE_BIT(LENS_SLOPE);
    out->plan.radiance_scale = out->plan.mu = 1.0f;
    out->patch.rect = out->patch.core = (struct rect){0, 0, LENS_SIDE, LENS_SIDE};
    out->patch.lens_radiance = malloc(n * 3 * area * sizeof(float));
    out->patch.lens_slope = malloc(n * area * sizeof(float));
    out->out[0] = calloc(4 * area, sizeof(float));
    for (int k = 1; k < 4; k++) out->out[k] = out->out[0] + (size_t)k * area;
    struct lens_pattern pattern;
    lens_pattern_init(&pattern, &out->plan);
    for (size_t p = 0; p < area; p++) {
        const int32_t x = (int32_t)(p % LENS_SIDE), y = (int32_t)(p / LENS_SIDE);
        for (uint32_t j = 0; j < n; j++) {
            float u[2], at[2], rgb[3];
            lens_pattern_at(&pattern, x, y, j / l, j % l, u);
            pattern_shuffled(&out->plan.pattern, x, y, PATTERN_PIXEL, l, j, at);
            out->patch.lens_slope[j * area + p] =
                lens_shade(scene, (float)x + at[0], (float)y + at[1], u[0], u[1], rgb);
            for (uint32_t c = 0; c < 3; c++)
                out->patch.lens_radiance[(j * 3 + c) * area + p] = rgb[c];
        }
    }
}

void lens_picture_destroy(struct lens_picture *p)
{
    free(p->patch.lens_radiance);
    free(p->patch.lens_slope);
    free(p->out[0]);
}

#define LATTICE_MOST 4096

/* A four-dimensional lattice (Roberts' R4): over the lens, and over a pixel. */
static void lens_lattice(uint32_t blades, int count, float u[][2], double at[][2])
{
    static const double step[4] = {0.856674883854502, 0.733891856627126, 0.628706721037807,
                                   0.538597257223612};
    struct plan plan = {.camera = {.blade_count = blades, .blade_rotation_rad = 0.2f}};
    struct lens_aperture aperture;
    lens_aperture_init(&plan.camera, &aperture);
    for (int k = 0; k < count; k++) {
        float left, right;
        u[k][1] = lens_aperture_height(&aperture, (float)(k * step[0] - floor(k * step[0])));
        lens_aperture_chord(&aperture, u[k][1], &left, &right);
        u[k][0] = left + (right - left) * (float)(k * step[1] - floor(k * step[1]));
        for (int d = 0; d < 2; d++) at[k][d] = k * step[2 + d] - floor(k * step[2 + d]);
    }
}

static float lens_wrap(double at)
{
    return (float)(at < 1.0 ? at : at - 1.0);
}

float *lens_reference(enum lens_scene scene, uint32_t blades)
{
    static float u[LATTICE_MOST][2];
    static double at[LATTICE_MOST][2];
    const size_t area = (size_t)LENS_SIDE * LENS_SIDE;
    const int count = scene == LENS_LAMPS ? LATTICE_MOST : 1024; /* few rays meet a lamp */
    float *out = calloc(4 * area, sizeof(float));
    lens_lattice(blades, count, u, at);
    for (size_t p = 0; p < area; p++) {
        float least = 1e9f, most = -1e9f;
        out[3 * area + p] = -1.0f;
        if (p % LENS_SIDE % 2 || p / LENS_SIDE % 2) continue;
        /* another place of the lattice in each pixel */
        const double shift = (double)p * 0.381966 - floor((double)p * 0.381966);
        for (int k = 0; k < count; k++) {
            float rgb[3];
            const float x = (float)(p % LENS_SIDE) + lens_wrap(at[k][0] + shift);
            const float y = (float)(p / LENS_SIDE) + lens_wrap(at[k][1] + shift);
            const float s = lens_shade(scene, x, y, u[k][0], u[k][1], rgb);
            for (size_t c = 0; c < 3; c++) out[c * area + p] += rgb[c] / (float)count;
            least = fminf(least, s);
            most = fmaxf(most, s);
        }
        const bool focused = least > -1.0f && most < 1.0f;
        out[3 * area + p] = most - least > 1.0f || focused ? 1.0f : 0.0f;
    }
    return out;
}

struct lens_error lens_error_of(const struct lens_picture *p, const float *reference)
{
    const size_t area = (size_t)LENS_SIDE * LENS_SIDE;
    double all = 0.0, away = 0.0, sum = 0.0, pixels = 0.0, count = 0.0;
    for (size_t i = 0; i < area; i++) {
        double square = 0.0;
        if (reference[3 * area + i] < 0.0f) continue;
        for (size_t c = 0; c < 3; c++) {
            const double d = (double)p->out[c][i] - (double)reference[c * area + i];
            square += d * d / 3.0;
            sum += (double)reference[c * area + i] / 3.0;
        }
        all += square;
        pixels += 1.0;
        if (reference[3 * area + i] > 0.0f) continue;
        away += square;
        count += 1.0;
    }
    const double mean = sum / pixels;
    return (struct lens_error){sqrt(all / pixels) / mean,
                               count > 0.0 ? sqrt(away / count) / mean : 0.0};
}

int lens_run(struct lens_picture *p, uint32_t filter, struct lens_statistics *statistics)
{
    p->plan.lens_filter = filter;
    *statistics = (struct lens_statistics){0};
    return lens_filter(&p->plan, &p->patch, p->patch.rect, p->out, p->out[3], statistics);
}
