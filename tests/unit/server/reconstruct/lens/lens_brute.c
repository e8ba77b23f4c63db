#include "tests/unit/server/reconstruct/lens/lens_brute.h"

#include <stdlib.h>

/* Slopes of a layer, as those of its cells. */
struct brute_layer {
    uint32_t layer;
    float low, high, close, middle, most;
    bool fixed;
    float *pass;     /* owned; by which slopes pixels' samples pass it */
    const float *at; /* where on the lens samples are: two planes each */
};

/* Of one quarter of a pixel's lens: of all samples there, of those that meet the layer, and light.
 */
struct brute_sum {
    float weight, share, light[LENS_LIGHTS];
};

static size_t brute_index(const struct lens_field *f, int32_t x, int32_t y)
{
    return patch_pixel(f->patch, x, y);
}

/* Means of pixels' slopes in the layer; its middle where there is none. */
static void brute_find_pass(const struct lens_field *f, struct brute_layer *b)
{
    const size_t area = (size_t)rect_area(f->patch->rect), n = f->l * f->l;
    b->pass = malloc(area * sizeof *b->pass);
    for (size_t p = 0; p < area; p++) {
        float sum = 0.0f, count = 0.0f;
        for (size_t j = 0; j < n; j++) {
            const float s = f->patch->lens_slope[j * area + p];
            if (s >= b->low && s < b->high) sum += s, count += 1.0f;
        }
        b->pass[p] = count > 0.0f && !b->fixed ? sum / count : b->middle;
    }
}

/* Where on the lens samples are; the caller's. */
static float *brute_points(const struct lens_field *f)
{
    const struct rect r = f->patch->rect;
    const size_t area = (size_t)rect_area(r), n = f->l * f->l;
    float *out = malloc(2 * n * area * sizeof *out), u[2];
    for (uint32_t j = 0; j < n; j++)
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++) {
                lens_pattern_at(&f->pattern, x, y, j / f->l, j % f->l, u);
                out[2 * j * area + brute_index(f, x, y)] = u[0];
                out[(2 * j + 1) * area + brute_index(f, x, y)] = u[1];
            }
    return out;
}

static struct brute_layer brute_layer_of(const struct lens_field *f, uint32_t layer,
                                         const float *at)
{
    struct brute_layer b = {
        .layer = layer, .fixed = layer == 0 || layer == LENS_LAYERS - 1, .at = at};
    lens_layer_slopes(layer, &b.low, &b.high);
    b.close = b.low - 0.25f * fabsf(b.low);
    b.middle = b.fixed ? 0.0f : 0.5f * (b.low + b.high);
    b.most = b.fixed ? 0.5f * LENS_SLOPE_MAX : fmaxf(fabsf(b.low), fabsf(b.high));
    brute_find_pass(f, &b);
    return b;
}

/* Sample j of pixel (x, y), as pixel (px, py) sees it. */
static void brute_add(const struct lens_field *f, const struct brute_layer *b, uint32_t j,
                      int32_t x, int32_t y, int32_t px, int32_t py,
                      struct brute_sum sums[LENS_GROUPS])
{
    const float s = *lens_slopes(f, j, x, y);
    const size_t area = (size_t)rect_area(f->patch->rect), p = brute_index(f, x, y);
    if (s >= b->high) return;
    const bool moves = s >= b->close && !b->fixed;
    const float slope = moves ? s : b->pass[p];
    const float size = b->fixed ? b->most : fabsf(slope), sign = b->middle < 0.0f ? -1.0f : 1.0f;
    const float dx = sign * ((float)(x - px) + slope * b->at[2 * j * area + p]);
    const float dy = sign * ((float)(y - py) + slope * b->at[(2 * j + 1) * area + p]);
    if (lens_shape_distance(&f->shape, dx, dy) > size * f->shape.inradius) return;
    struct brute_sum *sum = &sums[lens_shape_group(dx, dy)];
    const float weight = 1.0f / (size * size);
    sum->weight += weight;
    if (s < b->low) return;
    sum->share += weight;
    for (uint32_t k = 0; k < 3; k++) {
        const float c = *lens_sample_light(f, j, k, x, y);
        sum->light[k] += weight * c;
        sum->light[3] += weight * c * c;
    }
}

/* A layer behind what pixel p has seen. */
static void brute_composite(struct lens_field *f, const struct brute_layer *b, size_t p,
                            struct brute_sum sums[LENS_GROUPS])
{
    struct brute_sum total = {0};
    for (int g = 0; g < LENS_GROUPS; g++) {
        total.weight += sums[g].weight;
        total.share += sums[g].share;
        for (int k = 0; k < LENS_LIGHTS; k++) total.light[k] += sums[g].light[k];
    }
    for (int g = 0; g < LENS_GROUPS && total.share > 0.0f; g++) {
        const struct brute_sum *sum = sums[g].weight > 0.0f ? &sums[g] : &total;
        const float by = f->through[g][p] * f->shape.share[g] / sum->weight;
        for (int k = 0; k < LENS_LIGHTS; k++) f->light[k][p] += sum->light[k] * by;
        f->share[p] += sum->share * by;
        f->spread[p] += sum->share * by * (b->fixed ? b->most : fabsf(b->middle));
        f->through[g][p] *= fmaxf(1.0f - sum->share / sum->weight, 0.0f);
    }
}

static void brute_look(struct lens_field *f, uint32_t layer, const float *at)
{
    struct brute_layer b = brute_layer_of(f, layer, at);
    const int32_t reach = (int32_t)ceilf(2.0f * b.most) + 1;
    const struct rect all = f->patch->rect;
    for (int32_t y = all.y0; y < all.y1; y++)
        for (int32_t x = all.x0; x < all.x1; x++) {
            struct brute_sum sums[LENS_GROUPS] = {{0}};
            const struct rect near = rect_intersect(
                (struct rect){x - reach, y - reach, x + reach + 1, y + reach + 1}, all);
            for (int32_t v = near.y0; v < near.y1; v++)
                for (int32_t u = near.x0; u < near.x1; u++)
                    for (uint32_t j = 0; j < f->l * f->l; j++)
                        brute_add(f, &b, j, u, v, x, y, sums);
            brute_composite(f, &b, lens_wide(f, x, y), sums);
        }
    free(b.pass);
}

/* In focus a pixel sees its own samples; all hidden: those of the nearest that has some. */
static void brute_focus_pixel(struct lens_field *f, int32_t x, int32_t y)
{
    struct brute_sum sum = {0}, quarters[LENS_GROUPS];
    struct brute_layer b = {.middle = 0.0f};
    lens_layer_slopes(LENS_FOCUS, &b.low, &b.high);
    for (int32_t r = 0; r <= LENS_FOCUS_REACH_PX && !(sum.weight > 0.0f); r++) {
        const struct rect ring =
            rect_intersect((struct rect){x - r, y - r, x + r + 1, y + r + 1}, f->patch->rect);
        for (int32_t v = ring.y0; v < ring.y1; v++)
            for (int32_t u = ring.x0; u < ring.x1; u++)
                for (uint32_t j = 0; j < f->l * f->l; j++) {
                    const float s = *lens_slopes(f, j, u, v);
                    if (s >= b.high) continue;
                    sum.weight += 1.0f;
                    if (s < b.low) continue;
                    sum.share += 1.0f;
                    for (uint32_t k = 0; k < 3; k++) {
                        const float c = *lens_sample_light(f, j, k, u, v);
                        sum.light[k] += c;
                        sum.light[3] += c * c;
                    }
                }
    }
    for (int g = 0; g < LENS_GROUPS; g++) quarters[g] = sum;
    if (sum.weight > 0.0f) brute_composite(f, &b, lens_wide(f, x, y), quarters);
}

static void brute_divide(struct lens_field *f)
{
    const size_t area = (size_t)rect_area(f->wide);
    for (size_t p = 0; p < area; p++)
        for (int k = 0; k < LENS_LIGHTS; k++)
            f->light[k][p] = f->share[p] > 0.0f ? f->light[k][p] / f->share[p] : 0.0f;
}

int lens_brute(struct lens_picture *p)
{
    const struct rect all = p->patch.rect;
    struct lens_field f;
    p->plan.lens_filter = LENS_FILTER_SHEARED;
    int error = lens_field_create(&p->plan, &p->patch, all, all, &f);
    float *at = error ? NULL : brute_points(&f);
    for (uint32_t layer = 0; !error && layer < LENS_LAYERS; layer++) {
        if (!(f.all >> layer & 1u)) continue;
        if (layer != LENS_FOCUS) {
            brute_look(&f, layer, at);
            continue;
        }
        for (int32_t y = all.y0; y < all.y1; y++)
            for (int32_t x = all.x0; x < all.x1; x++) brute_focus_pixel(&f, x, y);
    }
    if (!error) brute_divide(&f);
    if (!error) error = lens_residual(&f, all, p->out);
    free(at);
    lens_field_fini(&f);
    return error;
}
