/* Every loop goes over columns that know nothing of each other: all instruction sets compute the
 * same bits. */
#include "server/reconstruct/residual/residual_kernels.h"

#include <math.h>

#include "server/reconstruct/simd/vector.h"

#define TX RESIDUAL_TILE_X

/* Constants of the report that docs/reconstruction.md quotes. */
#define NORMAL_WEIGHT      6.0f
#define NORMAL_WEIGHT_REST 5.0f
#define ALBEDO_WEIGHT      5.0f
#define ROUGHNESS_WEIGHT   80.0f
#define NEARNESS_SHARE     0.06f
#define SLOPE_SHARE        1.0f

/* Patches are summed over many pixels: one must not drown the others by more than this. */
#define DISTANCE_MAX 1e4f

/* What is below is no noise but rounding. */
#define VARIANCE_MIN 1e-30f

/* An exponent is in units of a float's last bit, so that whole numbers take one from another. */
#define EXPONENT_UNIT 8388608.0f /* 2^23 */
#define EXPONENT_MAX  (30.0f * EXPONENT_UNIT)
#define LOG2_E        1.442695f

#define WEIGHT_MIN 9.313225746154785e-10f /* 2^-30 */

/* 2^-x by straight lines between whole x, less what is left at 30: there and farther on 0. */
static inline simd_vector power_of_half(simd_vector units)
{
    const simd_mask below =
        __builtin_convertvector(simd_min(units, simd_same(EXPONENT_MAX)), simd_mask);
    return (simd_vector)((127 << 23) - below) - WEIGHT_MIN;
}

static void compare_row(const struct residual_features *f, struct residual_tap tap, size_t at,
                        size_t width, float *restrict diffuse, float *restrict rest)
{
    const size_t n = f->shape.plane;
    const ptrdiff_t o = (ptrdiff_t)tap.y * (ptrdiff_t)f->shape.stride + tap.x;
    const float dx = (float)tap.x, dy = (float)tap.y;
    const float *restrict nx = f->normal + at, *restrict ny = nx + n, *restrict nz = ny + n;
    const float *restrict r = f->albedo + at, *restrict g = r + n, *restrict b = g + n;
    const float *restrict z = f->nearness + at, *restrict zx = f->slope_x + at;
    const float *restrict al = f->alpha + at, *restrict gloss = f->gloss + at;
    const float *restrict zy = f->slope_y + at, *restrict barred = f->barred + at + o;
    const float units = LOG2_E * EXPONENT_UNIT;
    for (ptrdiff_t x = 0; x < (ptrdiff_t)width; x++) {
        const float a = nx[x] - nx[x + o], c = ny[x] - ny[x + o], e = nz[x] - nz[x + o];
        const float turn = a * a + c * c + e * e;
        const float along = zx[x] * dx, down = zy[x] * dy;
        const float off = z[x + o] - z[x] - along - down;
        const float width_z =
            NEARNESS_SHARE * z[x] + SLOPE_SHARE * (fabsf(along) + fabsf(down)) + 1e-30f;
        const float step = off / width_z, bend = step * step;
        const float red = r[x] - r[x + o], green = g[x] - g[x + o], blue = b[x] - b[x + o];
        const float color = red * red + green * green + blue * blue;
        const float exponent = NORMAL_WEIGHT * turn + (bend < 1e4f ? bend : 1e4f) + barred[x];
        diffuse[x] = units * exponent;
        const float rough = al[x] - al[x + o];
        rest[x] = units * (exponent + (NORMAL_WEIGHT_REST + gloss[x] * gloss[x + o]) * turn +
                           ALBEDO_WEIGHT * color + ROUGHNESS_WEIGHT * rough * rough);
    }
}

static void kernel_compare_features(const struct residual_features *f,
                                    const struct residual_tap *taps, uint32_t count,
                                    struct residual_tile *tile)
{
    for (uint32_t k = 0; k < count; k++)
        for (size_t y = 0; y < tile->height; y++)
            compare_row(f, taps[k], tile->base + y * f->shape.stride, tile->width,
                        tile->exponent[0][k] + y * TX, tile->exponent[1][k] + y * TX);
}

/* Differences of guides beyond their noise, over it. */
static inline void compare_guides(const float *restrict g, const float *restrict v, ptrdiff_t o,
                                  size_t count, float sharpness, float *restrict out)
{
    for (size_t x = 0; x < count; x += SIMD_PER_VECTOR) {
        const simd_vector d = simd_load_vector(g + x) - simd_load_vector(g + x + o);
        const simd_vector here = simd_load_vector(v + x), there = simd_load_vector(v + x + o);
        const simd_vector excess = d * d - here - simd_min(here, there);
        const simd_vector distance = excess * sharpness / (here + there + VARIANCE_MIN);
        *(simd_vector *)(out + x) = simd_min(distance, simd_same(DISTANCE_MAX));
    }
}

/* Sums over the patch's columns. */
static inline void sum_across(const float *restrict d, int32_t patch_px, size_t width,
                              float *restrict out)
{
    for (size_t x = 0; x < width; x += SIMD_PER_VECTOR) {
        simd_vector sum = simd_load_vector(d + x) + simd_load_vector(d + x + 1);
        if (patch_px == 3)
            sum = (sum + (simd_load_vector(d + x + 2) + simd_load_vector(d + x + 3))) +
                  ((simd_load_vector(d + x + 4) + simd_load_vector(d + x + 5)) +
                   simd_load_vector(d + x + 6));
        else
            sum += simd_load_vector(d + x + 2);
        *(simd_vector *)(out + x) = sum;
    }
}

static inline void add_rows(const float *restrict a, size_t width, float *restrict out)
{
    for (size_t x = 0; x < width; x += SIMD_PER_VECTOR)
        *(simd_vector *)(out + x) =
            *(const simd_vector *)(a + x) + *(const simd_vector *)(a + x + TX);
}

/* Sums of distances over the rows and columns around the tile. */
static inline void sum_patches(int32_t p, const float *guide, const float *variance, size_t stride,
                               ptrdiff_t o, float sharpness, struct residual_tile *tile,
                               struct residual_patches *out)
{
    const size_t rows = tile->height + 2 * (size_t)p;
    const size_t columns =
        (tile->width + 2 * (size_t)p + SIMD_PER_VECTOR - 1) / SIMD_PER_VECTOR * SIMD_PER_VECTOR;
    const size_t first = tile->base - (size_t)p * stride - (size_t)p;
    for (size_t y = 0; y < rows; y++)
        compare_guides(guide + first + y * stride, variance + first + y * stride, o, columns,
                       sharpness, tile->distance + y * RESIDUAL_COLUMNS);
    for (size_t y = 0; y < rows; y++)
        sum_across(tile->distance + y * RESIDUAL_COLUMNS, p, tile->width, out->across + y * TX);
    for (size_t y = 0; p == 3 && y + 1 < rows; y++)
        add_rows(out->across + y * TX, tile->width, out->pairs + y * TX);
}

/* What rough lobes show has no sharp edges: between pixels of one flat surface a difference of the
 * rest counts less, down to ROUGH_COUNTS. */
#define ROUGH_FROM    0.01f /* alpha */
#define ROUGH_TO      0.06f
#define ROUGH_COUNTS  0.25f
#define FLAT_EXPONENT 0.02f /* of features: as far apart pixels show no flat surface */

/* Returns how much less differences count between pixels of a flat surface. */
static inline simd_vector find_leeway(const float *alpha)
{
    const simd_vector t = (simd_load_vector(alpha) - ROUGH_FROM) * (1.0f / (ROUGH_TO - ROUGH_FROM));
    return (1.0f - ROUGH_COUNTS) * simd_max(simd_min(t, simd_same(1.0f)), simd_same(0.0f));
}

static inline simd_vector find_flat(simd_vector exponent)
{
    const float most = FLAT_EXPONENT * LOG2_E * EXPONENT_UNIT;
    return simd_max(1.0f - exponent * (1.0f / most), simd_same(0.0f));
}

/* Weights of pixels from sums over patches' columns, and of seven rows from those of two. */
static inline simd_vector weigh(const struct residual_patches *patches, size_t i, int32_t p,
                                simd_vector exponent, bool rest, simd_vector leeway)
{
    const float share = LOG2_E * EXPONENT_UNIT / (float)((2 * p + 1) * (2 * p + 1));
    const float *h = patches->across + i, *pairs = patches->pairs + i;
    simd_vector sum;
    if (p == 3)
        sum = (simd_load_vector(pairs) + simd_load_vector(pairs + 2 * TX)) +
              (simd_load_vector(pairs + 4 * TX) + simd_load_vector(h + 6 * TX));
    else
        sum = simd_load_vector(h) + simd_load_vector(h + TX) + simd_load_vector(h + 2 * TX);
    simd_vector distance = simd_max(sum, simd_same(0.0f)) * share;
    if (rest) distance *= 1.0f - leeway * find_flat(exponent);
    return power_of_half(distance + exponent);
}

/* What taps are added to and taken from, of a row of the tile. */
struct row {
    const float *from[2]; /* 3 planes each, from the row's first pixel on */
    const float *alpha;
    float *sum[2][3], *weights;
    size_t plane, first; /* of the tile's numbers */
    ptrdiff_t offset[RESIDUAL_TAPS_CHUNK];
    const float *exponent[RESIDUAL_TAPS_CHUNK];
    uint32_t count;
};

static inline void add_channels(const float *from, size_t plane, ptrdiff_t o, simd_vector w,
                                const simd_vector own[3], simd_vector sum[3])
{
    for (size_t c = 0; c < 3; c++) sum[c] += w * (simd_load_vector(from + c * plane + o) - own[c]);
}

/* Adds all taps to one vector of pixels. */
static inline void add_vector(const struct row *r, int halves, int32_t p, bool rest, size_t x,
                              struct residual_tile *tile)
{
    const simd_vector leeway = rest ? find_leeway(r->alpha + x) : simd_same(0.0f);
    simd_vector own[2][3], sum[2][3], weights = *(simd_vector *)(r->weights + x);
    for (int h = 0; h < halves; h++)
        for (size_t c = 0; c < 3; c++) {
            own[h][c] = simd_load_vector(r->from[h] + c * r->plane + x);
            sum[h][c] = *(simd_vector *)(r->sum[h][c] + x);
        }
    for (uint32_t k = 0; k < r->count; k++) {
        const simd_vector exponent = simd_load_vector(r->exponent[k] + r->first + x);
        const simd_vector w = weigh(&tile->patches[k], r->first + x, p, exponent, rest, leeway);
        weights += w;
        *(simd_vector *)(tile->weight[k] + x) = w;
        for (int h = 0; h < halves; h++)
            add_channels(r->from[h] + x, r->plane, r->offset[k], w, own[h], sum[h]);
    }
    *(simd_vector *)(r->weights + x) = weights;
    for (int h = 0; h < halves; h++)
        for (size_t c = 0; c < 3; c++) *(simd_vector *)(r->sum[h][c] + x) = sum[h][c];
}

static inline void add_row(const struct row *r, int halves, int32_t p, bool rest,
                           struct residual_tile *tile)
{
    for (size_t x = 0; x < tile->width; x += SIMD_PER_VECTOR)
        add_vector(r, halves, p, rest, x, tile);
}

/* A loop for each kind of pass and of light. */
static void add_any_row(const struct row *r, int halves, int32_t p, bool rest,
                        struct residual_tile *tile)
{
    if (halves == 2)
        rest ? add_row(r, 2, 1, true, tile) : add_row(r, 2, 1, false, tile);
    else if (p == 3)
        rest ? add_row(r, 1, 3, true, tile) : add_row(r, 1, 3, false, tile);
    else
        rest ? add_row(r, 1, 1, true, tile) : add_row(r, 1, 1, false, tile);
}

static void add_probe_row(const float *restrict w, const float *restrict s, ptrdiff_t o,
                          size_t width, float *restrict sum)
{
    for (ptrdiff_t x = 0; x < (ptrdiff_t)width; x++) sum[x] += w[x] * (s[x + o] - s[x]);
}

static void add_probes(const struct residual_pass *pass, const struct row *r, const float *probe,
                       const struct residual_tile *tile, float (*sum)[RESIDUAL_TILE])
{
    for (size_t k = 0; k < pass->probes; k++)
        for (uint32_t t = 0; t < r->count; t++)
            add_probe_row(tile->weight[t], probe + k * r->plane, r->offset[t], tile->width,
                          sum[k] + r->first);
}

static void place_row(struct row *r, const struct residual_light *light, int half, int halves,
                      size_t at, struct residual_sums *sums)
{
    for (int h = 0; h < halves; h++) {
        r->from[h] = light->half[half + h] + at;
        for (int c = 0; c < 3; c++) r->sum[h][c] = sums->sum[half + h][c] + r->first;
    }
    r->weights = sums->weights[half] + r->first;
}

static void kernel_add_taps(const struct residual_pass *pass, const struct residual_field *field,
                            enum residual_component component, uint32_t first_tap, uint32_t count,
                            int half, struct residual_tile *tile)
{
    const struct residual_light *light = &field->light[component];
    const struct residual_shape *s = &field->features.shape;
    const int guide = pass->kind == RESIDUAL_CROSS ? 1 - half : 0;
    const int halves = pass->kind == RESIDUAL_JOINT ? 2 : 1;
    struct row row = {.plane = s->plane, .count = count};
    for (uint32_t t = 0; t < count; t++) {
        const struct residual_tap tap = pass->taps[first_tap + t];
        row.offset[t] = (ptrdiff_t)tap.y * (ptrdiff_t)s->stride + tap.x;
        row.exponent[t] = tile->exponent[component == RESIDUAL_REST][t];
        sum_patches(pass->patch_px[component], light->guide[guide], light->variance, s->stride,
                    row.offset[t], pass->sharpness[component], tile, &tile->patches[t]);
    }
    for (size_t y = 0; y < tile->height; y++) {
        const size_t at = tile->base + y * s->stride;
        row.first = y * TX;
        place_row(&row, light, half, halves, at, &tile->sums[component]);
        row.alpha = field->features.alpha + at;
        add_any_row(&row, halves, pass->patch_px[component], component == RESIDUAL_REST, tile);
        if (light->probe[half])
            add_probes(pass, &row, light->probe[half] + at, tile, tile->probes[component][half]);
    }
}

static void kernel_finish(const struct residual_field *field, enum residual_component component,
                          int half, int weights, const struct residual_tile *tile)
{
    const struct residual_shape *s = &field->features.shape;
    const struct residual_light *light = &field->light[component];
    const struct residual_sums *sums = &tile->sums[component];
    for (size_t y = 0; y < tile->height; y++) {
        const size_t at = tile->base + y * s->stride;
        const float *restrict w = sums->weights[weights] + y * TX;
        float part[TX];
        for (size_t x = 0; x < tile->width; x++) part[x] = 1.0f / (1.0f + w[x]);
        for (size_t c = 0; c < 3; c++) {
            const float *restrict from = light->half[half] + at + c * s->plane;
            const float *restrict sum = sums->sum[half][c] + y * TX;
            float *restrict to = light->filtered[half] + at + c * s->plane;
            for (size_t x = 0; x < tile->width; x++) to[x] = from[x] + sum[x] * part[x];
        }
    }
}

static void kernel_finish_probes(const struct residual_field *field,
                                 enum residual_component component, int half,
                                 const struct residual_tile *tile)
{
    const struct residual_shape *s = &field->features.shape;
    const struct residual_light *light = &field->light[component];
    for (size_t y = 0; y < tile->height; y++)
        for (size_t k = 0; k < RESIDUAL_PROBES; k++) {
            const size_t at = tile->base + y * s->stride + k * s->plane;
            const float *restrict from = light->probe[half] + at;
            const float *restrict sum = tile->probes[component][half][k] + y * TX;
            const float *restrict w = tile->sums[component].weights[half] + y * TX;
            float *restrict to = light->probed[half] + at;
            for (size_t x = 0; x < tile->width; x++) to[x] = from[x] + sum[x] / (1.0f + w[x]);
        }
}

const struct residual_kernels KERNELS(residual_kernels) = {
    .compare_features = kernel_compare_features,
    .add_taps = kernel_add_taps,
    .finish = kernel_finish,
    .finish_probes = kernel_finish_probes,
};
