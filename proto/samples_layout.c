/* Where the planes of a tile lie. */
#include "proto/samples_layout.h"

#include <string.h>

/* Room that a result frame needs beside the samples: message fields, counters, masks, headers. */
#define RESULT_OVERHEAD_BYTES 8192u

static const struct samples_plane_kind plane_kinds[PLANE_ID_COUNT] = {
    [PLANE_DEPTH] = {"depth", SAMPLES_GROUP_4, 1, SAMPLES_POSITIVE},
    [PLANE_NORMAL] = {"normal", SAMPLES_GROUP_4, 1, SAMPLES_ANY},
    [PLANE_ALBEDO] = {"albedo", SAMPLES_GROUP_2, 3, SAMPLES_ANY},
    [PLANE_ID] = {"id", SAMPLES_GROUP_4, 1, SAMPLES_ID},
    [PLANE_SUB_DEPTH] = {"sub_depth", SAMPLES_GROUP_2, 1, SAMPLES_HALF_ABOVE_MISS},
    [PLANE_SUB_NORMAL] = {"sub_normal", SAMPLES_GROUP_2, 1, SAMPLES_ANY},
    [PLANE_SUB_ALBEDO] = {"sub_albedo", SAMPLES_GROUP_2, 3, SAMPLES_ANY},
    [PLANE_SUB_ID] = {"sub_id", SAMPLES_GROUP_2, 1, SAMPLES_ANY},
    [PLANE_EMISSION] = {"emission", SAMPLES_GROUP_2, 3, SAMPLES_HALF_POSITIVE},
    [PLANE_INDIRECT_MEAN] = {"indirect_mean", SAMPLES_GROUP_2, 3, SAMPLES_HALF_POSITIVE},
    [PLANE_INDIRECT_HALVES] = {"indirect_halves", SAMPLES_GROUP_2, 6, SAMPLES_HALF_POSITIVE},
    [PLANE_REFLECTOR] = {"reflector", SAMPLES_GROUP_2, 1, SAMPLES_HALF_POSITIVE},
    [PLANE_INDIRECT_STRATA] = {"indirect_strata", SAMPLES_GROUP_2, 4, SAMPLES_HALF_POSITIVE},
    [PLANE_PATH_RADIANCE] = {"path_radiance", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_SPREAD] = {"path_spread", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_EMISSION] = {"path_emission", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_DIRECT] = {"path_direct", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_INDIRECT] = {"path_indirect", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_DIFFUSE_DIRECT] = {"path_diffuse_direct", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_DIFFUSE_INDIRECT] = {"path_diffuse_indirect", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_ALBEDO] = {"path_albedo", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_PATH_COVERAGE] = {"path_coverage", SAMPLES_GROUP_4, 1, SAMPLES_POSITIVE},
    [PLANE_PATH_OCCLUSION] = {"path_occlusion", SAMPLES_GROUP_4, 1, SAMPLES_POSITIVE},
    [PLANE_OPEN] = {"open", SAMPLES_GROUP_2, 1, SAMPLES_HALF_POSITIVE},
    [PLANE_PATH_SPLIT] = {"path_split", SAMPLES_GROUP_4, 1, SAMPLES_POSITIVE},
    [PLANE_REFLECTOR_FAR] = {"reflector_far", SAMPLES_GROUP_2, 1, SAMPLES_HALF_POSITIVE},
    [PLANE_GLOSSY_MEAN] = {"glossy_mean", SAMPLES_GROUP_2, 4, SAMPLES_HALF_POSITIVE},
    [PLANE_GLOSSY_LOBE] = {"glossy_lobe", SAMPLES_GROUP_2, 4, SAMPLES_ANY},
    [PLANE_GLOSSY_NEARNESS] = {"glossy_nearness", SAMPLES_GROUP_2, 1, SAMPLES_HALF_POSITIVE},
    [PLANE_SUB_REFLECTANCE] = {"sub_reflectance", SAMPLES_GROUP_2, 3, SAMPLES_ANY},
    [PLANE_LENS_RADIANCE] = {"lens_radiance", SAMPLES_GROUP_4, 3, SAMPLES_POSITIVE},
    [PLANE_LENS_SLOPE] = {"lens_slope", SAMPLES_GROUP_2, 1, SAMPLES_HALF_FINITE},
    [PLANE_LENS_COVERAGE] = {"lens_coverage", SAMPLES_GROUP_2, 1, SAMPLES_HALF_POSITIVE},
    [PLANE_GLOSSY_HALF] = {"glossy_half", SAMPLES_GROUP_2, 4, SAMPLES_HALF_POSITIVE},
    [PLANE_GLOSSY_SPAN] = {"glossy_span", SAMPLES_GROUP_2, 2, SAMPLES_HALF_POSITIVE},
    [PLANE_LENS_DEPTH] = {"lens_depth", SAMPLES_GROUP_2, 1, SAMPLES_HALF_POSITIVE},
    [PLANE_LENS_NORMAL] = {"lens_normal", SAMPLES_GROUP_2, 1, SAMPLES_ANY},
    [PLANE_LENS_ALBEDO] = {"lens_albedo", SAMPLES_GROUP_4, 1, SAMPLES_SHARED_9},
    [PLANE_LENS_LIGHT] = {"lens_light", SAMPLES_GROUP_4, 1, SAMPLES_SHARED_8},
    [PLANE_LENS_LOBE] = {"lens_lobe", SAMPLES_GROUP_4, 1, SAMPLES_SHARED_9},
    [PLANE_LENS_MORE] = {"lens_more", SAMPLES_GROUP_4, 4, SAMPLES_POSITIVE},
};

static const struct samples_plane_kind light_plane_kinds[LIGHT_PLANE_COUNT] = {
    [LIGHT_PLANE_IRRADIANCE] = {"irradiance", SAMPLES_GROUP_4, 1, SAMPLES_POSITIVE},
    [LIGHT_PLANE_VISIBILITY] = {"visibility", SAMPLES_GROUP_1, 1, SAMPLES_BITS},
    [LIGHT_PLANE_SLOPES] = {"slopes", SAMPLES_GROUP_2, 2, SAMPLES_SLOPES},
};

static const uint32_t element_bytes[SAMPLES_GROUP_COUNT] = {4, 2, 1};

const struct samples_plane_kind *samples_plane_kind(enum plane_id plane)
{
    return &plane_kinds[plane];
}

const struct samples_plane_kind *samples_light_plane_kind(enum light_plane_id plane)
{
    return &light_plane_kinds[plane];
}

uint32_t samples_element_bytes(enum samples_group group)
{
    return element_bytes[group];
}

uint32_t samples_plane_components(const struct samples_layout *layout, enum plane_id plane)
{
    const uint32_t components = plane_kinds[plane].components;
    switch (plane) {
    case PLANE_SUB_DEPTH:
    case PLANE_SUB_NORMAL:
    case PLANE_SUB_ALBEDO:
    case PLANE_SUB_ID:
    case PLANE_SUB_REFLECTANCE:
        return components * layout->sub_samples;
    case PLANE_INDIRECT_STRATA:
        return components * layout->indirect_strata;
    case PLANE_LENS_RADIANCE:
    case PLANE_LENS_SLOPE:
    case PLANE_LENS_DEPTH:
    case PLANE_LENS_NORMAL:
    case PLANE_LENS_ALBEDO:
    case PLANE_LENS_LIGHT:
    case PLANE_LENS_LOBE:
        return components * layout->lens_strata;
    default:
        return components;
    }
}

uint32_t samples_light_plane_components(const struct samples_layout *layout, uint32_t light,
                                        enum light_plane_id plane)
{
    if (plane == LIGHT_PLANE_VISIBILITY) return (layout->light_strata[light] + 7) / 8;
    return light_plane_kinds[plane].components;
}

uint32_t samples_visibility_mask(const struct samples_layout *layout, uint32_t light)
{
    const uint32_t bits = (layout->light_strata[light] - 1) % 8 + 1;
    return (1u << bits) - 1;
}

/* Sizes a plane and moves *at behind it; the caller has checked that sums stay within 64 bits. */
static uint32_t place_plane(uint64_t *at, uint64_t size_bytes)
{
    const uint64_t offset = *at;
    *at += size_bytes;
    return (uint32_t)offset;
}

static void place_group(struct samples_layout *layout, enum samples_group group, uint64_t *at)
{
    const uint64_t area = (uint64_t)layout->width_px * (uint64_t)layout->height_px;
    const uint64_t component_bytes = area * element_bytes[group];
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++) {
        if (plane_kinds[p].group != group || !(layout->planes >> p & 1)) continue;
        layout->offset[p] = place_plane(at, component_bytes * samples_plane_components(layout, p));
    }
    for (uint32_t k = 0; k < layout->light_count; k++)
        for (uint32_t p = 0; p < LIGHT_PLANE_COUNT; p++) {
            if (light_plane_kinds[p].group != group || !(layout->light_planes[k] >> p & 1))
                continue;
            layout->light_offset[k][p] =
                place_plane(at, component_bytes * samples_light_plane_components(layout, k, p));
        }
}

/* Of a list of all sub-samples. */
static uint64_t lone_most_bytes(const struct samples_layout *layout)
{
    if (!(layout->planes & PLANE_BIT(LONE))) return 0;
    return (uint64_t)samples_lone_places(layout) * lone_words(layout->lone_parts) *
           sizeof(uint32_t);
}

int samples_layout_place(struct samples_layout *layout)
{
    uint64_t at = 0;
    const uint64_t most = LIMIT_FRAME_BYTES - RESULT_OVERHEAD_BYTES - lone_most_bytes(layout);
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++) layout->offset[p] = SAMPLES_ABSENT;
    memset(layout->light_offset, 0xff, sizeof layout->light_offset);
    for (uint32_t group = 0; group < SAMPLES_GROUP_COUNT; group++) {
        const uint64_t start = at;
        place_group(layout, group, &at);
        if (at > most) return ERR_LIMIT;
        layout->group_bytes[group] = (uint32_t)(at - start);
    }
    layout->total_bytes = (uint32_t)at;
    return 0;
}

static int layout_start(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                        int32_t width_px, int32_t height_px)
{
    if (width_px < 1 || width_px > LIMIT_TILE_SIDE_PX) return ERR_LIMIT;
    if (height_px < 1 || height_px > LIMIT_TILE_SIDE_PX) return ERR_LIMIT;
    *layout = (struct samples_layout){
        .width_px = width_px,
        .height_px = height_px,
        .light_count = plan->light_count,
        .sub_samples = plan->sub_samples,
        .indirect_strata = plan->indirect_strata_per_axis * plan->indirect_strata_per_axis,
        .lens_strata = plan->lens_strata_per_axis * plan->lens_strata_per_axis,
        .planes = plan_pass_planes(plan, pass),
    };
    if (layout->planes & PLANE_BIT(LONE)) layout->lone_parts = lone_parts(plan);
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const uint32_t l = plan->lights[k].strata_per_axis;
        layout->light_strata[k] = l * l;
        layout->light_planes[k] = pass == 0 ? (uint8_t)plan_light_planes(plan, k) : 0;
    }
    return 0;
}

int samples_layout_init(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                        int32_t width_px, int32_t height_px)
{
    const int error = layout_start(layout, plan, pass, width_px, height_px);
    return error ? error : samples_layout_place(layout);
}

int samples_layout_subset(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                          int32_t width_px, int32_t height_px, uint64_t planes,
                          const uint8_t *light_planes)
{
    const int error = layout_start(layout, plan, pass, width_px, height_px);
    if (error) return error;
    if (planes & ~layout->planes) return ERR_RANGE;
    layout->planes = planes;
    for (uint32_t k = 0; k < layout->light_count; k++) {
        if (light_planes[k] & ~(uint32_t)layout->light_planes[k]) return ERR_RANGE;
        layout->light_planes[k] = light_planes[k];
    }
    return samples_layout_place(layout);
}
