#include "server/reconstruct/compose/resolve.h"

#include <math.h>

#include "server/reconstruct/compose/resolve_mixed.h"

/* Points that are spread over a pixel err at edges as the power -3/2 of their number, squared,
 * where random ones err as the power -1: half as much for the four that there are. */
#define STRATIFIED 0.5f

/* A pixel that may lend its lighting. */
struct lender {
    size_t pixel;
    float weight;
};

/* The pixels that lend lighting to one sub-sample; weights sum to 1. None: unlit. */
struct lenders {
    struct lender items[8 * PATCH_RING_PX]; /* of the outermost ring */
    int count;
    bool unmatched;
};

void resolver_init(struct resolver *r, const struct plan *plan, const struct patch *patch,
                   const struct lighting *lighting)
{
    r->plan = plan;
    r->patch = patch;
    r->lighting = lighting;
    surface_view_init(&r->view, plan);
    bool comparable = patch->depth && patch->normal[0] && patch->albedo[0] && patch->sub_depth[0] &&
                      patch->sub_normal[0][0] && patch->sub_albedo[0][0];
    r->subs = comparable ? plan->sub_samples : 0;
    r->share = 1.0f / (float)(1 + r->subs);
    r->errors = false;
    r->parts = true;
}

/* -- which pixels lend their lighting -- */

static void add_lender(struct lenders *l, size_t pixel, float weight)
{
    if (weight > 0.0f) l->items[l->count++] = (struct lender){pixel, weight};
}

/* The part of the 3 x 3 pixels around pixel i that the patch has: offsets in columns and rows. */
static struct rect around(const struct patch *patch, size_t i)
{
    int32_t width = rect_width(patch->rect), height = rect_height(patch->rect);
    int32_t x = (int32_t)(i % (size_t)width), y = (int32_t)(i / (size_t)width);
    return (struct rect){x > 0 ? -1 : 0, y > 0 ? -1 : 0, x + 1 < width ? 2 : 1,
                         y + 1 < height ? 2 : 1};
}

/* Pixel i + (dx, dy) of the patch. */
static size_t neighbour(const struct patch *patch, size_t i, int32_t dx, int32_t dy)
{
    return (size_t)((int64_t)i + (int64_t)dy * rect_width(patch->rect) + dx);
}

static void weigh_neighbours(const struct resolver *r, size_t i, const struct shown_surface *sub,
                             const float offset[2], float left, struct lenders *l)
{
    struct rect a = around(r->patch, i);
    for (int32_t dy = a.y0; dy < a.y1; dy++) {
        for (int32_t dx = a.x0; dx < a.x1; dx++) {
            struct shown_surface pixel;
            if (dx == 0 && dy == 0) continue;
            size_t q = neighbour(r->patch, i, dx, dy);
            if (!surface_of_pixel(&r->view, r->patch, q, &pixel)) continue;
            const float k = left * surface_share(offset, dx, dy);
            add_lender(l, q, k * surface_match(&r->view, sub, &pixel));
        }
    }
}

/* Returns whether pixel i + (dx, dy) of the patch has lighting. */
static bool is_lit(const struct patch *patch, size_t i, int32_t dx, int32_t dy)
{
    const struct rect r = patch->rect, core = patch->core;
    const int32_t width = rect_width(r);
    const int32_t x = r.x0 + (int32_t)(i % (size_t)width) + dx;
    const int32_t y = r.y0 + (int32_t)(i / (size_t)width) + dy;
    return x >= core.x0 && x < core.x1 && y >= core.y0 && y < core.y1;
}

/* Of the pixels k columns or rows away, weighted by how near they are. */
static void weigh_ring(const struct resolver *r, size_t i, const struct shown_surface *sub,
                       const float offset[2], int32_t k, struct lenders *l)
{
    l->count = 0;
    for (int32_t dy = -k; dy <= k; dy++) {
        for (int32_t dx = -k; dx <= k; dx += dy == -k || dy == k ? 1 : 2 * k) {
            struct shown_surface pixel;
            if (!is_lit(r->patch, i, dx, dy)) continue;
            const size_t q = neighbour(r->patch, i, dx, dy);
            if (!surface_of_pixel(&r->view, r->patch, q, &pixel)) continue;
            const float x = offset[0] - 0.5f - (float)dx, y = offset[1] - 0.5f - (float)dy;
            /* more than a pixel away */
            add_lender(l, q, surface_match(&r->view, sub, &pixel) / (x * x + y * y));
        }
    }
}

static void take_nearest(const struct resolver *r, size_t i, const struct shown_surface *sub,
                         struct lenders *l)
{
    struct rect a = around(r->patch, i);
    float least = INFINITY;
    l->count = 0;
    for (int32_t dy = a.y0; dy < a.y1; dy++) {
        for (int32_t dx = a.x0; dx < a.x1; dx++) {
            struct shown_surface pixel;
            size_t q = neighbour(r->patch, i, dx, dy);
            if (!surface_of_pixel(&r->view, r->patch, q, &pixel)) continue;
            float mismatch = surface_mismatch(&r->view, sub, &pixel);
            if (!(mismatch < least)) continue;
            least = mismatch;
            l->items[0] = (struct lender){q, 1.0f};
            l->count = 1;
        }
    }
}

/* Scales the weights to a sum of 1; false when there is next to nothing. */
static bool normalise(struct lenders *l)
{
    float sum = 0.0f;
    for (int n = 0; n < l->count; n++) sum += l->items[n].weight;
    if (!(sum >= SURFACE_WEIGHT_MIN)) return false;
    for (int n = 0; n < l->count; n++) l->items[n].weight /= sum;
    return true;
}

static void find_lenders(const struct resolver *r, size_t i, const struct shown_surface *sub,
                         const float offset[2], struct lenders *l)
{
    struct shown_surface own;
    *l = (struct lenders){.count = 0};
    float match = 0.0f;
    if (surface_of_pixel(&r->view, r->patch, i, &own)) match = surface_match(&r->view, sub, &own);
    add_lender(l, i, match);
    if (match < 1.0f) weigh_neighbours(r, i, sub, offset, 1.0f - match, l);
    if (normalise(l)) return;
    /* What is thinner than a pixel has centres farther along. */
    for (int32_t k = 2; k <= PATCH_RING_PX; k++) {
        weigh_ring(r, i, sub, offset, k, l);
        if (normalise(l)) return;
    }
    l->unmatched = true;
    take_nearest(r, i, sub, l);
}

/* -- what a sub-sample sends out -- */

/* A weighted mean of one channel, as a base plus differences, so that a constant field stays what
 * it is to the last bit. The base has the largest weight, so that the result
 * stays between the values. */
static float blend(const struct lenders *l, const float *channel)
{
    int base = 0;
    for (int n = 1; n < l->count; n++) {
        if (l->items[n].weight > l->items[base].weight) base = n;
    }
    float value = channel[l->items[base].pixel], sum = value;
    for (int n = 0; n < l->count; n++) {
        if (n != base) sum += l->items[n].weight * (channel[l->items[n].pixel] - value);
    }
    return fmaxf(sum, 0.0f);
}

/* `sent` becomes what that is in all. */
static void add_lit(const struct resolver *r, const struct lenders *l, const float albedo[3],
                    float sent[3], struct resolved *sum)
{
    if (l->count == 0) return;
    for (int c = 0; c < 3; c++) {
        const float total = albedo[c] * blend(l, r->lighting->total[c]);
        sum->direct[c] += albedo[c] * blend(l, r->lighting->direct[c]);
        sum->indirect[c] += albedo[c] * blend(l, r->lighting->indirect[c]);
        sum->total[c] += total;
        sent[c] = total;
        if (r->errors && r->lighting->error[0])
            sum->error[c] += albedo[c] * blend(l, r->lighting->error[c]);
    }
}

/* What the glossy lobe of a sub-sample sends on. */
static void add_shine(const struct resolver *r, const struct lenders *l, uint32_t k, size_t i,
                      float sent[3], struct resolved *sum)
{
    float *const *reflectance = r->patch->sub_reflectance[k];
    if (!r->lighting->glossy[0] || !reflectance[0] || l->count == 0) return;
    for (int c = 0; c < 3; c++) {
        if (!(reflectance[c][i] > 0.0f)) continue;
        const float shine = reflectance[c][i] * blend(l, r->lighting->glossy[c]);
        sum->indirect[c] += shine;
        sum->total[c] += shine;
        sent[c] += shine;
        if (r->errors && r->lighting->glossy_error[0])
            sum->glossy_error[c] += reflectance[c][i] * blend(l, r->lighting->glossy_error[c]);
    }
}

/* The light of a lone sub-sample, as add_lit and add_shine do with what pixels lend. */
static void add_lone(const struct resolver *r, const struct lone_entry *e, uint32_t k, size_t i,
                     const float albedo[3], float sent[3], struct resolved *sum)
{
    const struct lone_share *lone = &r->patch->lone;
    float *const *reflectance = r->patch->sub_reflectance[k];
    for (int c = 0; c < 3; c++) {
        const float lobe = reflectance[0] ? reflectance[c][i] : 0.0f;
        const float shine = lobe * e->light[LONE_GLOSSY][c];
        const float direct = albedo[c] * e->light[LONE_DIRECT][c];
        const float indirect = albedo[c] * e->light[LONE_INDIRECT][c] + shine;
        sum->direct[c] += direct;
        sum->indirect[c] += indirect;
        sum->total[c] += direct + indirect;
        sent[c] = direct + indirect;
        if (!r->errors) continue;
        sum->error[c] +=
            albedo[c] * lone_entry_error(lone, e, LONE_INDIRECT, LONE_INDIRECT_HALF, c);
        sum->glossy_error[c] += lobe * lone_entry_error(lone, e, LONE_GLOSSY, LONE_GLOSSY_HALF, c);
    }
    sum->lone++;
}

static void pixel_offset(const struct resolver *r, size_t i, uint32_t k, float offset[2])
{
    const struct rect *rect = &r->patch->rect;
    size_t width = (size_t)rect_width(*rect);
    int32_t x = rect->x0 + (int32_t)(i % width), y = rect->y0 + (int32_t)(i / width);
    pattern_pixel(&r->plan->pattern, x, y, k, r->plan->sub_samples, offset);
}

/* A sub-sample that is not plainly its own pixel's surface. */
static void add_foreign_sub(const struct resolver *r, size_t i, uint32_t k, struct resolved *sum)
{
    struct shown_surface sub;
    struct lenders lenders;
    float offset[2], albedo[3], sent[3] = {0.0f, 0.0f, 0.0f};
    const struct lone_entry *lone = lone_share_find(&r->patch->lone, i * r->plan->sub_samples + k);
    pixel_offset(r, i, k, offset);
    if (!surface_of_sub(&r->view, r->patch, i, k, offset, &sub)) return;
    for (int c = 0; c < 3; c++) albedo[c] = r->patch->sub_albedo[k][c][i];
    if (lone) {
        add_lone(r, lone, k, i, albedo, sent, sum);
    } else {
        find_lenders(r, i, &sub, offset, &lenders);
        add_lit(r, &lenders, albedo, sent, sum);
        add_shine(r, &lenders, k, i, sent, sum);
        sum->unmatched += lenders.unmatched;
    }
    for (int c = 0; c < 3; c++) {
        sum->albedo[c] += albedo[c];
        if (r->errors) sum->spread[c] += sent[c] * sent[c];
    }
    sum->coverage += 1.0f;
}

static void add_own(const struct resolver *r, size_t i, const float albedo[3], float samples,
                    struct resolved *sum)
{
    for (int c = 0; c < 3; c++) {
        sum->direct[c] += albedo[c] * r->lighting->direct[c][i];
        sum->indirect[c] += albedo[c] * r->lighting->indirect[c][i];
        sum->total[c] += albedo[c] * r->lighting->total[c][i];
        sum->albedo[c] += albedo[c];
    }
    sum->coverage += samples;
}

/* What the glossy lobe of a sample of the pixel reflects, of sub-sample k - 1 or, for 0, the
 * centre.
 */
static float reflectance_of(const struct patch *p, int c, uint32_t k, size_t i)
{
    if (k == 0) return p->reflectance[c][i];
    return p->sub_reflectance[k - 1][0] ? p->sub_reflectance[k - 1][c][i] : 0.0f;
}

/* Of the pixel's centre, bit 0 of `own`, and of sub-samples that show its surface, the bits after
 * it. */
static void add_own_shine(const struct resolver *r, size_t i, uint32_t own, struct resolved *sum)
{
    const struct patch *p = r->patch;
    if (!r->lighting->glossy[0] || !p->reflectance[0]) return;
    for (int c = 0; c < 3; c++) {
        float reflectance = 0.0f;
        for (uint32_t k = 0; k <= r->subs; k++)
            if (own >> k & 1u) reflectance += reflectance_of(p, c, k, i);
        sum->indirect[c] += reflectance * r->lighting->glossy[c][i];
        sum->total[c] += reflectance * r->lighting->glossy[c][i];
        if (r->errors && r->lighting->glossy_error[0])
            sum->glossy_error[c] += reflectance * r->lighting->glossy_error[c][i];
    }
}

static float albedo_of(const struct patch *p, int c, uint32_t k, size_t i)
{
    if (k > 0) return p->sub_albedo[k - 1][c][i];
    return p->albedo[0] ? p->albedo[c][i] : 1.0f;
}

/* What such samples send on, each by itself; `albedo` is the sum of theirs. */
static void add_own_errors(const struct resolver *r, size_t i, uint32_t own, const float albedo[3],
                           struct resolved *sum)
{
    const struct patch *p = r->patch;
    const struct lighting *l = r->lighting;
    const bool shines = l->glossy[0] && p->reflectance[0];
    for (int c = 0; c < 3; c++) {
        for (uint32_t k = 0; k <= r->subs; k++) {
            if (!(own >> k & 1u)) continue;
            const float shine = shines ? reflectance_of(p, c, k, i) * l->glossy[c][i] : 0.0f;
            const float sent = albedo_of(p, c, k, i) * l->total[c][i] + shine;
            sum->spread[c] += sent * sent;
        }
        if (l->error[0]) sum->error[c] += albedo[c] * l->error[c][i];
    }
}

/* From the sum of squares to the mean's squared standard error. */
static float mean_square(float squares, float sum, float share)
{
    const float count = 1.0f / share, mean = sum * share;
    if (!(count > 1.5f)) return 0.0f;
    return STRATIFIED * fmaxf(squares * share - mean * mean, 0.0f) / (count - 1.0f);
}

static void scale(struct resolved *out, float share)
{
    for (int c = 0; c < 3; c++) {
        out->error[c] *= share;
        out->glossy_error[c] *= share;
        /* Neighbours that light is taken from differ by their noise, too. */
        const float noise =
            out->error[c] * out->error[c] + out->glossy_error[c] * out->glossy_error[c];
        const float square = mean_square(out->spread[c], out->total[c], share);
        out->spread[c] = fmaxf(square - noise, 0.0f);
        out->direct[c] *= share;
        out->indirect[c] *= share;
        out->total[c] *= share;
        out->albedo[c] *= share;
    }
    out->coverage *= share;
}

/* The mean over the pixel's centre and its sub-samples. */
static void resolve_samples(const struct resolver *r, size_t i, struct resolved *out)
{
    const struct patch *p = r->patch;
    float own[3] = {0.0f, 0.0f, 0.0f}; /* albedo of all samples that show the pixel's surface */
    float samples = 0.0f;
    uint32_t same = 0; /* bits: the centre and sub-samples among them */
    struct surface_facing facing = {.known = false};
    *out = (struct resolved){.unmatched = 0};
    if (patch_has_surface(r->patch, i)) {
        for (int c = 0; c < 3; c++) own[c] = albedo_of(p, c, 0, i);
        samples = 1.0f;
        same = 1u;
    }
    for (uint32_t k = 0; k < r->subs; k++) {
        if (surface_surely_same(&r->view, p, i, k, &facing)) {
            for (int c = 0; c < 3; c++) own[c] += albedo_of(p, c, k + 1, i);
            samples += 1.0f;
            same |= 2u << k;
        } else if (p->sub_depth[k][i] > 0.0f) {
            add_foreign_sub(r, i, k, out);
        }
    }
    if (samples > 0.0f) add_own(r, i, own, samples, out);
    if (samples > 0.0f) add_own_shine(r, i, same, out);
    if (samples > 0.0f && r->errors) add_own_errors(r, i, same, own, out);
    scale(out, r->share);
}

void resolve_pixel(const struct resolver *r, size_t i, struct resolved *out)
{
    const struct mixed_share *mixed = &r->patch->mixed;
    const uint32_t first = mixed_share_find(mixed, i);
    if (first < mixed->count)
        resolve_mixed(r, i, first, out);
    else
        resolve_samples(r, i, out);
}
