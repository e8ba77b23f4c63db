#include "server/reconstruct/patch/patch.h"

#include <stdlib.h>

#include "proto/samples.h"
#include "server/reconstruct/patch/scratch.h"

/* Arrays start on cache lines, so that vector loops start aligned. */
#define ALIGN_BYTES 64u

/* Walks over the arrays that a plan has: first to add up sizes (memory NULL), then to hand out. */
struct carver {
    uint8_t *memory;
    size_t area;
    size_t used_bytes;
};

static void *carve(struct carver *c, size_t element_bytes)
{
    size_t size_bytes = (c->area * element_bytes + ALIGN_BYTES - 1) / ALIGN_BYTES * ALIGN_BYTES;
    void *at = c->memory ? c->memory + c->used_bytes : NULL;
    c->used_bytes += size_bytes;
    return at;
}

static void carve_rgb(struct carver *c, float *out[3])
{
    for (int i = 0; i < 3; i++) out[i] = carve(c, sizeof(float));
}

static void carve_subs(struct carver *c, const struct plan *plan, struct patch *p)
{
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        if (plan->planes >> PLANE_SUB_DEPTH & 1u) p->sub_depth[k] = carve(c, sizeof(float));
        if (plan->planes >> PLANE_SUB_NORMAL & 1u) carve_rgb(c, p->sub_normal[k]);
        if (plan->planes >> PLANE_SUB_ALBEDO & 1u) carve_rgb(c, p->sub_albedo[k]);
        if (plan->planes >> PLANE_SUB_ID & 1u) p->sub_id[k] = carve(c, sizeof(uint32_t));
    }
}

static void carve_indirect(struct carver *c, const struct plan *plan, struct patch *p)
{
    size_t strata = (size_t)plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
    if (plan->planes >> PLANE_INDIRECT_MEAN & 1u) carve_rgb(c, p->indirect);
    if (plan->planes >> PLANE_INDIRECT_HALVES & 1u) {
        carve_rgb(c, p->indirect_even);
        carve_rgb(c, p->indirect_odd);
    }
    if (plan_has_rounds(plan) && strata > 0) p->bounces = carve(c, sizeof(float));
    if (plan->planes >> PLANE_REFLECTOR & 1u) p->reflector = carve(c, sizeof(float));
    if (plan->planes >> PLANE_REFLECTOR_FAR & 1u) p->reflector_far = carve(c, sizeof(float));
    if (plan->planes >> PLANE_INDIRECT_STRATA & 1u)
        p->indirect_strata = carve(c, strata * 4 * sizeof(float));
    if (plan->planes >> PLANE_OPEN & 1u) p->open = carve(c, sizeof(float));
}

static void carve_glossy(struct carver *c, const struct plan *plan, struct patch *p)
{
    if (plan->planes >> PLANE_GLOSSY_MEAN & 1u) {
        carve_rgb(c, p->glossy);
        p->glossy_weight = carve(c, sizeof(float));
    }
    if (plan->planes >> PLANE_GLOSSY_HALF & 1u) {
        carve_rgb(c, p->glossy_half);
        p->glossy_half_weight = carve(c, sizeof(float));
    }
    if (plan->planes >> PLANE_GLOSSY_LOBE & 1u) {
        carve_rgb(c, p->reflectance);
        p->glossy_alpha = carve(c, sizeof(float));
    }
    if (plan->planes >> PLANE_GLOSSY_NEARNESS & 1u) p->glossy_nearness = carve(c, sizeof(float));
    if (plan->planes >> PLANE_GLOSSY_SPAN & 1u) {
        p->glossy_near = carve(c, sizeof(float));
        p->glossy_far = carve(c, sizeof(float));
    }
    if (plan_has_rounds(plan) && plan->planes >> PLANE_GLOSSY_MEAN & 1u)
        p->glossy_rays = carve(c, sizeof(float));
    for (uint32_t k = 0; k < plan->sub_samples; k++)
        if (plan->planes >> PLANE_SUB_REFLECTANCE & 1u) carve_rgb(c, p->sub_reflectance[k]);
}

static void carve_lens(struct carver *c, const struct plan *plan, struct patch *p)
{
    const size_t samples = (size_t)plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    if (plan->planes >> PLANE_LENS_RADIANCE & 1u)
        p->lens_radiance = carve(c, samples * 3 * sizeof(float));
    if (plan->planes >> PLANE_LENS_SLOPE & 1u) p->lens_slope = carve(c, samples * sizeof(float));
    if (plan->lens_light != LENS_LIGHT_OWN) {
        p->lens_depth = carve(c, samples * sizeof *p->lens_depth);
        p->lens_normal = carve(c, samples * sizeof *p->lens_normal);
        p->lens_albedo = carve(c, samples * sizeof *p->lens_albedo);
        p->lens_light = carve(c, samples * sizeof *p->lens_light);
        if (plan->planes >> PLANE_LENS_LOBE & 1u)
            p->lens_lobe = carve(c, samples * sizeof *p->lens_lobe);
    }
    if (plan->planes >> PLANE_LENS_COVERAGE & 1u) p->lens_coverage = carve(c, sizeof(float));
    if (plan->planes >> PLANE_LENS_MORE & 1u) {
        p->lens_more = carve(c, 4 * sizeof(float));
        p->lens_paths = carve(c, sizeof(float));
    }
}

static void carve_light(struct carver *c, const struct plan *plan, uint32_t k, struct patch *p)
{
    uint32_t planes = plan_light_planes(plan, k);
    uint32_t l = plan->lights[k].strata_per_axis;
    struct patch_light *light = &p->lights[k];
    if (planes >> LIGHT_PLANE_IRRADIANCE & 1u) light->irradiance = carve(c, sizeof(float));
    if (planes >> LIGHT_PLANE_VISIBILITY & 1u) light->visibility = carve(c, (l * l + 7u) / 8u);
    if (planes >> LIGHT_PLANE_SLOPES & 1u) {
        light->slope_min = carve(c, sizeof(float));
        light->slope_max = carve(c, sizeof(float));
    }
}

static void carve_plane(struct carver *c, const struct plan *plan, enum plane_id plane,
                        float *out[3])
{
    if (plan->planes >> plane & 1u) carve_rgb(c, out);
}

static void carve_paths(struct carver *c, const struct plan *plan, struct patch_paths *p)
{
    p->spp = carve(c, sizeof(float));
    p->split_spp = carve(c, sizeof(float));
    p->split_length = carve(c, sizeof(float));
    carve_plane(c, plan, PLANE_PATH_RADIANCE, p->radiance);
    carve_plane(c, plan, PLANE_PATH_SPREAD, p->spread);
    carve_plane(c, plan, PLANE_PATH_EMISSION, p->emission);
    carve_plane(c, plan, PLANE_PATH_DIRECT, p->direct);
    carve_plane(c, plan, PLANE_PATH_INDIRECT, p->indirect);
    carve_plane(c, plan, PLANE_PATH_DIFFUSE_DIRECT, p->diffuse_direct);
    carve_plane(c, plan, PLANE_PATH_DIFFUSE_INDIRECT, p->diffuse_indirect);
    carve_plane(c, plan, PLANE_PATH_ALBEDO, p->albedo);
    if (plan->planes >> PLANE_PATH_COVERAGE & 1u) p->coverage = carve(c, sizeof(float));
    if (plan->planes >> PLANE_PATH_OCCLUSION & 1u) p->open = carve(c, sizeof(float));
    if (plan->planes >> PLANE_PATH_SPLIT & 1u) p->split = carve(c, sizeof(float));
}

static void carve_all(struct carver *c, const struct plan *plan, struct patch *p)
{
    if (plan->planes >> PLANE_DEPTH & 1u) p->depth = carve(c, sizeof(float));
    if (plan->planes >> PLANE_NORMAL & 1u) carve_rgb(c, p->normal);
    if (plan->planes >> PLANE_ALBEDO & 1u) carve_rgb(c, p->albedo);
    if (plan->planes >> PLANE_ID & 1u) p->id = carve(c, sizeof(uint32_t));
    carve_subs(c, plan, p);
    if (plan->planes >> PLANE_EMISSION & 1u) carve_rgb(c, p->emission);
    carve_indirect(c, plan, p);
    carve_glossy(c, plan, p);
    carve_lens(c, plan, p);
    for (uint32_t k = 0; k < plan->light_count; k++) carve_light(c, plan, k, p);
    if (plan->paths.spp > 0) carve_paths(c, plan, &p->paths);
}

size_t patch_bytes(const struct plan *plan, size_t area)
{
    struct carver carver = {.area = area};
    struct patch unused = {.memory = NULL};
    carve_all(&carver, plan, &unused);
    return carver.used_bytes;
}

int patch_create_in(struct scratch *scratch, const struct plan *plan, struct rect rect,
                    struct patch **out)
{
    *out = NULL;
    if (rect_is_empty(rect)) return ERR_RANGE;
    struct patch *p = calloc(1, sizeof *p);
    if (!p) return ERR_MEMORY;
    p->rect = p->core = rect;
    p->scratch = scratch;
    struct carver carver = {.area = (size_t)rect_area(rect)};
    const size_t bytes = patch_bytes(plan, carver.area);
    if (bytes > 0) {
        carver.memory = p->memory = scratch_take(scratch, bytes);
        if (!p->memory) {
            free(p);
            return ERR_MEMORY;
        }
        carve_all(&carver, plan, p);
    }
    *out = p;
    return 0;
}

int patch_create(const struct plan *plan, struct rect rect, struct patch **out)
{
    return patch_create_in(NULL, plan, rect, out);
}

void patch_destroy(struct patch **patch)
{
    if (!*patch) return;
    scratch_give((*patch)->scratch, (*patch)->lone.entries);
    scratch_give((*patch)->scratch, (*patch)->memory);
    free(*patch);
    *patch = NULL;
}

bool patch_knows_errors(const struct plan *plan)
{
    const uint64_t needs = PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(REFLECTOR) | PLANE_BIT(ID) |
                           PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL);
    return (plan->planes & needs) == needs;
}

bool patch_has_far_indirect(const struct plan *plan)
{
    return plan->indirect_filter != INDIRECT_FILTER_NONE || patch_knows_errors(plan);
}

bool patch_knows_glossy_errors(const struct plan *plan)
{
    const uint64_t needs = PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_HALF) | PLANE_BIT(ID) |
                           PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL);
    return (plan->planes & needs) == needs;
}

bool patch_has_far_lobes(const struct plan *plan)
{
    return plan->glossy_filter != GLOSSY_FILTER_NONE || plan->planes >> PLANE_GLOSSY_SPAN & 1u ||
           patch_knows_glossy_errors(plan);
}

bool patch_has_far_paths(const struct plan *plan)
{
    return plan->planes >> PLANE_PATH_SPREAD & 1u;
}

bool patch_has_surface(const struct patch *patch, size_t i)
{
    if (patch->depth) return patch->depth[i] > 0.0f;
    return !patch->id || patch->id[i] > 0;
}

uint64_t patch_count_measured(const struct patch *patch, struct rect rect)
{
    uint64_t count = 0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = patch_pixel(patch, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            count += patch_is_measured(patch, i) ? 1 : 0;
    }
    return count;
}

uint64_t patch_count_glossy(const struct patch *patch, struct rect rect)
{
    uint64_t count = 0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = patch_pixel(patch, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            count += patch_is_glossy(patch, i) ? 1 : 0;
    }
    return count;
}
