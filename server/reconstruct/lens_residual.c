#include "server/reconstruct/lens_residual.h"

#include <math.h>
#include <string.h>

#define STEPS_MOST   2
#define RUN          16   /* pixels that are worked on side by side */
#define SMOOTH_PX    1    /* what is compared with the noise is smoothed by so much */
#define NOISE_FACTOR 2.0f /* noise may be that much stronger than it seems */
#define NOISE_LENS   2.0f /* at 9 samples */
#define OWN_FACTOR   2.0f /* strata that fall on a pattern's repeats hide what varies */
#define OWN_SLOPE    2.0f /* px; pixels farther out of focus do not stand by themselves */
#define OWN_STRATA   2    /* an axis: fewer samples do not tell how they differ */

/* Half the sides of the windows, largest first. */
struct steps {
    int32_t radius[STEPS_MOST];
    int32_t count;
};

/* Not down to single pixels: a small bright light that one of them happens to have met would stand
 * out from all noise around. */
static struct steps steps_of(const struct plan *plan)
{
    if (plan->lens_strata_per_axis < 6) return (struct steps){{2}, 1};
    return (struct steps){{2, 1}, 2};
}

int32_t lens_residual_reach_px(const struct plan *plan)
{
    const struct steps steps = steps_of(plan);
    int32_t reach = 0;
    for (int32_t k = 0; k < steps.count; k++) reach += steps.radius[k] + SMOOTH_PX;
    return reach;
}

/* Planes of `wide`. */
struct residual {
    const struct lens_field *field;
    int32_t width, height;
    size_t area;
    float *average[3], *picture[3];
    float *mean[3], *there[3]; /* of the difference and of the picture, over the window */
    float *square, *found, *spare, *noise;
    float *own; /* squared error of a pixel's average by its own samples, as if each were random */
    void *memory;
};

static int create(const struct lens_field *f, struct residual *r)
{
    *r = (struct residual){.field = f,
                           .width = rect_width(f->wide),
                           .height = rect_height(f->wide),
                           .area = (size_t)rect_area(f->wide)};
    float **const planes[] = {&r->average[0], &r->average[1], &r->average[2], &r->picture[0],
                              &r->picture[1], &r->picture[2], &r->mean[0],    &r->mean[1],
                              &r->mean[2],    &r->there[0],   &r->there[1],   &r->there[2],
                              &r->square,     &r->found,      &r->spare,      &r->noise,
                              &r->own};
    const size_t count = sizeof planes / sizeof *planes;
    float *at = r->memory = scratch_take(f->patch->scratch, count * r->area * sizeof *at);
    if (!at) return ERR_MEMORY;
    for (size_t k = 0; k < count; k++) *planes[k] = at + k * r->area;
    return 0;
}

/* How many of the pixels x - radius .. x + radius lie in 0 .. length - 1. */
static float pixels_around(int32_t x, int32_t radius, int32_t length)
{
    const int32_t from = x - radius > 0 ? x - radius : 0;
    const int32_t to = x + radius < length - 1 ? x + radius : length - 1;
    return (float)(to - from + 1);
}

/* out += in; in runs, which the compiler makes vectors of. */
static void add_numbers(float *restrict out, const float *restrict in, size_t count)
{
    size_t x = 0;
    for (; x + RUN <= count; x += RUN)
        for (size_t i = 0; i < RUN; i++) out[x + i] += in[x + i];
    for (; x < count; x++) out[x] += in[x];
}

static void divide_numbers(float *numbers, float by, size_t count)
{
    size_t x = 0;
    for (; x + RUN <= count; x += RUN)
        for (size_t i = 0; i < RUN; i++) numbers[x + i] /= by;
    for (; x < count; x++) numbers[x] /= by;
}

/* Sums along rows, in one order wherever the row begins. */
static void sum_rows(const struct residual *r, int32_t radius, const float *in, float *out)
{
    for (int32_t y = 0; y < r->height; y++, in += r->width, out += r->width) {
        memset(out, 0, (size_t)r->width * sizeof *out);
        for (int32_t k = -radius; k <= radius; k++) {
            const int32_t from = k < 0 ? -k : 0, to = k > 0 ? r->width - k : r->width;
            if (from < to) add_numbers(out + from, in + from + k, (size_t)(to - from));
        }
    }
}

/* Divides sums over squares around a row's pixels by how many pixels they are of. */
static void divide_row(const struct residual *r, int32_t radius, float rows, float *sums)
{
    const int32_t width = r->width, left = radius < width ? radius : width;
    const int32_t right = width - radius > left ? width - radius : left;
    for (int32_t x = 0; x < left; x++) sums[x] /= rows * pixels_around(x, radius, width);
    divide_numbers(sums + left, rows * (float)(2 * radius + 1), (size_t)(right - left));
    for (int32_t x = right; x < width; x++) sums[x] /= rows * pixels_around(x, radius, width);
}

/* Means over squares; where the picture ends, over what there is. */
static void smooth(const struct residual *r, int32_t radius, const float *in, float *out)
{
    const size_t width = (size_t)r->width;
    sum_rows(r, radius, in, r->spare);
    for (int32_t y = 0; y < r->height; y++) {
        float *to = out + (size_t)y * width;
        memset(to, 0, width * sizeof *to);
        for (int32_t k = y - radius; k <= y + radius; k++)
            if (k >= 0 && k < r->height) add_numbers(to, r->spare + (size_t)k * width, width);
        divide_row(r, radius, pixels_around(y, radius, r->height), to);
    }
}

/* Plain averages of a row, of n samples each, and sums of these samples' squares. */
static void average_row(const struct residual *r, uint32_t n, uint32_t c, int32_t y)
{
    const struct lens_field *f = r->field;
    const size_t area = 3 * (size_t)rect_area(f->patch->rect), width = (size_t)r->width;
    const float *in = lens_light(f, 0, c, f->wide.x0, f->wide.y0 + y);
    float *out = r->average[c] + (size_t)y * width, *squares = r->own + (size_t)y * width;
    size_t x = 0;
    for (; x + RUN <= width; x += RUN) {
        float sum[RUN] = {0}, square[RUN] = {0};
        for (size_t j = 0; j < n; j++)
            for (size_t i = 0; i < RUN; i++) {
                const float v = in[j * area + x + i];
                sum[i] += v;
                square[i] += v * v;
            }
        for (size_t i = 0; i < RUN; i++) out[x + i] = sum[i] / (float)n;
        for (size_t i = 0; i < RUN; i++) squares[x + i] += square[i];
    }
    for (; x < width; x++) {
        float sum = 0.0f, square = 0.0f;
        for (size_t j = 0; j < n; j++) {
            const float v = in[j * area + x];
            sum += v;
            square += v * v;
        }
        out[x] = sum / (float)n;
        squares[x] += square;
    }
}

/* Averages, and how much their squared errors may be, summed over the channels: the samples'
 * variance over the lens, as the layers know it, over their number. Strata keep most errors below
 * that, the more of them the farther, but not those of small bright lights. */
static void load(struct residual *r)
{
    const struct lens_field *f = r->field;
    const uint32_t n = f->l * f->l;
    const float strata = NOISE_LENS * sqrtf(sqrtf(9.0f / (float)n)) / (float)n;
    memset(r->own, 0, r->area * sizeof *r->own);
    for (uint32_t c = 0; c < 3; c++) {
        for (int32_t y = 0; y < r->height; y++) average_row(r, n, c, y);
        for (size_t p = 0; p < r->area; p++)
            r->picture[c][p] = f->share[p] > 0.0f ? f->light[c][p] : r->average[c][p];
    }
    for (size_t p = 0; p < r->area; p++) {
        const float a = f->light[0][p], b = f->light[1][p], c = f->light[2][p];
        const float variance = f->light[3][p] - (a * a + b * b + c * c);
        r->noise[p] = variance > 0.0f ? variance * strata : 0.0f;
    }
}

/* Means of the difference, of its square, and the square of its mean. */
static void find_difference(struct residual *r, int32_t radius)
{
    float *difference = r->found;
    memset(r->square, 0, r->area * sizeof(float));
    for (int c = 0; c < 3; c++) {
        for (size_t p = 0; p < r->area; p++) {
            difference[p] = r->average[c][p] - r->picture[c][p];
            r->square[p] += difference[p] * difference[p];
        }
        smooth(r, radius, difference, r->mean[c]);
        smooth(r, radius, r->picture[c], r->there[c]);
    }
    smooth(r, radius, r->square, r->square);
    for (size_t p = 0; p < r->area; p++) {
        const float a = r->mean[0][p], b = r->mean[1][p], c = r->mean[2][p];
        r->found[p] = a * a + b * b + c * c;
    }
}

/* The squared error that noise leaves in the mean over `pixels`: by what the differences around
 * say, or by what the lens does. */
static float noise_of(const struct residual *r, size_t p, float pixels)
{
    const float seen = r->square[p] - r->found[p];
    return (seen > r->noise[p] ? seen : r->noise[p]) / pixels;
}

/* Adds as much of the difference as is not noise. What is to be taken away, pixels give by what
 * they have: those beside brighter ones must not pay for them. Their mean is more than that, as
 * averages are not below 0. */
static void give_back(struct residual *r, int32_t radius)
{
    find_difference(r, radius);
    float *noise = r->square;
    for (int32_t y = 0; y < r->height; y++) {
        const float rows = pixels_around(y, radius, r->height);
        for (int32_t x = 0; x < r->width; x++) {
            const size_t p = (size_t)y * (size_t)r->width + (size_t)x;
            noise[p] = noise_of(r, p, rows * pixels_around(x, radius, r->width));
        }
    }
    smooth(r, SMOOTH_PX, r->found, r->found);
    for (size_t p = 0; p < r->area; p++) {
        const float rest = r->found[p] - NOISE_FACTOR * noise[p];
        const float share = rest > 0.0f ? rest / r->found[p] : 0.0f;
        for (int c = 0; c < 3; c++) {
            const float old = r->picture[c][p], around = r->mean[c][p] + r->there[c][p];
            const float more = share * r->mean[c][p], most = around - old;
            const bool within = more > 0.0f ? most > more : most < more;
            const bool apart = more > 0.0f ? most > 0.0f : most < 0.0f;
            r->picture[c][p] = within ? old + more : apart ? around : old;
        }
    }
}

/* What shines on curved metal, or lies behind glass, moves over the lens otherwise than the surface
 * that shows it: layers blur what may be sharp. Where a pixel is nearly in focus and its samples
 * agree, with each other and not with the layers, they are right. */
static void give_pixels(struct residual *r)
{
    const struct lens_field *f = r->field;
    const float n = (float)(f->l * f->l);
    if (f->l < OWN_STRATA) return;
    for (size_t p = 0; p < r->area; p++) {
        float found = 0.0f, mean = 0.0f, difference[3];
        for (int c = 0; c < 3; c++) {
            difference[c] = r->average[c][p] - r->picture[c][p];
            found += difference[c] * difference[c];
            mean += r->average[c][p] * r->average[c][p];
        }
        const float variance = r->own[p] / n - mean, own = variance > 0.0f ? variance : 0.0f;
        const float noise = OWN_FACTOR * own / (n - 1.0f) + r->noise[p];
        const bool apart = found > noise && f->spread[p] < OWN_SLOPE;
        const float share = apart ? 1.0f - noise / found : 0.0f;
        for (int c = 0; c < 3; c++) r->picture[c][p] += share * difference[c];
    }
}

static void store(const struct residual *r, struct rect inner, float *const out[3])
{
    const struct lens_field *f = r->field;
    for (int32_t y = inner.y0; y < inner.y1; y++)
        for (int c = 0; c < 3; c++) {
            const float *in = r->picture[c] + lens_wide(f, inner.x0, y);
            float *to = out[c] + patch_pixel(f->patch, inner.x0, y);
            for (int32_t x = 0; x < rect_width(inner); x++) to[x] = in[x];
        }
}

int lens_residual(const struct lens_field *field, struct rect inner, float *const out[3])
{
    const struct steps steps = steps_of(field->plan);
    struct residual r;
    const int error = create(field, &r);
    if (error) return error;
    load(&r);
    for (int32_t k = 0; k < steps.count; k++) give_back(&r, steps.radius[k]);
    give_pixels(&r);
    store(&r, inner, out);
    scratch_give(field->patch->scratch, r.memory);
    return 0;
}
