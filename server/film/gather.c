#include "server/film/gather.h"

#include <string.h>

#include "proto/half.h"
#include "proto/surface_match.h"
#include "server/film/normals.h"
#include "server/reconstruct/patch/patch_array.h"

/* The overlap of a tile and a patch, and how to step through both. */
struct overlap {
    const struct plan *plan;
    const struct samples *samples;
    struct patch *patch;
    size_t width, height;
    size_t from, from_stride; /* elements, in the tile */
    size_t to, to_stride;     /* elements, in the patch */
    uint32_t far;             /* what the far halo has (patch_far) */
    bool core;                /* the patch's core, for what it has not; else all of the patch */
};

static size_t from_row(const struct overlap *o, size_t y)
{
    return o->from + y * o->from_stride;
}

static size_t to_row(const struct overlap *o, size_t y)
{
    return o->to + y * o->to_stride;
}

static void copy_elements(const struct overlap *o, const uint8_t *in, size_t size, uint8_t *out)
{
    for (size_t y = 0; y < o->height; y++)
        memcpy(out + to_row(o, y) * size, in + from_row(o, y) * size, o->width * size);
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

/* Sets normals to 0 where depths show no surface. */
static void clear_normals(const float *restrict depth, size_t count, float *restrict x,
                          float *restrict y, float *restrict z)
{
    for (size_t i = 0; i < count; i++) {
        x[i] = depth[i] > 0.0f ? x[i] : 0.0f;
        y[i] = depth[i] > 0.0f ? y[i] : 0.0f;
        z[i] = depth[i] > 0.0f ? z[i] : 0.0f;
    }
}

/* depth: NULL where the patch has none. */
static void unpack_normals16(const struct overlap *o, const uint32_t *in, const float *depth,
                             float *const out[3])
{
    for (size_t y = 0; y < o->height; y++) {
        const size_t at = to_row(o, y);
        normals_unpack16(in + from_row(o, y), o->width, at, out);
        if (depth) clear_normals(depth + at, o->width, out[0] + at, out[1] + at, out[2] + at);
    }
}

static void unpack_normals8(const struct overlap *o, const uint16_t *in, const float *depth,
                            float *const out[3])
{
    for (size_t y = 0; y < o->height; y++) {
        const size_t at = to_row(o, y);
        normals_unpack8(in + from_row(o, y), o->width, at, out);
        if (depth) clear_normals(depth + at, o->width, out[0] + at, out[1] + at, out[2] + at);
    }
}

/* Returns the factor of component i of halves. */
static float scale_of(const struct plan *plan, enum patch_unpack unpack, uint32_t i)
{
    const float radiance = 1.0f / plan->radiance_scale; /* a positive power of two */
    switch (unpack) {
    case PATCH_RADIANCE:
        return radiance;
    case PATCH_LENGTH:
        return plan->length_unit;
    case PATCH_RADIANCE_AND_LENGTH:
        return i % 4 == 3 ? plan->length_unit : radiance;
    case PATCH_NEARNESS:
        return 1.0f / plan->length_unit;
    default:
        return 1.0f;
    }
}

static void unpack_directions(const struct overlap *o, uint32_t slot,
                              const struct patch_array *array, const uint32_t *in)
{
    float *out[3];
    for (uint32_t k = 0; k < 3; k++) out[k] = patch_array_get(o->patch, slot, array, k);
    unpack_normals16(o, in, o->patch->depth, out);
}

/* Component i of an array, which lies at `out`. */
static void unpack(const struct overlap *o, uint32_t slot, const struct patch_array *array,
                   uint32_t i, const void *in, void *out)
{
    switch (array->unpack) {
    case PATCH_AS_IT_IS:
        copy_elements(o, in, array->element_bytes, out);
        break;
    case PATCH_DISTANCE:
        copy_distances(o, in, out);
        break;
    case PATCH_SUB_DISTANCE:
        restore_distances(o, in, o->patch->depth, out);
        break;
    case PATCH_NORMAL:
        unpack_directions(o, slot, array, in);
        break;
    case PATCH_SUB_NORMAL:
        unpack_normals8(o, in, o->patch->sub_depth[i], o->patch->sub_normal[i]);
        break;
    case PATCH_SUB_ID:
        widen_ids(o, in, out);
        break;
    case PATCH_UNORM:
        widen_unorms(o, in, out);
        break;
    default:
        widen_halves(o, in, scale_of(o->plan, array->unpack, i), out);
    }
}

/* Returns where component i of an array lies. */
static void *place(const struct patch *patch, uint32_t slot, const struct patch_array *array,
                   uint32_t i)
{
    const size_t area = (size_t)rect_area(patch->rect);
    if (!array->stacked) return patch_array_get(patch, slot, array, i * patch_array_each(array));
    return (uint8_t *)patch_array_get(patch, slot, array, 0) + i * area * array->element_bytes;
}

/* Gathers a plane: from the whole patch if the far halo has it, else from the core. */
static void gather_plane(const struct overlap *o, uint32_t slot)
{
    const uint32_t components = o->samples->layout.components[slot];
    const struct patch_array *array = patch_arrays(slot);
    for (uint32_t c = 0; c < components; array++) {
        const uint32_t count = patch_array_holds(array, components - c);
        const bool wanted = o->core != ((array->reach & o->far) != 0);
        for (uint32_t i = 0; i < count && wanted; i++)
            unpack(o, slot, array, i, samples_component(o->samples, slot, c + i),
                   place(o->patch, slot, array, i));
        c += count;
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

/* Computes the counts of a first set and, if there is one, a second. They are at most LIMIT_SPP and
 * exact. */
static void gather_counts(const struct overlap *o, uint32_t first, const uint8_t *strata_map,
                          float *out)
{
    fill(o, (float)first, out);
    for (size_t y = 0; y < o->height && strata_map; y++) {
        const uint8_t *strata = strata_map + from_row(o, y);
        float *to = out + to_row(o, y);
        for (size_t x = 0; x < o->width; x++) to[x] += (float)strata[x] * (float)strata[x];
    }
}

/* Gathers the number of rays of each pixel, where these may differ. */
static void gather_rays(const struct overlap *o, struct pass_counts counts)
{
    const struct patch *p = o->patch;
    if (p->bounces)
        gather_counts(o, counts.bounces, p->lens_paths ? NULL : counts.strata_map, p->bounces);
    if (p->glossy_rays) gather_counts(o, counts.bounces, counts.lobes, p->glossy_rays);
    if (p->lens_paths) gather_counts(o, 0, counts.strata_map, p->lens_paths);
}

static void gather_paths(const struct overlap *o, struct pass_counts counts)
{
    const struct patch_paths *p = &o->patch->paths;
    const uint32_t lens = plan_lens_has_paths(o->plan) ? o->plan->lens_strata_per_axis : 0;
    fill(o, (float)counts.paths, p->spp);
    fill(o, lens > 0 ? (float)(lens * lens / 2 * 2) : (float)counts.split, p->split_spp);
    fill(o, counts.split > 0 ? (float)counts.split_lengths / (float)counts.split : 0.0f,
         p->split_length);
}

/* The part of the tile that lies in the patch, or in its core; false when there is none. */
static bool overlap_init(struct overlap *o, const struct plan *plan, const struct samples *samples,
                         struct rect tile, struct patch *patch, bool core)
{
    const struct rect r = rect_intersect(tile, core ? patch->core : patch->rect);
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
        .far = patch_far(plan),
        .core = core,
    };
    return true;
}

void gather_tile(const struct plan *plan, const struct samples *samples, struct pass_counts counts,
                 struct rect tile, struct patch *patch)
{
    struct overlap o;
    /* Planes in their order: normals and sub-samples need depths. */
    for (int core = 0; core < 2; core++) {
        if (!overlap_init(&o, plan, samples, tile, patch, core == 1)) return;
        for (uint32_t slot = 0; slot < samples->layout.slots; slot++) gather_plane(&o, slot);
        if (!o.core) gather_rays(&o, counts);
        if (plan->paths.spp > 0 && o.core != ((o.far & PATCH_FAR_PATHS) != 0))
            gather_paths(&o, counts);
    }
}
