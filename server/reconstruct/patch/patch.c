#include "server/reconstruct/patch/patch.h"

#include <stdlib.h>

#include "server/reconstruct/patch/patch_array.h"

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

static void carve_plane(struct carver *c, struct patch *p, uint32_t slot, uint32_t components)
{
    const struct patch_array *array = patch_arrays(slot);
    for (uint32_t left = components; left > 0; array++) {
        const uint32_t count = patch_array_holds(array, left);
        const size_t size = array->element_bytes;
        if (array->stacked) patch_array_set(p, slot, array, 0, carve(c, count * size));
        for (uint32_t i = 0; i < count * patch_array_each(array) && !array->stacked; i++)
            patch_array_set(p, slot, array, i, carve(c, size));
        left -= count;
    }
}

/* Carves the counts of rays of each pixel. */
static void carve_counts(struct carver *c, const struct plan *plan, struct patch *p)
{
    if (plan_has_rounds(plan) && plan->indirect_strata_per_axis > 0)
        p->bounces = carve(c, sizeof(float));
    if (plan_has_rounds(plan) && plan->planes >> PLANE_GLOSSY_MEAN & 1u)
        p->glossy_rays = carve(c, sizeof(float));
    if (plan->field_halved) p->lent = carve(c, sizeof *p->lent);
    if (plan->planes >> PLANE_LENS_SECOND_SET & 1u) p->lens_paths = carve(c, sizeof(float));
    if (plan->paths.spp == 0) return;
    p->paths.spp = carve(c, sizeof(float));
    p->paths.split_spp = carve(c, sizeof(float));
    p->paths.split_length = carve(c, sizeof(float));
}

static void carve_all(struct carver *c, const struct plan *plan, struct patch *p)
{
    for (uint32_t slot = 0; slot < samples_light_slot(plan->light_count, 0); slot++)
        carve_plane(c, p, slot, samples_components(plan, slot));
    carve_counts(c, plan, p);
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
    p->pixel_rad = plan->camera.type == CAMERA_PERSPECTIVE ? plan_pixel_size(plan, 1.0f) : 0.0f;
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
    scratch_give((*patch)->scratch, (*patch)->mixed.entries);
    scratch_give((*patch)->scratch, (*patch)->lone.entries);
    scratch_give((*patch)->scratch, (*patch)->memory);
    free(*patch);
    *patch = NULL;
}

bool patch_knows_errors(const struct plan *plan)
{
    const uint64_t needs = PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(BOUNCE_DISTANCE_MIN) |
                           PLANE_BIT(ID) | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL);
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
    return plan->planes >> PLANE_PATH_M2 & 1u || plan->residual_filter == RESIDUAL_FILTER_HALVES;
}

uint32_t patch_far(const struct plan *plan)
{
    return PATCH_FAR | (patch_has_far_indirect(plan) ? PATCH_FAR_INDIRECT : 0u) |
           (patch_has_far_lobes(plan) ? PATCH_FAR_LOBES : 0u) |
           (patch_has_far_paths(plan) ? PATCH_FAR_PATHS : 0u) |
           (plan->residual_filter == RESIDUAL_FILTER_HALVES ? PATCH_FAR_RESIDUAL : 0u) |
           (plan->temporal > 0 ? PATCH_FAR_HISTORY : 0u);
}

bool patch_has_surface(const struct patch *patch, size_t i)
{
    if (patch->depth) return patch->depth[i] > 0.0f;
    return !patch->id || patch->id[i] > 0;
}

static uint64_t count_pixels(const struct patch *patch, struct rect rect,
                             bool (*counts)(const struct patch *, size_t))
{
    uint64_t count = 0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = patch_pixel(patch, rect.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(rect); i++)
            count += counts(patch, i) ? 1 : 0;
    }
    return count;
}

uint64_t patch_count_measured(const struct patch *patch, struct rect rect)
{
    return count_pixels(patch, rect, patch_is_measured);
}

uint64_t patch_count_glossy(const struct patch *patch, struct rect rect)
{
    return count_pixels(patch, rect, patch_is_glossy);
}
