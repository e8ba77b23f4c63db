#include "server/reconstruct/indirect/indirect_field.h"

#include <string.h>

#include "proto/samples.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/patch/surface.h"

#define OWN_ARRAYS 11 /* points, normals, object, falloff, off, pixel, nearness */
#define TINY       1e-30f

_Static_assert(INDIRECT_TAPS >= 2 * INDIRECT_REACH_MAX_PX, "a line's neighbours");
_Static_assert(sizeof(int32_t) == sizeof(float), "objects are carved like numbers");

static int32_t rounded(int32_t count)
{
    return (count + SIMD_LANES - 1) / SIMD_LANES * SIMD_LANES;
}

static int carve(struct indirect_neighbourhood *p, int32_t reach, uint32_t spares)
{
    const int32_t room = rounded(reach);
    p->field.stride = rounded(room + rect_width(p->rect) + SIMD_LANES + room);
    p->area = (size_t)p->field.stride * (size_t)rect_height(p->rect);
    p->origin = (size_t)room;
    const size_t bytes = (OWN_ARRAYS + spares) * p->area * sizeof(float);
    p->memory = scratch_take(p->scratch, bytes);
    if (!p->memory) return ERR_MEMORY;
    memset(p->memory, 0, bytes);
    float *next = p->memory;
    float **const arrays[] = {&p->point[0],  &p->point[1],  &p->point[2], &p->normal[0],
                              &p->normal[1], &p->normal[2], &p->falloff,  &p->off,
                              &p->pixel,     &p->nearness};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++, next += p->area) *arrays[k] = next;
    p->object = (int32_t *)(void *)next;
    p->spare = next + p->area;
    return 0;
}

static void load_row(const struct surface_view *view, float far, const struct patch *patch,
                     int32_t y, struct indirect_neighbourhood *p)
{
    const size_t to = indirect_neighbourhood_index(p, p->rect.x0, y);
    const size_t from = patch_pixel(patch, p->rect.x0, y);
    const size_t count = (size_t)rect_width(p->rect);
    surface_points(view, p->rect.x0, y, (uint32_t)count, patch->depth + from, p->point[0] + to,
                   p->point[1] + to, p->point[2] + to);
    const float *depth = patch->depth + from,
                *bounce_distance_min = patch->bounce_distance_min + from;
    for (size_t i = 0; i < count; i++) {
        const uint32_t id = patch->id[from + i];
        p->object[to + i] = depth[i] > 0.0f ? (int32_t)id : 0;
    }
    for (int k = 0; k < 3; k++) {
        const float *in = patch->normal[k] + from;
        float *normal = p->normal[k] + to;
        for (size_t i = 0; i < count; i++) {
            const float value = in[i];
            normal[i] = bounce_distance_min[i] > 0.0f ? value : 0.0f;
        }
    }
    for (size_t i = 0; i < count; i++) {
        const bool measured = patch_is_measured(patch, from + i);
        const float size = surface_pixel_size(view, depth[i]), z = bounce_distance_min[i];
        p->pixel[to + i] = !measured ? 0.0f : size > TINY ? size : TINY;
        p->nearness[to + i] = (measured & (z < far)) ? 1.0f / (z > TINY ? z : TINY) : 0.0f;
    }
}

int indirect_neighbourhood_create(const struct plan *plan, const struct patch *patch,
                                  struct rect rect, int32_t reach, uint32_t spares,
                                  struct indirect_neighbourhood *out)
{
    struct surface_view view;
    *out = (struct indirect_neighbourhood){.rect = rect, .scratch = patch->scratch};
    const int error = carve(out, reach, spares);
    if (error) return error;
    for (int k = 0; k < 3; k++) {
        out->field.point[k] = out->point[k];
        out->field.normal[k] = out->normal[k];
    }
    out->field.object = out->object;
    out->field.falloff = out->falloff;
    out->field.off = out->off;
    surface_view_init(&view, plan);
    for (int32_t y = rect.y0; y < rect.y1; y++)
        load_row(&view, BOUNCE_DISTANCE_NONE * plan->length_unit, patch, y, out);
    return 0;
}

void indirect_neighbourhood_fini(struct indirect_neighbourhood *around)
{
    scratch_give(around->scratch, around->memory);
    *around = (struct indirect_neighbourhood){0};
}

struct indirect_run indirect_neighbourhood_run(const struct indirect_neighbourhood *around,
                                               struct rect rect, int32_t y, bool along_x,
                                               int32_t reach)
{
    const int32_t above = y - around->rect.y0, below = around->rect.y1 - 1 - y;
    return (struct indirect_run){
        .first = indirect_neighbourhood_index(around, rect.x0, y),
        .count = (uint32_t)rounded(rect_width(rect)),
        .step = along_x ? 1 : around->field.stride,
        .before = along_x || above > reach ? reach : above,
        .after = along_x || below > reach ? reach : below,
    };
}
