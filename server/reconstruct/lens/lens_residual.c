#include "server/reconstruct/lens/lens_residual.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/lens/lens_residual_kernels.h"

#define STEPS_MAX    2
#define SMOOTH_PX    1    /* what is compared with the noise is smoothed by so much */
#define NOISE_FACTOR 2.0f /* noise may be that much stronger than it seems */
#define NOISE_LENS   2.0f /* at 9 samples */
#define OWN_FACTOR   2.0f /* strata that fall on a pattern's repeats hide what varies */
#define OWN_SLOPE    2.0f /* px; pixels farther out of focus do not stand by themselves */
#define OWN_STRATA   2    /* an axis: fewer samples do not tell how they differ */

/* Half the sides of the windows, largest first. */
struct steps {
    int32_t radius[STEPS_MAX];
    int32_t count;
};

/* Chooses the windows. They never shrink to single pixels, where a small bright light that a sample
 * met by chance would stand out from the noise. */
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
    const struct lens_residual_kernels *kernels;
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
                           .kernels = KERNELS_BEST(lens_residual_kernels),
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

/* Returns how many of the pixels x - radius .. x + radius lie in 0 .. length - 1. */
static float pixels_around(int32_t x, int32_t radius, int32_t length)
{
    const int32_t from = x - radius > 0 ? x - radius : 0;
    const int32_t to = x + radius < length - 1 ? x + radius : length - 1;
    return (float)(to - from + 1);
}

/* Sums along rows, in one order wherever the row begins. */
static void sum_rows(const struct residual *r, int32_t radius, const float *in, float *out)
{
    for (int32_t y = 0; y < r->height; y++, in += r->width, out += r->width) {
        memset(out, 0, (size_t)r->width * sizeof *out);
        for (int32_t k = -radius; k <= radius; k++) {
            const int32_t from = k < 0 ? -k : 0, to = k > 0 ? r->width - k : r->width;
            if (from < to) r->kernels->add(out + from, in + from + k, (size_t)(to - from));
        }
    }
}

/* Divides sums over squares around a row's pixels by how many pixels they are of. */
static void divide_row(const struct residual *r, int32_t radius, float rows, float *sums)
{
    const int32_t width = r->width, left = radius < width ? radius : width;
    const int32_t right = width - radius > left ? width - radius : left;
    for (int32_t x = 0; x < left; x++) sums[x] /= rows * pixels_around(x, radius, width);
    r->kernels->divide(sums + left, rows * (float)(2 * radius + 1), (size_t)(right - left));
    for (int32_t x = right; x < width; x++) sums[x] /= rows * pixels_around(x, radius, width);
}

/* Takes means over squares, which are cut where the picture ends. */
static void smooth(const struct residual *r, int32_t radius, const float *in, float *out)
{
    const size_t width = (size_t)r->width;
    sum_rows(r, radius, in, r->spare);
    for (int32_t y = 0; y < r->height; y++) {
        float *to = out + (size_t)y * width;
        memset(to, 0, width * sizeof *to);
        for (int32_t k = y - radius; k <= y + radius; k++)
            if (k >= 0 && k < r->height) r->kernels->add(to, r->spare + (size_t)k * width, width);
        divide_row(r, radius, pixels_around(y, radius, r->height), to);
    }
}

/* Plain averages of a row, of n samples each, and sums of these samples' squares. */
static void average_row(const struct residual *r, uint32_t n, uint32_t c, int32_t y)
{
    const struct lens_field *f = r->field;
    const size_t area = 3 * (size_t)rect_area(f->patch->rect), at = (size_t)y * (size_t)r->width;
    r->kernels->average(lens_sample_light(f, 0, c, f->wide.x0, f->wide.y0 + y), area, n,
                        (size_t)r->width, r->average[c] + at, r->own + at);
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
    const float *const mean[] = {r->mean[0], r->mean[1], r->mean[2]};
    memset(r->square, 0, r->area * sizeof(float));
    for (int c = 0; c < 3; c++) {
        r->kernels->difference(r->average[c], r->picture[c], r->area, r->found, r->square);
        smooth(r, radius, r->found, r->mean[c]);
        smooth(r, radius, r->picture[c], r->there[c]);
    }
    smooth(r, radius, r->square, r->square);
    r->kernels->square(mean, r->area, r->found);
}

static struct lens_residual_planes planes_of(const struct residual *r)
{
    struct lens_residual_planes out = {
        .found = r->found, .own = r->own, .spread = r->field->spread};
    for (int c = 0; c < 3; c++) {
        out.average[c] = r->average[c];
        out.picture[c] = r->picture[c];
        out.mean[c] = r->mean[c];
        out.there[c] = r->there[c];
    }
    return out;
}

/* Adds as much of the difference as is not noise, for which `square` has room. */
static void give_back(struct residual *r, int32_t radius)
{
    const size_t width = (size_t)r->width;
    struct lens_residual_planes planes = planes_of(r);
    float *pixels = r->spare;
    find_difference(r, radius);
    for (int32_t y = 0; y < r->height; y++) {
        const float rows = pixels_around(y, radius, r->height);
        const size_t at = (size_t)y * width;
        for (int32_t x = 0; x < r->width; x++)
            pixels[x] = rows * pixels_around(x, radius, r->width);
        r->kernels->noise(r->found + at, r->noise + at, pixels, width, r->square + at);
    }
    smooth(r, SMOOTH_PX, r->found, r->found);
    planes.noise = r->square;
    r->kernels->give(&planes, NOISE_FACTOR, r->area);
}

/* Adds the pixels' own difference. Lights on curved metal, and objects behind glass, move over the
 * lens otherwise than the surface that shows them, so layers may blur what is sharp. Where a pixel
 * is nearly in focus and its samples agree with each other and not with the layers, the samples are
 * right. */
static void give_pixels(struct residual *r)
{
    struct lens_residual_planes planes = planes_of(r);
    const float n = (float)(r->field->l * r->field->l);
    planes.noise = r->noise;
    if (r->field->l >= OWN_STRATA) r->kernels->give_own(&planes, OWN_FACTOR, OWN_SLOPE, n, r->area);
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
