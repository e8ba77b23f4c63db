#include "server/reconstruct/lighting/lighting.h"

#include <math.h>
#include <string.h>

#include "proto/runtime/clock.h"
#include "server/reconstruct/indirect/occlusion.h"
#include "server/reconstruct/indirect/v_plane_filter.h"
#include "server/reconstruct/shadow/shadow_error.h"

#define INVERSE_PI 0.318309886183790672f

/* A run of pixels in the patch's arrays. */
struct run {
    size_t first, count;
};

static struct run row_of(const struct patch *patch, struct rect lit, int32_t y)
{
    size_t width = (size_t)rect_width(patch->rect);
    return (struct run){(size_t)(y - patch->rect.y0) * width + (size_t)(lit.x0 - patch->rect.x0),
                        (size_t)rect_width(lit)};
}

static void add_light(const struct plan_light *light, const float *irradiance, struct run run,
                      float *const direct[3])
{
    for (int c = 0; c < 3; c++) {
        float scale = light->color[c] * INVERSE_PI;
        float *out = direct[c] + run.first;
        if (!(scale > 0.0f)) continue;
        for (size_t i = 0; i < run.count; i++)
            out[i] += lighting_bounded(irradiance[run.first + i] * scale);
    }
}

/* Mean over all samples from the means over the even and the odd ones (samples.h). */
static void add_halves(const struct plan *plan, const struct patch *patch, struct run run,
                       float *const out[3])
{
    uint32_t n = plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    /* With bounces n is at least 1. */
    uint32_t odd_count = n / 2, even_count = n - odd_count;
    float even = (float)even_count / (float)n, odd = (float)odd_count / (float)n;
    const float more =
        (float)even_count - (float)odd_count; /* later samples fall into equal halves */
    for (int c = 0; c < 3; c++) {
        for (size_t i = run.first; i < run.first + run.count; i++) {
            if (patch->bounces) {
                even = 0.5f * (patch->bounces[i] + more) / patch->bounces[i]; /* at least 1 */
                odd = 0.5f * (patch->bounces[i] - more) / patch->bounces[i];
            }
            out[c][i] = patch->indirect_even[c][i] * even + patch->indirect_odd[c][i] * odd;
        }
    }
}

static void add_strata(const struct plan *plan, const struct patch *patch, struct run run,
                       float *const out[3])
{
    size_t area = (size_t)rect_area(patch->rect);
    uint32_t n = plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    float share = 1.0f / (float)n; /* with bounces n is at least 1 */
    for (int c = 0; c < 3; c++) {
        float *sum = out[c] + run.first;
        for (uint32_t s = 0; s < n; s++) {
            const float *in = patch->indirect_strata + (s * 4 + (uint32_t)c) * area + run.first;
            for (size_t i = 0; i < run.count; i++) sum[i] += in[i];
        }
        for (size_t i = 0; i < run.count; i++) sum[i] *= share;
    }
}

static void fill_indirect(const struct plan *plan, const struct patch *patch, struct run run,
                          float *const out[3])
{
    if (patch->indirect[0]) {
        for (int c = 0; c < 3; c++)
            memcpy(out[c] + run.first, patch->indirect[c] + run.first, run.count * sizeof(float));
    } else if (patch->indirect_even[0]) {
        add_halves(plan, patch, run, out);
    } else if (patch->indirect_strata) {
        add_strata(plan, patch, run, out);
    }
}

static void fill_unfiltered(const struct plan *plan, const struct patch *patch, struct run run,
                            const struct lighting *out)
{
    const float *seen = patch->ambient_visibility;
    fill_indirect(plan, patch, run, out->indirect);
    if (seen) memcpy(out->visibility + run.first, seen + run.first, run.count * sizeof *seen);
}

/* Fills the light that needs no filter. */
static void fill_plain(const struct plan *plan, const struct patch *patch, struct run run,
                       const struct lighting *out)
{
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const float *irradiance = patch->lights[k].irradiance;
        if (irradiance) add_light(&plan->lights[k], irradiance, run, out->direct);
    }
    if (plan->indirect_filter == INDIRECT_FILTER_NONE) fill_unfiltered(plan, patch, run, out);
}

static void widen(const float *width_px, struct run run, float *most_px)
{
    for (size_t i = run.first; i < run.first + run.count; i++)
        most_px[i] = width_px[i] > most_px[i] ? width_px[i] : most_px[i];
}

static void widen_rows(const struct patch *patch, struct rect lit, const float *width_px,
                       float *most_px)
{
    for (int32_t y = lit.y0; y < lit.y1; y++) widen(width_px, row_of(patch, lit, y), most_px);
}

/* Adds the squared error of light k, which is that of its irradiance. */
static int add_error(const struct plan *plan, uint32_t k, const struct patch *patch,
                     struct rect lit, const float *irradiance, const struct lighting *out)
{
    const size_t area = (size_t)rect_area(patch->rect);
    const float *weight = patch->lights[k].diffuse_weight;
    float *variance = scratch_take(patch->scratch, area * sizeof *variance);
    if (!variance) return ERR_MEMORY;
    memset(variance, 0, area * sizeof *variance);
    const int error = shadow_error_add(plan, k, patch, lit, irradiance, variance);
    for (int32_t y = lit.y0; !error && y < lit.y1; y++)
        for (int c = 0; c < 3; c++) {
            const struct run run = row_of(patch, lit, y);
            const float scale = plan->lights[k].color[c] * INVERSE_PI;
            float *to = out->direct_error[c];
            for (size_t i = run.first; i < run.first + run.count; i++) {
                const float s = weight ? scale * weight[i] : scale;
                to[i] = lighting_bounded(to[i] + variance[i] * s * s);
            }
        }
    scratch_give(patch->scratch, variance);
    return error;
}

/* From irradiance to what the surfaces' diffuse lobes make of it; `weight` may be NULL. */
static void weigh(const float *weight, struct run run, float *irradiance)
{
    for (size_t i = run.first; weight && i < run.first + run.count; i++) irradiance[i] *= weight[i];
}

static int filter_lights(const struct plan *plan, const struct patch *patch, struct rect lit,
                         const struct lighting *out, struct shadow_statistics *shadow)
{
    size_t area = (size_t)rect_area(patch->rect);
    float *irradiance = scratch_take(patch->scratch, area * 2 * sizeof *irradiance);
    int error = irradiance ? 0 : ERR_MEMORY;
    for (uint32_t k = 0; !error && k < plan->light_count; k++) {
        float *width_px = irradiance + area;
        if (plan->lights[k].type != LIGHT_RECTANGLE) continue;
        error = shadow_filter(plan, k, patch, lit, irradiance, width_px, shadow);
        if (!error && out->direct_error[0]) error = add_error(plan, k, patch, lit, irradiance, out);
        for (int32_t y = lit.y0; !error && y < lit.y1; y++) {
            struct run run = row_of(patch, lit, y);
            weigh(patch->lights[k].diffuse_weight, run, irradiance);
            add_light(&plan->lights[k], irradiance, run, out->direct);
            widen(width_px, run, out->width_px);
        }
    }
    scratch_give(patch->scratch, irradiance);
    return error;
}

/* What bounce rays have measured, all over the patch: as it lies there, or as a mean of its parts
 * in `means`, three arrays. */
struct measured {
    const float *in[4];
    float *out[4];
    uint32_t count;
};

static void add_channel(struct measured *m, const float *in, float *out)
{
    m->in[m->count] = in;
    m->out[m->count++] = out;
}

static void measure(const struct plan *plan, const struct patch *patch, const struct lighting *out,
                    float *means, struct measured *m)
{
    const struct run all = {0, (size_t)rect_area(patch->rect)};
    float *const mean[3] = {means, means + all.count, means + 2 * all.count};
    const bool sheared = plan->indirect_filter == INDIRECT_FILTER_SHEARED;
    const bool in_parts = !sheared && (patch->indirect_even[0] || patch->indirect_strata);
    m->count = 0;
    if (!patch->indirect[0] && in_parts) {
        memset(means, 0, 3 * all.count * sizeof *means);
        fill_indirect(plan, patch, all, mean);
    }
    for (int c = 0; c < 3 && (patch->indirect[0] || in_parts); c++)
        add_channel(m, patch->indirect[0] ? patch->indirect[c] : mean[c], out->indirect[c]);
}

/* Takes one half of each pixel's samples, alternating like a chessboard. The bias of the split
 * changes sign from pixel to pixel and is filtered out. */
static void take_halves(const struct patch *patch, float *const half[3])
{
    const size_t width = (size_t)rect_width(patch->rect);
    for (int32_t y = patch->rect.y0; y < patch->rect.y1; y++)
        for (int c = 0; c < 3; c++) {
            const size_t first = (size_t)(y - patch->rect.y0) * width;
            const float *of[2] = {patch->indirect_even[c] + first, patch->indirect_odd[c] + first};
            for (size_t x = 0; x < width; x++)
                half[c][first + x] = of[(patch->rect.x0 + y + (int32_t)x) & 1][x];
        }
}

/* Writes the roots of variances; `error` may be `variance`. */
static void root(const struct patch *patch, struct rect lit, float *const variance[3],
                 float *const error[3])
{
    for (int32_t y = lit.y0; y < lit.y1; y++) {
        const struct run run = row_of(patch, lit, y);
        for (int c = 0; c < 3; c++)
            for (size_t i = run.first; i < run.first + run.count; i++)
                error[c][i] = sqrtf(variance[c][i]);
    }
}

/* Filters measured light and its error; `more` has room for six arrays. Channels without a filter
 * stay. */
static int filter_halves(const struct plan *plan, const struct patch *patch, struct rect lit,
                         const struct measured *m, float *more, float *width_px,
                         const struct lighting *out, struct indirect_statistics *statistics)
{
    const size_t area = (size_t)rect_area(patch->rect);
    float *const half[3] = {more, more + area, more + 2 * area};
    const struct indirect_error e = {
        .half = {half[0], half[1], half[2]},
        .variance = {more + 3 * area, more + 4 * area, more + 5 * area}};
    take_halves(patch, half);
    const int error = indirect_filter_with_error(plan, patch, lit, m->count, m->in, m->out,
                                                 width_px, &e, statistics);
    if (error) return error;
    root(patch, lit, e.variance, out->error);
    for (int32_t y = lit.y0; y < lit.y1 && plan->indirect_filter == INDIRECT_FILTER_NONE; y++)
        fill_unfiltered(plan, patch, row_of(patch, lit, y), out);
    return 0;
}

static int filter_indirect(const struct plan *plan, const struct patch *patch, struct rect lit,
                           const struct lighting *out, struct indirect_statistics *statistics)
{
    struct measured m;
    struct indirect_statistics again = {0}; /* of pixels that are counted already */
    int error = 0;
    size_t area = (size_t)rect_area(patch->rect);
    const bool halves = out->error[0] != NULL;
    float *memory = scratch_take(patch->scratch, area * (halves ? 10 : 4) * sizeof *memory);
    if (!memory) return ERR_MEMORY;
    float *width_px = memory + 3 * area;
    measure(plan, patch, out, memory, &m);
    const bool sheared = plan->indirect_filter == INDIRECT_FILTER_SHEARED && patch->indirect_strata;
    const bool light = sheared || m.count > 0;
    if (sheared) error = v_plane_filter(plan, patch, lit, out->indirect, width_px, statistics);
    if (!error && halves)
        error = filter_halves(plan, patch, lit, &m, memory + 4 * area, width_px, out, statistics);
    else if (!error && m.count > 0)
        error = indirect_filter(plan, patch, lit, m.count, m.in, m.out, width_px, statistics);
    if (!error && patch->ambient_visibility)
        error = occlusion_filter(plan, patch, lit, out->visibility, light ? NULL : width_px,
                                 light ? &again : statistics);
    if (!error && (light || patch->ambient_visibility))
        widen_rows(patch, lit, width_px, out->width_px);
    scratch_give(patch->scratch, memory);
    return error;
}

/* Surfaces without a lobe lend what they see all around. */
static void copy_indirect(const struct patch *patch, struct run run, const struct lighting *out)
{
    for (int c = 0; c < 3; c++)
        for (size_t i = run.first; i < run.first + run.count; i++) {
            if (patch_is_glossy(patch, i)) continue;
            out->glossy[c][i] = out->indirect[c][i];
            if (out->glossy_error[c])
                out->glossy_error[c][i] = out->error[c] ? out->error[c][i] : 0;
        }
}

static int fill_glossy(const struct plan *plan, const struct patch *patch, struct rect lit,
                       const struct lighting *out, struct glossy_statistics *statistics)
{
    float *const *variance = out->glossy_error;
    const int error =
        variance[0] ? glossy_filter_with_error(plan, patch, lit, out->glossy, variance, statistics)
                    : glossy_filter(plan, patch, lit, out->glossy, statistics);
    if (!error && variance[0]) root(patch, lit, variance, variance);
    for (int32_t y = lit.y0; !error && y < lit.y1; y++)
        copy_indirect(patch, row_of(patch, lit, y), out);
    return error;
}

/* The errors of filtered direct light, squared so far, become those of all light of a surface. */
static void join_errors(const struct patch *patch, struct rect lit, const struct lighting *out)
{
    for (int32_t y = lit.y0; y < lit.y1; y++) {
        const struct run run = row_of(patch, lit, y);
        for (int c = 0; c < 3; c++)
            for (size_t i = run.first; i < run.first + run.count; i++) {
                const float other = out->error[c] ? out->error[c][i] : 0.0f;
                out->direct_error[c][i] =
                    sqrtf(lighting_bounded(out->direct_error[c][i] + other * other));
            }
    }
}

static int filter(const struct plan *plan, const struct patch *patch, struct rect lit,
                  const struct lighting *out, struct lighting_statistics *statistics)
{
    int error = 0;
    uint64_t start_us = thread_cpu_us();
    if (plan->shadow_filter != SHADOW_FILTER_NONE) {
        error = filter_lights(plan, patch, lit, out, &statistics->shadow);
        uint64_t now_us = thread_cpu_us();
        statistics->shadow_cpu_us += now_us - start_us;
        start_us = now_us;
    }
    if (!error && patch_has_far_indirect(plan)) {
        error = filter_indirect(plan, patch, lit, out, &statistics->indirect);
        uint64_t now_us = thread_cpu_us();
        statistics->indirect_cpu_us += now_us - start_us;
        start_us = now_us;
    }
    if (!error && out->direct_error[0]) join_errors(patch, lit, out);
    if (!error && out->glossy[0]) {
        error = fill_glossy(plan, patch, lit, out, &statistics->glossy);
        statistics->glossy_cpu_us += thread_cpu_us() - start_us;
    }
    return error;
}

static void fill_total(const struct lighting *l, struct run run)
{
    for (int c = 0; c < 3; c++) {
        for (size_t i = run.first; i < run.first + run.count; i++)
            l->total[c][i] = l->direct[c][i] + l->indirect[c][i];
    }
}

static int allocate(const struct plan *plan, const struct patch *patch, bool errors,
                    struct lighting *out)
{
    const bool shadows = errors && plan->shadow_filter != SHADOW_FILTER_NONE;
    const size_t area = (size_t)rect_area(patch->rect);
    const bool halves = patch_knows_errors(plan);
    const bool glossy = patch->glossy[0] != NULL;
    const bool lobe_halves = glossy && patch_knows_glossy_errors(plan);
    const size_t lobes = halves ? 14 : 11;
    const size_t arrays = lobes + (glossy ? 3 : 0) + (lobe_halves ? 3 : 0) + (shadows ? 3 : 0);
    const size_t bytes = area * arrays * sizeof(float);
    float *memory = scratch_take(patch->scratch, bytes);
    *out = (struct lighting){.scratch = patch->scratch, .memory = memory};
    if (!memory) return ERR_MEMORY;
    memset(memory, 0, bytes);
    for (size_t c = 0; c < 3; c++) {
        out->direct[c] = memory + c * area;
        out->indirect[c] = memory + (3 + c) * area;
        out->total[c] = memory + (6 + c) * area;
    }
    out->visibility = memory + 9 * area;
    out->width_px = memory + 10 * area;
    for (size_t c = 0; c < 3 && halves; c++) out->error[c] = memory + (11 + c) * area;
    for (size_t c = 0; c < 3 && glossy; c++) out->glossy[c] = memory + (lobes + c) * area;
    for (size_t c = 0; c < 3 && lobe_halves; c++)
        out->glossy_error[c] = memory + (lobes + 3 + c) * area;
    for (size_t c = 0; c < 3 && shadows; c++)
        out->direct_error[c] = memory + (arrays - 3 + c) * area;
    return 0;
}

int lighting_create(const struct plan *plan, const struct patch *patch, struct rect lit,
                    bool errors, struct lighting *out, struct lighting_statistics *statistics)
{
    int error = allocate(plan, patch, errors, out);
    if (error) return error;
    for (int32_t y = lit.y0; y < lit.y1; y++) fill_plain(plan, patch, row_of(patch, lit, y), out);
    error = filter(plan, patch, lit, out, statistics);
    if (error) {
        lighting_fini(out);
        return error;
    }
    for (int c = 0; c < 3 && out->direct_error[0]; c++) out->error[c] = out->direct_error[c];
    for (int32_t y = lit.y0; y < lit.y1; y++) fill_total(out, row_of(patch, lit, y));
    return 0;
}

void lighting_fini(struct lighting *lighting)
{
    scratch_give(lighting->scratch, lighting->memory);
    *lighting = (struct lighting){0};
}
