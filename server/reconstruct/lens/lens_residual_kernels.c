/* The turns of these plain loops do not depend on each other: the compiler makes vectors of them,
 * with the same operations in the same order for every instruction set. */
#include "server/reconstruct/lens/lens_residual_kernels.h"

#include "server/reconstruct/simd/vector.h"

static void average_few(const float *in, size_t step, uint32_t n, size_t count, float *out,
                        float *squares)
{
    for (size_t x = 0; x < count; x++) {
        float sum = 0.0f, square = 0.0f;
        for (size_t j = 0; j < n; j++) {
            const float v = in[j * step + x];
            sum += v;
            square += v * v;
        }
        out[x] = sum / (float)n;
        squares[x] += square;
    }
}

static void kernel_average(const float *in, size_t step, uint32_t n, size_t count, float *out,
                           float *squares)
{
    size_t x = 0;
    for (; x + SIMD_PER_VECTOR <= count; x += SIMD_PER_VECTOR) {
        simd_vector sum = {0}, square = {0};
        for (size_t j = 0; j < n; j++) {
            const simd_vector v = simd_load_vector(in + j * step + x);
            sum += v;
            square += v * v;
        }
        *(simd_stored *)(out + x) = sum / (float)n;
        *(simd_stored *)(squares + x) += square;
    }
    average_few(in + x, step, n, count - x, out + x, squares + x);
}

static void kernel_add(float *restrict out, const float *restrict in, size_t count)
{
    for (size_t x = 0; x < count; x++) out[x] += in[x];
}

static void kernel_divide(float *numbers, float by, size_t count)
{
    for (size_t x = 0; x < count; x++) numbers[x] /= by;
}

static void kernel_difference(const float *restrict a, const float *restrict b, size_t count,
                              float *restrict out, float *restrict squares)
{
    for (size_t p = 0; p < count; p++) {
        out[p] = a[p] - b[p];
        squares[p] += out[p] * out[p];
    }
}

static void kernel_square(const float *const in[3], size_t count, float *restrict out)
{
    const float *restrict a = in[0], *restrict b = in[1], *restrict c = in[2];
    for (size_t p = 0; p < count; p++) out[p] = a[p] * a[p] + b[p] * b[p] + c[p] * c[p];
}

static void kernel_noise(const float *restrict found, const float *restrict noise,
                         const float *restrict pixels, size_t count, float *restrict squares)
{
    for (size_t p = 0; p < count; p++) {
        const float seen = squares[p] - found[p];
        squares[p] = (seen > noise[p] ? seen : noise[p]) / pixels[p];
    }
}

/* What is to be taken away, pixels give by what they have: those beside brighter ones must not pay
 * for them. Their mean is more than that, as averages are not below 0. */
static void give_channel(const struct lens_residual_planes *r, int c, float factor, size_t count)
{
    const float *restrict found = r->found, *restrict noise = r->noise;
    const float *restrict mean = r->mean[c], *restrict there = r->there[c];
    float *restrict picture = r->picture[c];
    for (size_t p = 0; p < count; p++) {
        const float rest = found[p] - factor * noise[p], part = rest / found[p];
        const float share = rest > 0.0f ? part : 0.0f;
        const float old = picture[p], around = mean[p] + there[p];
        const float more = share * mean[p], most = around - old;
        const int rises = more > 0.0f;
        const int within = (rises & (most > more)) | (!rises & (most < more));
        const int apart = (rises & (most > 0.0f)) | (!rises & (most < 0.0f));
        const float end = apart ? around : old;
        picture[p] = within ? old + more : end;
    }
}

static void kernel_give(const struct lens_residual_planes *r, float factor, size_t count)
{
    for (int c = 0; c < 3; c++) give_channel(r, c, factor, count);
}

static void kernel_give_own(const struct lens_residual_planes *r, float factor, float slope,
                            float n, size_t count)
{
    const float *restrict a = r->average[0], *restrict b = r->average[1],
                          *restrict c = r->average[2];
    float *restrict x = r->picture[0], *restrict y = r->picture[1], *restrict z = r->picture[2];
    const float *restrict squares = r->own, *restrict lens = r->noise, *restrict spread = r->spread;
    for (size_t p = 0; p < count; p++) {
        const float dx = a[p] - x[p], dy = b[p] - y[p], dz = c[p] - z[p];
        const float found = dx * dx + dy * dy + dz * dz;
        const float mean = a[p] * a[p] + b[p] * b[p] + c[p] * c[p];
        const float variance = squares[p] / n - mean, own = variance > 0.0f ? variance : 0.0f;
        const float noise = factor * own / (n - 1.0f) + lens[p];
        const int apart = (found > noise) & (spread[p] < slope);
        const float part = 1.0f - noise / found;
        const float share = apart ? part : 0.0f;
        x[p] += share * dx;
        y[p] += share * dy;
        z[p] += share * dz;
    }
}

const struct lens_residual_kernels KERNELS(lens_residual_kernels) = {
    .average = kernel_average,
    .add = kernel_add,
    .divide = kernel_divide,
    .difference = kernel_difference,
    .square = kernel_square,
    .noise = kernel_noise,
    .give = kernel_give,
    .give_own = kernel_give_own,
};
