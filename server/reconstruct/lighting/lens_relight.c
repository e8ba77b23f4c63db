#include "server/reconstruct/lighting/lens_relight.h"
#include "server/reconstruct/lens/lens_cells.h"

#include <math.h>

#include "proto/samples.h"
#include "proto/shared_exponent.h"
#include "server/reconstruct/lens/lens_axis_aligned.h"
#include "server/reconstruct/lens/lens_field.h"
#include "server/reconstruct/lens/lens_residual.h"
#include "server/reconstruct/lighting/disocclusion.h"
#include "server/reconstruct/lighting/lens_cull.h"
#include "server/reconstruct/lighting/lens_row.h"
#include "server/reconstruct/lighting/light_lookup.h"

#define AROUND_PX 2  /* between q and the pixels that lend */
#define RUN_PX    16 /* samples side by side are lit if one of them is read */

int32_t lens_relight_ring_px(const struct plan *plan)
{
    if (plan->lens_relight == LENS_RELIGHT_OWN) return 0;
    if (plan->lens_filter == LENS_FILTER_AXIS_ALIGNED)
        return LENS_AXIS_ALIGNED_REACH_PX + (int32_t)LENS_RELIGHT_SLOPE_MAX + AROUND_PX;
    /* Pixels look at points of a layer that lie as far from them as its cells reach. Averages are
     * compared a little around. */
    int32_t most = 0;
    for (uint32_t layer = 0; layer < LENS_LAYERS; layer++) {
        const int32_t around = layer == LENS_FOCUS ? 0 : lens_cells_around_px(layer, 1);
        most = around > most ? around : most;
    }
    return most + lens_residual_reach_px(plan) + AROUND_PX;
}

struct lit_lens {
    const struct plan *plan;
    const struct patch *patch;
    struct lens_cull cull;
    struct light_lookup lookup;
    struct lens_row row;
    struct disocclusion disocclusion;
    bool shares_rest; /* what samples send besides is of glossy lobes, and of nothing sharper */
    bool shares;      /* other filters do not read far enough around a block */
    int error;        /* the first */
    struct rect seen, block;
    float *least, *light[3]; /* of the row: slopes that are read, and what falls on samples */
    float *gloss[3];         /* and what their glossy lobes see */
    float *radiance;
    struct lens_relight_statistics *statistics;
    void *memory;
};

static int create(struct lit_lens *f, const struct lighting *lighting, struct rect lit)
{
    const size_t width = (size_t)rect_width(f->seen);
    float *at = f->memory = scratch_take(f->patch->scratch, 7 * width * sizeof *at);
    if (!at) return ERR_MEMORY;
    f->least = at;
    for (size_t c = 0; c < 3; c++) f->light[c] = at + (c + 1) * width;
    for (size_t c = 0; c < 3; c++) f->gloss[c] = at + (c + 4) * width;
    lens_cull_init(f->plan, f->block, f->seen, &f->cull);
    int error = lens_row_create(f->plan, f->patch, width, light_lookup_around(lit), &f->row);
    if (!error) error = light_lookup_create(f->plan, f->patch, lighting, lit, &f->lookup);
    if (error) return error;
    return disocclusion_create(f->patch->scratch, f->lookup.width,
                               (size_t)rect_height(lit) + LIGHT_LOOKUP_BESIDE,
                               f->plan->lens_strata_per_axis, &f->disocclusion);
}

static void fini(struct lit_lens *f)
{
    disocclusion_fini(&f->disocclusion);
    scratch_give(f->patch->scratch, f->lookup.pixels);
    if (f->row.patch) lens_row_fini(&f->row);
    scratch_give(f->patch->scratch, f->memory);
}

/* Returns the index of the row's first pixel in a sample's plane. */
static size_t sample_at(const struct lit_lens *f, uint32_t sample)
{
    const struct patch *p = f->patch;
    return sample * (size_t)rect_area(p->rect) + patch_pixel(p, f->row.x, f->row.y);
}

static bool takes_light(uint32_t albedo)
{
    return (albedo & ((1u << 3 * SHARED_EXPONENT_9) - 1)) != 0;
}

/* Returns whether sample i of the row is read. Samples of pixels beside the block are, if their
 * slope takes them near. */
static bool is_read(const struct lit_lens *f, uint32_t i, bool row_near)
{
    const struct lens_relight_row *r = &f->row.samples;
    const int32_t pixel = f->row.x + (int32_t)i;
    if (row_near && pixel >= f->cull.near.x0 && pixel < f->cull.near.x1) return true;
    return lens_cull_reads(&f->cull, r->slope[i], r->x_low + (float)r->column[i],
                           r->y_low + (float)r->row[i]);
}

/* Notes a sample that no field lights, or whose sharp lobe no field lights. Its path's light is
 * kept, to be averaged with that of others around. */
static void hide(struct lit_lens *f, uint32_t sample, uint32_t i, uint32_t shares)
{
    const float own[3] = {f->light[0][i], f->light[1][i], f->light[2][i]};
    const size_t area = (size_t)rect_area(f->patch->rect), at = sample_at(f, sample) + i;
    const float *sent = f->patch->lens_radiance + at + 2 * sample * area;
    const float rest[3] = {sent[0], sent[area], sent[2 * area]};
    if (f->error) return;
    const int hidden =
        disocclusion_add(&f->disocclusion, &f->row.samples, i, own, rest, shares, at);
    for (int c = 0; hidden > 0 && c < 3; c++) f->light[c][i] = 0.0f;
    f->error = hidden < 0 ? hidden : 0;
}

/* Returns whether the pixel is clearly on another surface than sample i of the row. */
static bool is_other(const struct lens_relight_row *r, uint32_t i,
                     const struct light_lookup_pixel *l)
{
    float cosine = 0.0f, off = -l->plane[3];
    for (int c = 0; c < 3; c++) {
        cosine += l->plane[c] * r->normal[c][i];
        off += l->plane[c] * r->point[c][i];
    }
    return cosine < SURFACE_COS_NONE || fabsf(off) > SURFACE_FADE * r->off[i];
}

/* Returns whether all pixels around sample i of the row that are on its surface have glossy lobes.
 * Where a surface has lobes in some places only, their reflection does not hold for all of it. */
static bool has_lobe(const struct lit_lens *f, uint32_t i)
{
    const struct lens_relight_row *r = &f->row.samples;
    const size_t first = (size_t)r->row[i] * f->lookup.width + (size_t)r->column[i];
    bool any = false;
    for (size_t k = 0; k < 4; k++) {
        const size_t at = first + (k & 1) + (k >> 1) * f->lookup.width;
        const bool lobe = f->lookup.lobes[at][3] > 0.0f;
        const struct light_lookup_pixel *l = f->lookup.pixels + at;
        if (!(l->light[3] > 0.0f) || is_other(r, i, l)) continue;
        if (!lobe) return false;
        any = true;
    }
    return any;
}

/* Lights samples by fields. Samples without one keep the light of their paths, or share it. */
static void light_run(struct lit_lens *f, uint32_t sample, uint32_t begin, uint32_t end)
{
    const struct lens_relight_row *r = &f->row.samples;
    const struct rect b = f->block;
    const uint32_t *albedo = f->patch->lens_albedo + sample_at(f, sample);
    const uint32_t *lobe = f->patch->lens_lobe ? f->patch->lens_lobe + sample_at(f, sample) : NULL;
    const bool inside = f->row.y >= b.y0 && f->row.y < b.y1;
    const bool near = f->row.y >= f->cull.near.y0 && f->row.y < f->cull.near.y1;
    for (uint32_t i = begin; i < end; i++) {
        const int32_t pixel = f->row.x + (int32_t)i;
        float light[3], gloss[3] = {0};
        for (int c = 0; c < 3; c++) f->gloss[c][i] = 0.0f;
        const bool takes = takes_light(albedo[i]) || (lobe && takes_light(lobe[i]));
        if (!(takes || f->shares_rest) || !is_read(f, i, near)) continue;
        const bool known = r->z[i] > 0.0f && fabsf(r->slope[i]) < LENS_RELIGHT_SLOPE_MAX;
        const bool lit = known && takes && light_lookup_at(&f->lookup, r, i, light, gloss);
        for (int c = 0; lit && c < 3; c++) f->light[c][i] = light[c], f->gloss[c][i] = gloss[c];
        const bool sharp =
            f->shares_rest && known && lobe && !takes_light(lobe[i]) && has_lobe(f, i);
        const uint32_t shares =
            (lit || !takes ? 0u : DISOCCLUSION_LIGHT) | (sharp ? DISOCCLUSION_REST : 0u);
        if (known && shares && f->shares) hide(f, sample, i, shares);
        if (!inside || pixel < b.x0 || pixel >= b.x1) continue;
        f->statistics->samples_lit += lit ? 1 : 0;
        f->statistics->samples_own += lit ? 0 : 1;
    }
}

/* Light times albedo, and what shines by itself. */
static void add_run(const struct lit_lens *f, uint32_t sample, uint32_t begin, uint32_t end)
{
    const size_t area = (size_t)rect_area(f->patch->rect), at = sample_at(f, sample) + begin;
    for (uint32_t c = 0; c < 3; c++) {
        const size_t plane = at + (2 * sample + c) * area;
        f->row.kernels->add(f->patch->lens_albedo + at, f->light[c] + begin,
                            f->patch->lens_radiance + plane, c, end - begin, f->radiance + plane);
        if (f->patch->lens_lobe)
            f->row.kernels->add(f->patch->lens_lobe + at, f->gloss[c] + begin, f->radiance + plane,
                                c, end - begin, f->radiance + plane);
    }
}

static void light_samples_of(struct lit_lens *f, uint32_t k, uint32_t begin, uint32_t end)
{
    const uint32_t sample = f->row.line * f->row.pattern.l + k;
    const uint32_t *own = f->patch->lens_own_light + sample_at(f, sample) + begin;
    float *const light[3] = {f->light[0] + begin, f->light[1] + begin, f->light[2] + begin};
    lens_row_place(&f->row, k, begin, end);
    f->row.kernels->own(own, 1.0f / f->plan->radiance_scale, end - begin, light);
    light_run(f, sample, begin, end);
    add_run(f, sample, begin, end);
}

/* Returns whether a sample of pixels `begin` to `end` - 1 is read. */
static bool any_read(const float *restrict slope, const float *restrict least, uint32_t begin,
                     uint32_t end)
{
    uint32_t read = 0;
    for (uint32_t i = begin; i < end; i++) read |= fabsf(slope[i]) >= least[i] ? 1u : 0u;
    return read != 0;
}

/* Samples k of the line at hand, run by run. */
static void light_samples(struct lit_lens *f, uint32_t k)
{
    const uint32_t sample = f->row.line * f->row.pattern.l + k, count = f->row.count;
    const float *slope = f->patch->lens_slope + sample_at(f, sample);
    for (uint32_t begin = 0, end; begin < count; begin = end) {
        end = begin;
        while (end < count) {
            const uint32_t next = end + RUN_PX < count ? end + RUN_PX : count;
            if (!any_read(slope, f->least, end, next)) break;
            end = next;
        }
        if (end == begin) {
            end = begin + RUN_PX;
            continue;
        }
        light_samples_of(f, k, begin, end);
    }
}

static float most_slope(const struct lit_lens *f, int32_t y)
{
    const struct patch *p = f->patch;
    const uint32_t samples = f->row.pattern.l * f->row.pattern.l;
    const size_t first = patch_pixel(p, f->seen.x0, y), area = (size_t)rect_area(p->rect);
    float most = 0.0f;
    for (uint32_t k = 0; k < samples; k++)
        most = f->row.kernels->max(p->lens_slope + k * area + first, (uint32_t)rect_width(f->seen),
                                   most);
    return most;
}

/* Row y, as far from the block's pixels as any of its samples is read. */
static void light_row(struct lit_lens *f, int32_t y)
{
    const struct rect near = f->cull.near;
    const int32_t reach = lens_cull_reach_px(&f->cull, most_slope(f, y));
    const int32_t away = lens_cull_distance(y, near.y0, near.y1);
    const struct rect row = rect_intersect(rect_grow(near, reach), f->seen);
    if (away > reach) return;
    const uint32_t count = (uint32_t)rect_width(row), l = f->row.pattern.l;
    lens_cull_row(&f->cull, row.x0, away, count, f->least);
    lens_row_begin(&f->row, row.x0, y, count);
    for (uint32_t i = 0; i < l; i++) {
        lens_row_line(&f->row, i);
        for (uint32_t k = 0; k < l; k++) light_samples(f, k);
    }
}

/* The light of samples that share it, times albedo, beside what shines by itself. */
static void light_disoccluded(const struct lit_lens *f)
{
    const size_t area = (size_t)rect_area(f->patch->rect);
    for (size_t k = 0; k < f->disocclusion.count; k++) {
        const size_t at = f->disocclusion.list[k].at, plane = at + 2 * (at / area) * area;
        float light[3], rest[3];
        disocclusion_share(&f->disocclusion, f->lookup.pixels, &f->disocclusion.list[k], light,
                           rest);
        for (uint32_t c = 0; c < 3; c++) {
            float *out = f->radiance + plane + c * area;
            f->row.kernels->add(f->patch->lens_albedo + at, light + c, rest + c, c, 1, out);
        }
    }
}

int lens_relight_take(const struct plan *plan, const struct patch *patch,
                      const struct lighting *lighting, struct rect lit, struct rect seen,
                      struct rect block, float *radiance,
                      struct lens_relight_statistics *statistics)
{
    struct lit_lens f = {.plan = plan,
                         .patch = patch,
                         .shares = plan->lens_filter == LENS_FILTER_SHEARED,
                         .shares_rest = plan->lens_lobes_only != 0,
                         .seen = seen,
                         .block = block,
                         .radiance = radiance,
                         .statistics = statistics};
    if (!patch->lens_radiance || !patch->lens_slope || !patch->lens_depth || !patch->depth ||
        !patch->normal[0])
        return ERR_RANGE;
    f.error = create(&f, lighting, lit);
    for (int32_t y = seen.y0; !f.error && y < seen.y1; y++) light_row(&f, y);
    if (!f.error) light_disoccluded(&f);
    fini(&f);
    return f.error;
}
