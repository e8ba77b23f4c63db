#include "proto/samples.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/samples_layout.h"

#define DATA_ALIGN_BYTES 64u

/* Whole cache lines, and at least one, as aligned_alloc wants. */
static size_t data_bytes(const struct samples_layout *layout)
{
    return (layout->total_bytes / DATA_ALIGN_BYTES + 1) * DATA_ALIGN_BYTES;
}

int samples_create_unset(const struct samples_layout *layout, struct samples **out)
{
    struct samples *s = calloc(1, sizeof *s);
    if (!s) return ERR_MEMORY;
    s->layout = *layout;
    s->data = aligned_alloc(DATA_ALIGN_BYTES, data_bytes(layout));
    if (!s->data) {
        free(s);
        return ERR_MEMORY;
    }
    *out = s;
    return 0;
}

int samples_create(const struct samples_layout *layout, struct samples **out)
{
    const int error = samples_create_unset(layout, out);
    if (!error) memset((*out)->data, 0, data_bytes(layout));
    return error;
}

void samples_destroy(struct samples **s)
{
    if (!*s) return;
    free((*s)->data);
    lone_destroy(&(*s)->lone);
    free(*s);
    *s = NULL;
}

size_t samples_bytes(const struct samples *s)
{
    return s->layout.total_bytes + lone_bytes(s->lone);
}

uint32_t samples_lone_places(const struct samples_layout *layout)
{
    return (uint32_t)layout->width_px * (uint32_t)layout->height_px * layout->sub_samples;
}

static uint8_t *component_at(const struct samples *s, uint32_t offset, enum samples_group group,
                             uint32_t component)
{
    const size_t area = (size_t)s->layout.width_px * (size_t)s->layout.height_px;
    return s->data + offset + component * area * samples_element_bytes(group);
}

static void *plane_component(const struct samples *s, enum plane_id plane, uint32_t component,
                             enum samples_group group)
{
    assert(plane < PLANE_ID_COUNT && samples_plane_kind(plane)->group == group);
    const uint32_t offset = s->layout.offset[plane];
    if (offset == SAMPLES_ABSENT) return NULL;
    assert(component < samples_plane_components(&s->layout, plane));
    return component_at(s, offset, group, component);
}

static void *light_component(const struct samples *s, uint32_t light, enum light_plane_id plane,
                             uint32_t component)
{
    assert(light < s->layout.light_count);
    const uint32_t offset = s->layout.light_offset[light][plane];
    if (offset == SAMPLES_ABSENT) return NULL;
    assert(component < samples_light_plane_components(&s->layout, light, plane));
    return component_at(s, offset, samples_light_plane_kind(plane)->group, component);
}

float *samples_f32(const struct samples *s, enum plane_id plane, uint32_t component)
{
    assert(plane == PLANE_DEPTH || plane == PLANE_LENS_RADIANCE || plane == PLANE_LENS_MORE ||
           (PLANES_PATH >> plane & 1u));
    return plane_component(s, plane, component, SAMPLES_GROUP_4);
}

uint32_t *samples_u32(const struct samples *s, enum plane_id plane, uint32_t component)
{
    assert(plane == PLANE_NORMAL || plane == PLANE_ID || plane == PLANE_LENS_ALBEDO ||
           plane == PLANE_LENS_LIGHT || plane == PLANE_LENS_LOBE);
    return plane_component(s, plane, component, SAMPLES_GROUP_4);
}

uint16_t *samples_u16(const struct samples *s, enum plane_id plane, uint32_t component)
{
    return plane_component(s, plane, component, SAMPLES_GROUP_2);
}

float *samples_light_irradiance(const struct samples *s, uint32_t light)
{
    return light_component(s, light, LIGHT_PLANE_IRRADIANCE, 0);
}

uint8_t *samples_light_visibility(const struct samples *s, uint32_t light, uint32_t byte)
{
    return light_component(s, light, LIGHT_PLANE_VISIBILITY, byte);
}

uint16_t *samples_light_slope(const struct samples *s, uint32_t light, uint32_t which)
{
    return light_component(s, light, LIGHT_PLANE_SLOPES, which);
}
