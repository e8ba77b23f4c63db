/* Every loop goes over columns that know nothing of each other: all instruction sets compute the
 * same bits. */
#include "server/reconstruct/residual/residual_kernels.h"

#include <math.h>

#include "server/reconstruct/simd/lanes_vector.h"

#define TX RESIDUAL_TILE_X
#define TY RESIDUAL_TILE_Y

/* Constants of the report that docs/reconstruction.md quotes. */
#define NORMAL_WEIGHT      5.0f
#define NORMAL_WEIGHT_REST 10.0f
#define ALBEDO_WEIGHT      5.0f
#define REST_SHARPER       1.5f /* highlights have edges that no feature tells */
#define ROUGHNESS_WEIGHT   80.0f
#define DEPTH_SHARE        0.03f
#define SLOPE_SHARE        0.25f

/* Patches are summed over many pixels: one must not drown the others by more than this. */
#define DISTANCE_MOST 1e4f

/* What is below is no noise but rounding. */
#define VARIANCE_LEAST 1e-30f

/* Pixels of a row whose variances are found at a time. */
#define VARIANCE_RUN 256

/* Light above counts as much to guides: squares of differences stay finite. */
#define GUIDE_MOST 1e15f

/* Channels of a guide have weights of their own, or pure colours of one brightness would be alike.
 */
#define GUIDE_RED   0.8f
#define GUIDE_GREEN 1.3f
#define GUIDE_BLUE  0.9f

#define LOG2_E 1.442695f

/* 2^-x, relative error below 1e-4; from 30 on 0. */
static inline lanes_vector power_of_half(lanes_vector x)
{
    const lanes_chosen weighs = lanes_below(x, lanes_same(30.0f));
    const lanes_vector in = lanes_least(x, lanes_same(30.0f));
    const lanes_mask whole = __builtin_convertvector(in, lanes_mask);
    const lanes_vector f = in - __builtin_convertvector(whole, lanes_vector);
    const lanes_vector p =
        1.0f + f * (-0.6931472f + f * (0.2402265f + f * (-0.0555041f + f * 0.0078f)));
    const lanes_mask power = (127 - whole) << 23;
    return lanes_only(weighs, p * (lanes_vector)power);
}

static void compare_row(const struct residual_features *f, struct residual_tap tap, size_t at,
                        float *restrict diffuse, float *restrict rest)
{
    const size_t n = f->shape.plane;
    const ptrdiff_t o = (ptrdiff_t)tap.y * (ptrdiff_t)f->shape.stride + tap.x;
    const float dx = (float)tap.x, dy = (float)tap.y;
    const float *restrict nx = f->normal + at, *restrict ny = nx + n, *restrict nz = ny + n;
    const float *restrict r = f->albedo + at, *restrict g = r + n, *restrict b = g + n;
    const float *restrict z = f->depth + at, *restrict zx = f->slope_x + at;
    const float *restrict al = f->alpha + at;
    const float *restrict zy = f->slope_y + at, *restrict barred = f->barred + at + o;
    for (ptrdiff_t x = 0; x < TX; x++) {
        const float a = nx[x] - nx[x + o], c = ny[x] - ny[x + o], e = nz[x] - nz[x + o];
        const float turn = a * a + c * c + e * e;
        const float along = zx[x] * dx, down = zy[x] * dy;
        const float off = z[x + o] - z[x] - along - down;
        const float width =
            DEPTH_SHARE * z[x] + SLOPE_SHARE * (fabsf(along) + fabsf(down)) + 1e-30f;
        const float step = off / width, bend = step * step;
        const float red = r[x] - r[x + o], green = g[x] - g[x + o], blue = b[x] - b[x + o];
        const float color = red * red + green * green + blue * blue;
        const float exponent = NORMAL_WEIGHT * turn + (bend < 1e4f ? bend : 1e4f) + barred[x];
        diffuse[x] = LOG2_E * exponent;
        const float rough = al[x] - al[x + o];
        rest[x] = LOG2_E * (exponent + NORMAL_WEIGHT_REST * turn + ALBEDO_WEIGHT * color +
                            ROUGHNESS_WEIGHT * rough * rough);
    }
}

static void kernel_compare_features(const struct residual_features *f,
                                    const struct residual_tap *taps, uint32_t count, size_t base,
                                    struct residual_tile *tile)
{
    for (uint32_t k = 0; k < count; k++)
        for (size_t y = 0; y < TY; y++)
            compare_row(f, taps[k], base + y * f->shape.stride, tile->exponent[0][k] + y * TX,
                        tile->exponent[1][k] + y * TX);
}

/* Differences of guides beyond their noise, over it. */
static inline void compare_guides(const float *restrict g, const float *restrict v, ptrdiff_t o,
                                  int32_t count, float sharpness, float *restrict out)
{
    for (ptrdiff_t x = 0; x < count; x++) {
        const float d = g[x] - g[x + o], here = v[x], there = v[x + o];
        const float excess = d * d - here - (here < there ? here : there);
        const float distance = excess * sharpness / (here + there + VARIANCE_LEAST);
        out[x] = distance < DISTANCE_MOST ? distance : DISTANCE_MOST;
    }
}

/* Sums over the patch's columns. */
static inline void sum_across(const float *restrict d, int32_t patch_px, float *restrict out)
{
    if (patch_px == 3)
        for (size_t x = 0; x < TX; x++)
            out[x] =
                ((d[x] + d[x + 1]) + (d[x + 2] + d[x + 3])) + ((d[x + 4] + d[x + 5]) + d[x + 6]);
    else
        for (size_t x = 0; x < TX; x++) out[x] = d[x] + d[x + 1] + d[x + 2];
}

/* Weights of a row from sums over patches: across[y .. y + 2 patch_px], seven of them by pairs. */
static inline void weigh_row(const float *h, const float *pairs, const float *exponent,
                             int32_t patch_px, float *out)
{
    const float share = LOG2_E / (float)((2 * patch_px + 1) * (2 * patch_px + 1));
    for (size_t x = 0; x < TX; x += LANES_PER_VECTOR) {
        lanes_vector sum;
        if (patch_px == 3)
            sum = (lanes_load_vector(pairs + x) + lanes_load_vector(pairs + 2 * TX + x)) +
                  (lanes_load_vector(pairs + 4 * TX + x) + lanes_load_vector(h + 6 * TX + x));
        else
            sum = lanes_load_vector(h + x) + lanes_load_vector(h + TX + x) +
                  lanes_load_vector(h + 2 * TX + x);
        const lanes_vector apart = lanes_only(lanes_below(lanes_same(0.0f), sum), sum * share);
        *(lanes_vector *)(out + x) = power_of_half(apart + lanes_load_vector(exponent + x));
    }
}

static inline void add_probe_row(const float *restrict w, const float *restrict s, ptrdiff_t o,
                                 float *restrict sum)
{
    for (ptrdiff_t x = 0; x < TX; x++) sum[x] += w[x] * (s[x + o] - s[x]);
}

static inline void add_row(const float *restrict w, const float *restrict s, size_t plane,
                           ptrdiff_t o, float *restrict r, float *restrict g, float *restrict b)
{
    const float *restrict s1 = s + plane, *restrict s2 = s1 + plane;
    for (ptrdiff_t x = 0; x < TX; x++) {
        r[x] += w[x] * (s[x + o] - s[x]);
        g[x] += w[x] * (s1[x + o] - s1[x]);
        b[x] += w[x] * (s2[x + o] - s2[x]);
    }
}

/* Sums of distances over the rows and columns around the tile. */
static void sum_patches(const struct residual_pass *pass, const float *guide, const float *variance,
                        const struct residual_features *f, ptrdiff_t o, float sharpness,
                        size_t base, struct residual_tile *tile)
{
    const int32_t p = pass->patch_px, rows = TY + 2 * p;
    const size_t first = base - (size_t)p * f->shape.stride - (size_t)p;
    for (int32_t y = 0; y < rows; y++) {
        const size_t at = first + (size_t)y * f->shape.stride;
        compare_guides(guide + at, variance + at, o, TX + 2 * p, sharpness, tile->distance);
        sum_across(tile->distance, p, tile->across + y * TX);
    }
    const float *restrict h = tile->across;
    float *restrict pairs = tile->pairs;
    for (size_t i = 0; p == 3 && i < (size_t)(rows - 1) * TX; i++) pairs[i] = h[i] + h[i + TX];
}

static void kernel_add_taps(const struct residual_pass *pass, const struct residual_field *field,
                            enum residual_component component, uint32_t first_tap, uint32_t count,
                            int half, size_t base, struct residual_tile *tile)
{
    const struct residual_features *f = &field->features;
    const struct residual_light *light = &field->light[component];
    const size_t stride = f->shape.stride, plane = f->shape.plane;
    const int guide = pass->kind == RESIDUAL_CROSS ? 1 - half : 0;
    const int end = pass->kind == RESIDUAL_JOINT ? 2 : half + 1;
    struct residual_sums *sums = &tile->sums[component];
    for (uint32_t t = 0; t < count; t++) {
        const struct residual_tap tap = pass->taps[first_tap + t];
        const ptrdiff_t o = (ptrdiff_t)tap.y * (ptrdiff_t)stride + tap.x;
        const float *exponent = tile->exponent[component == RESIDUAL_REST][t];
        sum_patches(pass, light->guide[guide], light->variance, f, o,
                    component == RESIDUAL_REST ? pass->sharpness * REST_SHARPER : pass->sharpness,
                    base, tile);
        for (size_t y = 0; y < TY; y++) {
            const size_t row = y * TX, at = base + y * stride;
            weigh_row(tile->across + row, tile->pairs + row, exponent + row, pass->patch_px,
                      tile->weight);
            for (size_t x = 0; x < TX; x++) sums->weights[half][row + x] += tile->weight[x];
            for (int j = half; j < end; j++)
                add_row(tile->weight, light->half[j] + at, plane, o, sums->sum[j][0] + row,
                        sums->sum[j][1] + row, sums->sum[j][2] + row);
            for (size_t k = 0; k < pass->probes && light->probe[half]; k++)
                add_probe_row(tile->weight, light->probe[half] + k * plane + at, o,
                              tile->probes[component][half][k] + row);
        }
    }
}

static void kernel_finish(const struct residual_field *field, enum residual_component component,
                          int half, int weights, size_t base, const struct residual_tile *tile)
{
    const struct residual_shape *s = &field->features.shape;
    const struct residual_light *light = &field->light[component];
    const struct residual_sums *sums = &tile->sums[component];
    for (size_t y = 0; y < TY; y++)
        for (size_t c = 0; c < 3; c++) {
            const size_t at = base + y * s->stride + c * s->plane;
            const float *restrict from = light->half[half] + at;
            const float *restrict sum = sums->sum[half][c] + y * TX;
            const float *restrict w = sums->weights[weights] + y * TX;
            float *restrict to = light->filtered[half] + at;
            for (size_t x = 0; x < TX; x++) to[x] = from[x] + sum[x] / (1.0f + w[x]);
        }
}

static void kernel_finish_probes(const struct residual_field *field,
                                 enum residual_component component, int half, size_t base,
                                 const struct residual_tile *tile)
{
    const struct residual_shape *s = &field->features.shape;
    const struct residual_light *light = &field->light[component];
    for (size_t y = 0; y < TY; y++)
        for (size_t k = 0; k < RESIDUAL_PROBES; k++) {
            const size_t at = base + y * s->stride + k * s->plane;
            const float *restrict from = light->probe[half] + at;
            const float *restrict sum = tile->probes[component][half][k] + y * TX;
            const float *restrict w = tile->sums[component].weights[half] + y * TX;
            float *restrict to = light->probed[half] + at;
            for (size_t x = 0; x < TX; x++) to[x] = from[x] + sum[x] / (1.0f + w[x]);
        }
}

static void sum_channels(const float *restrict rgb, size_t plane, size_t count, float *restrict out)
{
    for (size_t i = 0; i < count; i++) {
        const float sum =
            GUIDE_RED * rgb[i] + GUIDE_GREEN * rgb[plane + i] + GUIDE_BLUE * rgb[2 * plane + i];
        out[i] = sum < GUIDE_MOST ? (sum > -GUIDE_MOST ? sum : -GUIDE_MOST) : GUIDE_MOST;
    }
}

/* Half the mean of squared differences over 3 x 3 pixels: the variance of one half's guide. */
static void find_variances(const float *restrict a, const float *restrict b, size_t stride,
                           size_t count, float factor, float *restrict out)
{
    float columns[VARIANCE_RUN + 2];
    for (size_t i = 0; i < count + 2; i++) {
        const float d0 = a[i - 1 - stride] - b[i - 1 - stride], d1 = a[i - 1] - b[i - 1],
                    d2 = a[i - 1 + stride] - b[i - 1 + stride];
        columns[i] = d0 * d0 + d1 * d1 + d2 * d2;
    }
    for (size_t i = 0; i < count; i++)
        out[i] = (columns[i] + columns[i + 1] + columns[i + 2]) * factor;
}

static void mix(const float *restrict share, float *restrict a, const float *restrict b,
                size_t count)
{
    for (size_t i = 0; i < count; i++) a[i] = b[i] + share[i] * (a[i] - b[i]);
}

static void kernel_guide(const struct residual_features *f, enum residual_kind kind,
                         struct rect area, struct residual_light *light)
{
    const struct residual_shape *s = &f->shape;
    const size_t count = (size_t)rect_width(area);
    const float factor = kind == RESIDUAL_CROSS ? 1.0f / 18.0f : 1.0f / 36.0f;
    for (int32_t y = area.y0 - 1; y < area.y1 + 1; y++)
        for (int h = 0; h < 2; h++) {
            const size_t at = residual_at(s, area.x0 - 1, y);
            sum_channels(light->half[h] + at, s->plane, count + 2, light->guide[h] + at);
        }
    for (int32_t y = area.y0; y < area.y1; y++) {
        const size_t at = residual_at(s, area.x0, y);
        for (size_t x = 0; x < count; x += VARIANCE_RUN)
            find_variances(light->guide[0] + at + x, light->guide[1] + at + x, s->stride,
                           count - x < VARIANCE_RUN ? count - x : VARIANCE_RUN, factor,
                           light->variance + at + x);
    }
    if (kind == RESIDUAL_CROSS) return;
    for (int32_t y = area.y0; y < area.y1; y++) {
        const size_t at = residual_at(s, area.x0, y);
        mix(f->share + at, light->guide[0] + at, light->guide[1] + at, count);
        for (size_t c = 0; c < 3 && kind == RESIDUAL_MEAN; c++)
            mix(f->share + at, light->half[0] + c * s->plane + at,
                light->half[1] + c * s->plane + at, count);
    }
}

const struct residual_kernels KERNELS(residual_kernels) = {
    .compare_features = kernel_compare_features,
    .add_taps = kernel_add_taps,
    .finish = kernel_finish,
    .finish_probes = kernel_finish_probes,
    .guide = kernel_guide,
};
