#include "server/film/gather.h"

#include <string.h>

#include "proto/half.h"
#include "proto/surface_match.h"
#include "server/film/normals.h"

/* The overlap of a tile and a patch, and how to step through both. */
struct overlap {
    const struct plan *plan;
    const struct samples *samples;
    struct patch *patch;
    size_t width, height;
    size_t from, from_stride; /* elements, in the tile */
    size_t to, to_stride;     /* elements, in the patch */
};

static size_t from_row(const struct overlap *o, size_t y)
{
    return o->from + y * o->from_stride;
}

static size_t to_row(const struct overlap *o, size_t y)
{
    return o->to + y * o->to_stride;
}

static void copy_words(const struct overlap *o, const void *in, void *out)
{
    for (size_t y = 0; y < o->height; y++) {
        memcpy((uint32_t *)out + to_row(o, y), (const uint32_t *)in + from_row(o, y),
               o->width * sizeof(uint32_t));
    }
}

static void copy_halfwords(const struct overlap *o, const uint16_t *in, uint16_t *out)
{
    for (size_t y = 0; y < o->height; y++)
        memcpy(out + to_row(o, y), in + from_row(o, y), o->width * sizeof *out);
}

static void copy_bytes(const struct overlap *o, const uint8_t *in, uint8_t *out)
{
    for (size_t y = 0; y < o->height; y++) {
        memcpy(out + to_row(o, y), in + from_row(o, y), o->width);
    }
}

static void copy_distances(const struct overlap *o, const float *in, float *out)
{
    for (size_t y = 0; y < o->height; y++) {
        const float *from = in + from_row(o, y);
        float *to = out + to_row(o, y);
        for (size_t x = 0; x < o->width; x++) to[x] = surface_distance(from[x]);
    }
}

static void widen_ids(const struct overlap *o, const uint16_t *in, uint32_t *out)
{
    for (size_t y = 0; y < o->height; y++) {
        const uint16_t *from = in + from_row(o, y);
        uint32_t *to = out + to_row(o, y);
        for (size_t x = 0; x < o->width; x++) to[x] = from[x];
    }
}

/* Scales are powers of two: the products are exact. */
static void widen_halves(const struct overlap *o, const uint16_t *in, float scale, float *out)
{
    for (size_t y = 0; y < o->height; y++) {
        float *to = out + to_row(o, y);
        half_to_floats(in + from_row(o, y), to, o->width);
        if (scale == 1.0f) continue;
        for (size_t x = 0; x < o->width; x++) to[x] *= scale;
    }
}

static void widen_unorms(const struct overlap *o, const uint16_t *in, float *out)
{
    for (size_t y = 0; y < o->height; y++) {
        const uint16_t *from = in + from_row(o, y);
        float *to = out + to_row(o, y);
        for (size_t x = 0; x < o->width; x++) to[x] = (float)from[x] * (1.0f / 65535.0f);
    }
}

static void unpack_normals16(const struct overlap *o, const uint32_t *in, float *const out[3])
{
    for (size_t y = 0; y < o->height; y++)
        normals_unpack16(in + from_row(o, y), o->width, to_row(o, y), out);
}

static void unpack_normals8(const struct overlap *o, const uint16_t *in, float *const out[3])
{
    for (size_t y = 0; y < o->height; y++)
        normals_unpack8(in + from_row(o, y), o->width, to_row(o, y), out);
}

/* Distances of a sub-sample from d/d_ref - 1, d_ref the pixel's own or, without surface, the length
 * unit. SUB_DEPTH_MISS gives 0 by itself. */
static void restore_distances(const struct overlap *o, const uint16_t *in, const float *depth,
                              float *out)
{
    float unit = o->plan->length_unit;
    for (size_t y = 0; y < o->height; y++) {
        size_t at = to_row(o, y);
        float *to = out + at;
        half_to_floats(in + from_row(o, y), to, o->width);
        for (size_t x = 0; x < o->width; x++) {
            float own = depth ? depth[at + x] : 0.0f;
            to[x] = surface_sub_distance(to[x], own, unit);
        }
    }
}

static void clear_normals(const struct overlap *o, const float *depth, float *const normal[3])
{
    for (size_t y = 0; y < o->height; y++) {
        const float *seen = depth + to_row(o, y);
        for (int i = 0; i < 3; i++) {
            float *n = normal[i] + to_row(o, y);
            for (size_t x = 0; x < o->width; x++) n[x] = seen[x] > 0.0f ? n[x] : 0.0f;
        }
    }
}

static void gather_geometry(const struct overlap *o)
{
    const struct samples *s = o->samples;
    struct patch *p = o->patch;
    if (p->depth) copy_distances(o, samples_f32(s, PLANE_DEPTH, 0), p->depth);
    if (p->normal[0]) unpack_normals16(o, samples_u32(s, PLANE_NORMAL, 0), p->normal);
    if (p->normal[0] && p->depth) clear_normals(o, p->depth, p->normal);
}

static void gather_surface(const struct overlap *o)
{
    const struct samples *s = o->samples;
    struct patch *p = o->patch;
    for (uint32_t c = 0; c < 3 && p->albedo[0]; c++) {
        widen_unorms(o, samples_u16(s, PLANE_ALBEDO, c), p->albedo[c]);
    }
}

static void gather_sub(const struct overlap *o, uint32_t k)
{
    const struct samples *s = o->samples;
    struct patch *p = o->patch;
    if (p->sub_depth[k])
        restore_distances(o, samples_u16(s, PLANE_SUB_DEPTH, k), p->depth, p->sub_depth[k]);
    if (p->sub_normal[k][0])
        unpack_normals8(o, samples_u16(s, PLANE_SUB_NORMAL, k), p->sub_normal[k]);
    if (p->sub_normal[k][0] && p->sub_depth[k]) clear_normals(o, p->sub_depth[k], p->sub_normal[k]);
    if (p->sub_id[k]) widen_ids(o, samples_u16(s, PLANE_SUB_ID, k), p->sub_id[k]);
    for (uint32_t c = 0; c < 3 && p->sub_albedo[k][0]; c++) {
        widen_unorms(o, samples_u16(s, PLANE_SUB_ALBEDO, k * 3 + c), p->sub_albedo[k][c]);
    }
}

static void gather_rgb(const struct overlap *o, enum plane_id plane, uint32_t first,
                       float *const out[3])
{
    float scale = 1.0f / o->plan->radiance_scale; /* a positive power of two */
    for (uint32_t c = 0; c < 3 && out[0]; c++) {
        widen_halves(o, samples_u16(o->samples, plane, first + c), scale, out[c]);
    }
}

static void gather_strata(const struct overlap *o)
{
    struct patch *p = o->patch;
    uint32_t l = o->plan->indirect_strata_per_axis;
    size_t area = (size_t)rect_area(p->rect);
    float scale = 1.0f / o->plan->radiance_scale;
    for (uint32_t i = 0; i < l * l * 4; i++) {
        widen_halves(o, samples_u16(o->samples, PLANE_INDIRECT_STRATA, i),
                     i % 4 == 3 ? o->plan->length_unit : scale, p->indirect_strata + i * area);
    }
}

static void gather_indirect(const struct overlap *o)
{
    struct patch *p = o->patch;
    if (p->id) copy_words(o, samples_u32(o->samples, PLANE_ID, 0), p->id);
    gather_rgb(o, PLANE_INDIRECT_MEAN, 0, p->indirect);
    gather_rgb(o, PLANE_INDIRECT_HALVES, 0, p->indirect_even);
    gather_rgb(o, PLANE_INDIRECT_HALVES, 3, p->indirect_odd);
    if (p->reflector)
        widen_halves(o, samples_u16(o->samples, PLANE_REFLECTOR, 0), o->plan->length_unit,
                     p->reflector);
    if (p->reflector_far)
        widen_halves(o, samples_u16(o->samples, PLANE_REFLECTOR_FAR, 0), o->plan->length_unit,
                     p->reflector_far);
    if (p->indirect_strata) gather_strata(o);
    if (p->open) widen_halves(o, samples_u16(o->samples, PLANE_OPEN, 0), 1.0f, p->open);
}

/* What filters of glossy lobes read. */
static void gather_lobes(const struct overlap *o)
{
    const struct samples *s = o->samples;
    struct patch *p = o->patch;
    if (p->id && p->glossy[0]) copy_words(o, samples_u32(s, PLANE_ID, 0), p->id);
    gather_rgb(o, PLANE_GLOSSY_MEAN, 0, p->glossy);
    gather_rgb(o, PLANE_GLOSSY_HALF, 0, p->glossy_half);
    if (p->glossy_weight)
        widen_halves(o, samples_u16(s, PLANE_GLOSSY_MEAN, 3), 1.0f, p->glossy_weight);
    if (p->glossy_half_weight)
        widen_halves(o, samples_u16(s, PLANE_GLOSSY_HALF, 3), 1.0f, p->glossy_half_weight);
    if (p->glossy_alpha) widen_unorms(o, samples_u16(s, PLANE_GLOSSY_LOBE, 3), p->glossy_alpha);
    if (p->glossy_nearness)
        widen_halves(o, samples_u16(s, PLANE_GLOSSY_NEARNESS, 0), 1.0f / o->plan->length_unit,
                     p->glossy_nearness);
    if (!p->glossy_near) return;
    widen_halves(o, samples_u16(s, PLANE_GLOSSY_SPAN, 0), o->plan->length_unit, p->glossy_near);
    widen_halves(o, samples_u16(s, PLANE_GLOSSY_SPAN, 1), o->plan->length_unit, p->glossy_far);
}

static void gather_reflectance(const struct overlap *o)
{
    struct patch *p = o->patch;
    for (uint32_t c = 0; c < 3 && p->reflectance[0]; c++)
        widen_unorms(o, samples_u16(o->samples, PLANE_GLOSSY_LOBE, c), p->reflectance[c]);
    for (uint32_t k = 0; k < o->plan->sub_samples; k++)
        for (uint32_t c = 0; c < 3 && p->sub_reflectance[k][0]; c++)
            widen_unorms(o, samples_u16(o->samples, PLANE_SUB_REFLECTANCE, k * 3 + c),
                         p->sub_reflectance[k][c]);
}

/* Lens samples: those in the far halo are for a filter. */
static void gather_lens(const struct overlap *o)
{
    struct patch *p = o->patch;
    const uint32_t l = o->plan->lens_strata_per_axis;
    const size_t area = (size_t)rect_area(p->rect);
    for (uint32_t i = 0; p->lens_radiance && i < l * l * 3; i++)
        copy_words(o, samples_f32(o->samples, PLANE_LENS_RADIANCE, i), p->lens_radiance + i * area);
    for (uint32_t i = 0; p->lens_slope && i < l * l; i++)
        widen_halves(o, samples_u16(o->samples, PLANE_LENS_SLOPE, i), 1.0f,
                     p->lens_slope + i * area);
    if (p->lens_coverage)
        widen_halves(o, samples_u16(o->samples, PLANE_LENS_COVERAGE, 0), 1.0f, p->lens_coverage);
    for (uint32_t c = 0; p->lens_more && c < 4; c++)
        copy_words(o, samples_f32(o->samples, PLANE_LENS_MORE, c), p->lens_more + c * area);
}

/* What light falls on. */
static void gather_lens_surfaces(const struct overlap *o)
{
    const struct samples *s = o->samples;
    struct patch *p = o->patch;
    const uint32_t l = o->plan->lens_strata_per_axis;
    const size_t area = (size_t)rect_area(p->rect);
    for (uint32_t i = 0; i < l * l; i++) {
        copy_halfwords(o, samples_u16(s, PLANE_LENS_DEPTH, i), p->lens_depth + i * area);
        copy_halfwords(o, samples_u16(s, PLANE_LENS_NORMAL, i), p->lens_normal + i * area);
        copy_words(o, samples_u32(s, PLANE_LENS_ALBEDO, i), p->lens_albedo + i * area);
        copy_words(o, samples_u32(s, PLANE_LENS_LIGHT, i), p->lens_light + i * area);
        if (p->lens_lobe)
            copy_words(o, samples_u32(s, PLANE_LENS_LOBE, i), p->lens_lobe + i * area);
    }
}

static void gather_irradiance(const struct overlap *o, uint32_t k)
{
    float *irradiance = o->patch->lights[k].irradiance;
    if (irradiance) copy_words(o, samples_light_irradiance(o->samples, k), irradiance);
}

static void gather_strata_of(const struct overlap *o, uint32_t k)
{
    const struct samples *s = o->samples;
    const struct patch_light *light = &o->patch->lights[k];
    size_t area = (size_t)rect_area(o->patch->rect);
    uint32_t l = o->plan->lights[k].strata_per_axis;
    for (uint32_t b = 0; light->visibility && b < (l * l + 7) / 8; b++) {
        copy_bytes(o, samples_light_visibility(s, k, b), light->visibility + b * area);
    }
    if (light->slope_min) widen_halves(o, samples_light_slope(s, k, 0), 1.0f, light->slope_min);
    if (light->slope_max) widen_halves(o, samples_light_slope(s, k, 1), 1.0f, light->slope_max);
}

static void copy_rgb(const struct overlap *o, enum plane_id plane, float *const out[3])
{
    for (uint32_t c = 0; c < 3 && out[0]; c++) {
        copy_words(o, samples_f32(o->samples, plane, c), out[c]);
    }
}

/* Counts are below 2^24: exact. */
static void fill(const struct overlap *o, float count, float *out)
{
    for (size_t y = 0; y < o->height; y++) {
        float *to = out + to_row(o, y);
        for (size_t x = 0; x < o->width; x++) to[x] = count;
    }
}

/* Of a first set and, where there is one, of a second: at most LIMIT_SPP, exact. */
static void gather_counts(const struct overlap *o, uint32_t first, const uint8_t *sides, float *out)
{
    fill(o, (float)first, out);
    for (size_t y = 0; y < o->height && sides; y++) {
        const uint8_t *side = sides + from_row(o, y);
        float *to = out + to_row(o, y);
        for (size_t x = 0; x < o->width; x++) to[x] += (float)side[x] * (float)side[x];
    }
}

/* How many paths there are, and what tells of their errors. */
static void gather_path_errors(const struct overlap *o, struct pass_counts counts)
{
    const struct patch_paths *p = &o->patch->paths;
    copy_rgb(o, PLANE_PATH_SPREAD, p->spread);
    if (p->split) copy_words(o, samples_f32(o->samples, PLANE_PATH_SPLIT, 0), p->split);
    fill(o, (float)counts.paths, p->spp);
    fill(o, (float)counts.split, p->split_spp);
    fill(o, counts.split > 0 ? (float)counts.split_lengths / (float)counts.split : 0.0f,
         p->split_length);
}

static void gather_paths(const struct overlap *o)
{
    const struct patch_paths *p = &o->patch->paths;
    copy_rgb(o, PLANE_PATH_RADIANCE, p->radiance);
    copy_rgb(o, PLANE_PATH_EMISSION, p->emission);
    copy_rgb(o, PLANE_PATH_DIRECT, p->direct);
    copy_rgb(o, PLANE_PATH_INDIRECT, p->indirect);
    copy_rgb(o, PLANE_PATH_DIFFUSE_DIRECT, p->diffuse_direct);
    copy_rgb(o, PLANE_PATH_DIFFUSE_INDIRECT, p->diffuse_indirect);
    copy_rgb(o, PLANE_PATH_ALBEDO, p->albedo);
    if (p->coverage) copy_words(o, samples_f32(o->samples, PLANE_PATH_COVERAGE, 0), p->coverage);
    if (p->open) copy_words(o, samples_f32(o->samples, PLANE_PATH_OCCLUSION, 0), p->open);
}

/* The part of the tile that lies in `area`, which lies in the patch; false when there is none. */
static bool overlap_init(struct overlap *o, const struct plan *plan, const struct samples *samples,
                         struct rect tile, struct rect area, struct patch *patch)
{
    struct rect r = rect_intersect(tile, area);
    if (rect_is_empty(r)) return false;
    size_t tile_width = (size_t)rect_width(tile), patch_width = (size_t)rect_width(patch->rect);
    *o = (struct overlap){
        .plan = plan,
        .samples = samples,
        .patch = patch,
        .width = (size_t)rect_width(r),
        .height = (size_t)rect_height(r),
        .from = (size_t)(r.y0 - tile.y0) * tile_width + (size_t)(r.x0 - tile.x0),
        .from_stride = tile_width,
        .to = (size_t)(r.y0 - patch->rect.y0) * patch_width + (size_t)(r.x0 - patch->rect.x0),
        .to_stride = patch_width,
    };
    return true;
}

void gather_tile(const struct plan *plan, const struct samples *samples, struct pass_counts counts,
                 struct rect tile, struct patch *patch)
{
    struct overlap o;
    if (!overlap_init(&o, plan, samples, tile, patch->rect, patch)) return;
    gather_geometry(&o);
    for (uint32_t k = 0; k < plan->light_count; k++) gather_strata_of(&o, k);
    gather_lens(&o);
    if (plan->lens_light != LENS_LIGHT_OWN) gather_lens_surfaces(&o);
    const bool far = patch_has_far_indirect(plan);
    if (far) gather_indirect(&o);
    const bool far_lobes = patch_has_far_lobes(plan);
    if (far_lobes) gather_lobes(&o);
    if (patch->bounces)
        gather_counts(&o, counts.bounces, patch->lens_paths ? NULL : counts.sides, patch->bounces);
    if (patch->glossy_rays) gather_counts(&o, counts.bounces, counts.lobes, patch->glossy_rays);
    if (patch->lens_paths) gather_counts(&o, 0, counts.sides, patch->lens_paths);
    const bool paths = plan->paths.spp > 0, far_paths = paths && patch_has_far_paths(plan);
    if (far_paths) gather_path_errors(&o, counts);
    if (!overlap_init(&o, plan, samples, tile, patch->core, patch)) return;
    if (!far) gather_indirect(&o);
    if (!far_lobes) gather_lobes(&o);
    gather_reflectance(&o);
    gather_surface(&o);
    for (uint32_t k = 0; k < plan->sub_samples; k++) gather_sub(&o, k);
    gather_rgb(&o, PLANE_EMISSION, 0, patch->emission);
    for (uint32_t k = 0; k < plan->light_count; k++) gather_irradiance(&o, k);
    if (paths && !far_paths) gather_path_errors(&o, counts);
    if (paths) gather_paths(&o);
}
