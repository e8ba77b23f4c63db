/* Where the planes of a tile lie. */
#include "proto/samples_layout.h"

/* Room that a result frame needs beside the samples: message fields, counters, masks, headers. */
#define RESULT_OVERHEAD_BYTES 8192u

static const struct samples_plane rows[PLANE_ID_COUNT + LIGHT_PLANE_COUNT] = {
#define ROW(key, type, count, per, values, merge)                                                  \
    {                                                                                              \
#key, SAMPLES_##type, count, SAMPLES_PER_##per, SAMPLES_##values, SAMPLES_##merge          \
    }
#define PLANE(number, name, key, type, count, per, values, merge, ...)                             \
    [number] = ROW(key, type, count, per, values, merge),
#define LIGHT_PLANE(number, name, key, type, count, per, values, ...)                              \
    [PLANE_ID_COUNT + number] = ROW(key, type, count, per, values, FIRST),
#include "proto/plane.def"
};

const struct samples_plane *samples_plane(uint32_t slot)
{
    return &rows[samples_row(slot)];
}

uint32_t samples_element_bytes(enum samples_group group)
{
    static const uint32_t bytes[SAMPLES_GROUP_COUNT] = {4, 2, 1};
    return bytes[group];
}

uint32_t samples_type_bytes(enum samples_type type)
{
    return samples_element_bytes(samples_group(type));
}

static uint32_t square(uint32_t side)
{
    return side * side;
}

static bool has(uint64_t planes, uint32_t light_planes, uint32_t slot)
{
    const uint32_t row = samples_row(slot);
    return row < PLANE_ID_COUNT ? planes >> row & 1 : light_planes >> (row - PLANE_ID_COUNT) & 1;
}

uint32_t samples_components(const struct plan *plan, uint32_t slot)
{
    const uint32_t light = samples_slot_light(slot);
    const uint32_t count[] = {
        [SAMPLES_PER_PIXEL] = 1,
        [SAMPLES_PER_SUB] = plan->sub_samples,
        [SAMPLES_PER_STRATUM] = square(plan->indirect_strata_per_axis),
        [SAMPLES_PER_LENS] = square(plan->lens_strata_per_axis),
        [SAMPLES_PER_BITS] = (square(plan->lights[light].strata_per_axis) + 7) / 8,
    };
    if (!has(plan->planes, plan_light_planes(plan, light), slot)) return 0;
    return samples_plane(slot)->components * count[samples_plane(slot)->per];
}

uint32_t samples_visibility_mask(const struct samples_layout *layout, uint32_t light)
{
    const uint32_t bits = (layout->light_strata[light] - 1) % 8 + 1;
    return (1u << bits) - 1;
}

void samples_layout_drop(struct samples_layout *layout, uint32_t slot)
{
    const uint32_t row = samples_row(slot);
    if (row < PLANE_ID_COUNT)
        layout->planes &= ~(UINT64_C(1) << row);
    else
        layout->light_planes[samples_slot_light(slot)] &= (uint8_t) ~(1u << (row - PLANE_ID_COUNT));
}

uint64_t samples_slot_bytes(const struct samples_layout *layout, uint32_t slot)
{
    return (uint64_t)layout->width_px * (uint64_t)layout->height_px * layout->components[slot] *
           samples_type_bytes(samples_plane(slot)->type);
}

/* Sums stay within 64 bits. */
static void place_group(struct samples_layout *layout, enum samples_group group, uint64_t *at)
{
    for (uint32_t i = 0; i < layout->slots; i++) {
        if (samples_group(samples_plane(i)->type) != group) continue;
        if (!has(layout->planes, layout->light_planes[samples_slot_light(i)], i)) continue;
        layout->offset[i] = (uint32_t)*at;
        *at += samples_slot_bytes(layout, i);
    }
}

/* Returns the bytes of lists of all sub-samples and all pixels. */
static uint64_t lists_max_bytes(const struct samples_layout *layout)
{
    uint64_t words = 0;
    if (layout->planes & PLANE_BIT(LONE))
        words += (uint64_t)samples_lone_places(layout) * lone_words(layout->lone_parts);
    if (layout->planes & PLANE_BIT(MIXED))
        words += (uint64_t)samples_mixed_places(layout) * (1 + layout->mixed_values);
    return words * sizeof(uint32_t);
}

int samples_layout_place(struct samples_layout *layout)
{
    uint64_t at = 0;
    const uint64_t most = LIMIT_FRAME_BYTES - RESULT_OVERHEAD_BYTES - lists_max_bytes(layout);
    for (uint32_t i = 0; i < layout->slots; i++) layout->offset[i] = SAMPLES_ABSENT;
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
        .slots = samples_light_slot(plan->light_count, 0),
        .lens_strata = square(plan->lens_strata_per_axis),
        .planes = plan_pass_planes(plan, pass),
    };
    if (layout->planes & PLANE_BIT(LONE)) layout->lone_parts = lone_parts(plan);
    if (layout->planes & PLANE_BIT(MIXED)) layout->mixed_values = mixed_values(plan);
    for (uint32_t i = 0; i < layout->slots; i++)
        layout->components[i] = samples_components(plan, i);
    for (uint32_t k = 0; k < plan->light_count; k++) {
        layout->light_strata[k] = square(plan->lights[k].strata_per_axis);
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
