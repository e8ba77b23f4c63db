#include "server/reconstruct/residual/residual_field.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/residual/residual_single.h"
#include "server/reconstruct/residual/residual_smooth.h"
#include "server/reconstruct/residual/residual_window.h"

/* Weights of 2^-30 and less are none: an exponent that no pixel survives. */
#define BARRED 1e4f

/* Sums may have overflowed; no comparison holds for NaN. */
#define LIGHT_MAX 1e30f

/* The rest is divided by its colour and this: it has more than lobes, too. */
#define TINT_MIN 0.3f

/* Smooth surfaces mirror more of their surroundings on the same turn: of the rest, normals count by
 * this over a roughness's square and a least one. */
#define GLOSS_WEIGHT 0.1f
#define GLOSS_ALPHA2 0.004f

/* Slopes of nearness where the picture ends on that side. */
#define NO_NEIGHBOUR 1e9f

enum {
    PLANES_FEATURES = 3 + 1 + 2 + 3 + 1 + 3 + 1 + 1 + 1,
    PLANES_LIGHT = 4 * 3 + 3,
    PLANES_KNEE = 1
};

_Static_assert(RESIDUAL_SMOOTH_PLANES <= RESIDUAL_COMPONENTS * PLANES_LIGHT, "to work in");

static size_t round_up(int32_t n, int32_t of)
{
    return ((size_t)n + (size_t)of - 1) / (size_t)of * (size_t)of;
}

static void set_shape(struct rect rect, struct residual_shape *s)
{
    s->width = rect_width(rect);
    s->height = rect_height(rect);
    s->stride = round_up(s->width, RESIDUAL_TILE_X) + 2 * RESIDUAL_PAD_PX;
    s->plane = s->stride * (round_up(s->height, RESIDUAL_TILE_Y) + 2 * RESIDUAL_PAD_PX);
    s->origin = RESIDUAL_PAD_PX * s->stride + RESIDUAL_PAD_PX;
}

static float *take(float **next, const struct residual_shape *s, size_t planes)
{
    float *at = *next;
    *next += planes * s->plane;
    return at;
}

static void hand_out(struct residual_field *f)
{
    const struct residual_shape *s = &f->features.shape;
    float *next = f->memory;
    f->features.normal = take(&next, s, 3);
    f->features.nearness = take(&next, s, 1);
    f->features.slope_x = take(&next, s, 1);
    f->features.slope_y = take(&next, s, 1);
    f->features.albedo = take(&next, s, 3);
    f->features.barred = take(&next, s, 1);
    f->features.tint = take(&next, s, 3);
    f->features.alpha = take(&next, s, 1);
    f->features.gloss = take(&next, s, 1);
    f->features.share = take(&next, s, 1);
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        struct residual_light *l = &f->light[c];
        for (int h = 0; h < 2; h++) {
            l->half[h] = take(&next, s, 3);
            l->filtered[h] = take(&next, s, 3);
            l->guide[h] = take(&next, s, 1);
        }
        l->variance = take(&next, s, 1);
    }
    f->light[RESIDUAL_REST].knee = take(&next, s, PLANES_KNEE);
}

void residual_pad(const struct residual_shape *s, float *planes, int count)
{
    const int32_t width = s->width, height = s->height, pad = RESIDUAL_PAD_PX;
    const int32_t right = (int32_t)s->stride - pad, below = (int32_t)(s->plane / s->stride) - pad;
    for (int k = 0; k < count; k++) {
        float *p = planes + (size_t)k * s->plane;
        for (int32_t y = 0; y < height; y++) {
            float *row = p + residual_at(s, 0, y);
            for (int32_t x = -pad; x < 0; x++) row[x] = row[0];
            for (int32_t x = width; x < right; x++) row[x] = row[width - 1];
        }
        for (int32_t y = -pad; y < below; y++) {
            const int32_t from = y < 0 ? 0 : height - 1;
            if (y < 0 || y >= height)
                memcpy(p + residual_at(s, -pad, y), p + residual_at(s, -pad, from),
                       s->stride * sizeof *p);
        }
    }
}

/* What is shared by all pixels of a run: where they are in the patch and in the planes. */
struct run {
    const struct patch *patch;
    size_t from, to;
    int32_t count;
};

static struct run run_of(const struct patch *patch, const struct residual_shape *s, int32_t y)
{
    return (struct run){patch, (size_t)y * (size_t)s->width, residual_at(s, 0, y), s->width};
}

static void read_features(const struct run *r, struct residual_features *f)
{
    const struct patch *p = r->patch;
    const size_t plane = f->shape.plane;
    for (int32_t x = 0; x < r->count; x++) {
        const size_t i = r->from + (size_t)x, k = r->to + (size_t)x;
        const float seen = p->path_coverage[i], part = seen > 0.0f ? 1.0f / seen : 0.0f;
        for (size_t c = 0; c < 3; c++) {
            f->normal[c * plane + k] = p->path_normal[c][i] * part;
            f->albedo[c * plane + k] = p->path_albedo[c][i] / p->paths.spp[i];
            f->tint[c * plane + k] = TINT_MIN + p->path_tint[c][i] * part;
        }
        const float distance = p->path_distance[i] * part;
        f->nearness[k] = distance > 0.0f ? residual_nearness(f, distance) : 0.0f;
        f->alpha[k] = p->path_alpha[i] * part;
        f->barred[k] = seen > 0.0f ? 0.0f : BARRED;
        f->share[k] = 0.5f * p->paths.split_spp[i] / p->paths.spp[i];
    }
}

/* What a half of the samples brings: `half` of them are in a. Without halves both are the mean. */
static float mean_of_half(int h, float sum, float sum_a, float spp, float half)
{
    float mean = sum / spp;
    if (half >= 0.5f) mean = h == 0 ? sum_a / half : (sum - sum_a) / (spp - half);
    return mean < LIGHT_MAX ? (mean > -LIGHT_MAX ? mean : -LIGHT_MAX) : LIGHT_MAX;
}

/* The rest is all that is scattered. */
static void read_light(const struct run *r, struct residual_field *f)
{
    const struct patch *p = r->patch;
    const size_t plane = f->features.shape.plane;
    for (int h = 0; h < 2; h++)
        for (size_t c = 0; c < 3; c++) {
            float *direct = f->light[RESIDUAL_DIRECT].half[h] + c * plane + r->to;
            float *indirect = f->light[RESIDUAL_INDIRECT].half[h] + c * plane + r->to;
            float *rest = f->light[RESIDUAL_REST].half[h] + c * plane + r->to;
            for (int32_t x = 0; x < r->count; x++) {
                const size_t i = r->from + (size_t)x;
                const float n = p->paths.spp[i], half = 0.5f * p->paths.split_spp[i];
                direct[x] = mean_of_half(h, p->path_diffuse_direct[c][i], p->path_half_direct[c][i],
                                         n, half);
                indirect[x] = p->path_diffuse_indirect[c]
                                  ? mean_of_half(h, p->path_diffuse_indirect[c][i],
                                                 p->path_half_indirect[c][i], n, half)
                                  : 0.0f;
                rest[x] = mean_of_half(h, p->path_radiance[c][i] - p->path_emission[c][i],
                                       p->path_half_scattered[c][i], n, half);
            }
            const float *barred = f->features.barred + r->to;
            for (int32_t x = 0; x < r->count; x++)
                if (barred[x] > 0.0f) direct[x] = indirect[x] = rest[x] = 0.0f;
        }
}

/* The rest becomes what other lobes bring, before their colour. */
static void divide_rest(const struct run *r, struct residual_field *f)
{
    const size_t plane = f->features.shape.plane;
    for (int h = 0; h < 2; h++)
        for (size_t c = 0; c < 3; c++) {
            const size_t at = c * plane + r->to;
            const float *direct = f->light[RESIDUAL_DIRECT].half[h] + at;
            const float *indirect = f->light[RESIDUAL_INDIRECT].half[h] + at;
            float *rest = f->light[RESIDUAL_REST].half[h] + at;
            const float *albedo = f->features.albedo + at, *tint = f->features.tint + at;
            for (int32_t x = 0; x < r->count; x++)
                rest[x] = (rest[x] - albedo[x] * (direct[x] + indirect[x])) / tint[x];
        }
}

static void find_slopes(struct residual_features *f)
{
    const struct residual_shape *s = &f->shape;
    const ptrdiff_t stride = (ptrdiff_t)s->stride;
    for (int32_t y = 0; y < s->height; y++) {
        const size_t first = residual_at(s, 0, y);
        const float *z = f->nearness + first;
        for (ptrdiff_t x = 0; x < s->width; x++) {
            const float right = x + 1 < s->width ? z[x + 1] - z[x] : NO_NEIGHBOUR;
            const float left = x > 0 ? z[x] - z[x - 1] : NO_NEIGHBOUR;
            const float down = y + 1 < s->height ? z[x + stride] - z[x] : NO_NEIGHBOUR;
            const float up = y > 0 ? z[x] - z[x - stride] : NO_NEIGHBOUR;
            f->slope_x[first + (size_t)x] = fabsf(right) < fabsf(left) ? right : left;
            f->slope_y[first + (size_t)x] = fabsf(down) < fabsf(up) ? down : up;
        }
    }
}

static void find_gloss(const struct residual_features *f)
{
    for (int32_t y = 0; y < f->shape.height; y++) {
        const size_t first = residual_at(&f->shape, 0, y);
        const float *alpha = f->alpha + first;
        for (size_t x = 0; x < (size_t)f->shape.width; x++)
            f->gloss[first + x] = sqrtf(GLOSS_WEIGHT / (alpha[x] * alpha[x] + GLOSS_ALPHA2));
    }
}

/* Nothing is taken from beyond the picture. */
static void bar_outside(struct residual_features *f)
{
    const struct residual_shape *s = &f->shape;
    for (size_t i = 0; i < s->plane; i++) f->barred[i] = BARRED;
}

static void read_own_features(const struct patch *patch, struct residual_features *f)
{
    for (int32_t y = 0; y < f->shape.height; y++) {
        const struct run run = run_of(patch, &f->shape, y);
        read_features(&run, f);
    }
}

static int read_all_features(const struct patch *patch, struct residual_field *field)
{
    struct residual_features *f = &field->features;
    read_own_features(patch, f);
    int error = patch->window ? residual_window_join_features(patch, field) : 0;
    if (error) return error;
    residual_smooth(f, field->light[0].half[0]); /* planes of light, which is not read yet */
    find_slopes(f);
    find_gloss(f);
    residual_pad(&f->shape, f->normal, 3);
    residual_pad(&f->shape, f->nearness, 1);
    residual_pad(&f->shape, f->albedo, 3);
    residual_pad(&f->shape, f->alpha, 1);
    residual_pad(&f->shape, f->gloss, 1);
    residual_pad(&f->shape, f->share, 1);
    return 0;
}

static int create(const struct patch *patch, struct residual_field *out)
{
    struct residual_shape *s = &out->features.shape;
    memset(out, 0, sizeof *out);
    set_shape(patch->rect, s);
    out->features.pixel_rad = patch->pixel_rad;
    const size_t bytes = s->plane *
                         (PLANES_FEATURES + RESIDUAL_COMPONENTS * PLANES_LIGHT + PLANES_KNEE) *
                         sizeof(float);
    out->scratch = patch->scratch;
    out->memory = scratch_take(out->scratch, bytes);
    if (!out->memory) return ERR_MEMORY;
    hand_out(out);
    bar_outside(&out->features);
    return 0;
}

static void read_all_light(const struct patch *patch, bool divided, struct residual_field *f)
{
    for (int32_t y = 0; y < f->features.shape.height; y++) {
        const struct run run = run_of(patch, &f->features.shape, y);
        read_light(&run, f);
        if (divided) divide_rest(&run, f);
    }
}

int residual_field_read(const struct patch *patch, struct residual_field *out)
{
    const int error = create(patch, out);
    if (error) return error;
    read_own_features(patch, &out->features);
    read_all_light(patch, false, out);
    return 0;
}

int residual_field_create(const struct patch *patch, struct residual_field *out)
{
    const struct residual_shape *s = &out->features.shape;
    int error = create(patch, out);
    if (!error) error = read_all_features(patch, out);
    if (error) return error;
    read_all_light(patch, true, out);
    residual_single_lend(patch, out);
    if (patch->window) error = residual_window_join(patch, out);
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
        for (int h = 0; h < 2; h++) residual_pad(s, out->light[c].half[h], 3);
    return error;
}

void residual_field_fini(struct residual_field *field)
{
    scratch_give(field->scratch, field->joining);
    scratch_give(field->scratch, field->memory);
    field->memory = field->joining = NULL;
}
