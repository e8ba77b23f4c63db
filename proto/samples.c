#include "proto/samples.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/samples_layout.h"

#define DATA_ALIGN_BYTES 64u

/* `memory` has room to align the data. */
static int create(const struct samples_layout *layout, void *memory, struct samples **out)
{
    struct samples *s = calloc(1, sizeof *s);
    if (!s || !memory) {
        free(s);
        free(memory);
        return ERR_MEMORY;
    }
    s->layout = *layout;
    s->memory = memory;
    s->data = (uint8_t *)memory + (-(uintptr_t)memory & (DATA_ALIGN_BYTES - 1));
    *out = s;
    return 0;
}

int samples_create_unset(const struct samples_layout *layout, struct samples **out)
{
    return create(layout, malloc(layout->total_bytes + DATA_ALIGN_BYTES), out);
}

/* Fresh pages are zero, so that planes that were not sent cost nothing. */
int samples_create(const struct samples_layout *layout, struct samples **out)
{
    return create(layout, calloc(1, layout->total_bytes + DATA_ALIGN_BYTES), out);
}

void samples_destroy(struct samples **s)
{
    if (!*s) return;
    free((*s)->memory);
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
