#include "proto/samples.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/samples_layout.h"

#define DATA_ALIGN_BYTES 64u

/* Whole cache lines, as aligned_alloc wants, and at least three bytes more than the planes take:
 * those that fill the end start with a whole number. */
static size_t data_bytes(const struct samples_layout *layout)
{
    return (layout->total_bytes / DATA_ALIGN_BYTES + 2) * DATA_ALIGN_BYTES;
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
    sparse_list_destroy(&(*s)->lone);
    sparse_list_destroy(&(*s)->mixed);
    free(*s);
    *s = NULL;
}

size_t samples_bytes(const struct samples *s)
{
    return s->layout.total_bytes + sparse_list_bytes(s->lone) + sparse_list_bytes(s->mixed);
}

uint32_t samples_lone_places(const struct samples_layout *layout)
{
    return (uint32_t)layout->width_px * (uint32_t)layout->height_px * layout->sub_samples;
}

uint32_t samples_mixed_places(const struct samples_layout *layout)
{
    return (uint32_t)layout->width_px * (uint32_t)layout->height_px * MIXED_SLOTS;
}

void *samples_component(const struct samples *s, uint32_t slot, uint32_t component)
{
    const size_t area = (size_t)s->layout.width_px * (size_t)s->layout.height_px;
    assert(slot < s->layout.slots);
    if (s->layout.offset[slot] == SAMPLES_ABSENT) return NULL;
    assert(component < s->layout.components[slot]);
    return s->data + s->layout.offset[slot] +
           component * area * samples_type_bytes(samples_plane(slot)->type);
}

float *samples_f32(const struct samples *s, enum plane_id plane, uint32_t component)
{
    assert(samples_plane(plane)->type == SAMPLES_F32);
    return samples_component(s, plane, component);
}

uint32_t *samples_u32(const struct samples *s, enum plane_id plane, uint32_t component)
{
    assert(samples_plane(plane)->type == SAMPLES_U32);
    return samples_component(s, plane, component);
}

uint16_t *samples_u16(const struct samples *s, enum plane_id plane, uint32_t component)
{
    assert(samples_group(samples_plane(plane)->type) == SAMPLES_GROUP_2);
    return samples_component(s, plane, component);
}

float *samples_light_irradiance(const struct samples *s, uint32_t light)
{
    return samples_component(s, samples_light_slot(light, LIGHT_PLANE_IRRADIANCE), 0);
}

uint8_t *samples_light_visibility(const struct samples *s, uint32_t light, uint32_t byte)
{
    return samples_component(s, samples_light_slot(light, LIGHT_PLANE_VISIBILITY), byte);
}

uint16_t *samples_light_slope(const struct samples *s, uint32_t light, uint32_t which)
{
    return samples_component(s, samples_light_slot(light, LIGHT_PLANE_SLOPES), which);
}

uint16_t *samples_light_weight(const struct samples *s, uint32_t light)
{
    return samples_component(s, samples_light_slot(light, LIGHT_PLANE_DIFFUSE_WEIGHT), 0);
}
