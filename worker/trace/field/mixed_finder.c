#include "worker/trace/field/mixed_finder.h"

#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "worker/trace/field/field_kernels.h"

void mixed_finder_fini(struct mixed_finder *f)
{
    free(f->memory);
    f->memory = NULL;
    f->memory_bytes = 0;
}

/* -- cells -- */

#define CELL_BYTES (7 * sizeof(float) + sizeof(uint32_t) + 7)

static int reserve(struct mixed_finder *f)
{
    struct mixed_cells *c = &f->cells;
    const size_t stride = (size_t)rect_width(f->tile) + 2;
    const size_t area = stride * ((size_t)rect_height(f->tile) + 2);
    if (f->memory_bytes < area * CELL_BYTES) {
        free(f->memory);
        f->memory = malloc(area * CELL_BYTES);
        f->memory_bytes = f->memory ? area * CELL_BYTES : 0;
        if (!f->memory) return ERR_MEMORY;
    }
    float *at = f->memory;
    c->stride = stride;
    for (int k = 0; k < 3; k++, at += area) c->point[k] = at;
    for (int k = 0; k < 3; k++, at += area) c->normal[k] = at;
    c->distance = at;
    c->id = (uint32_t *)(void *)(at + area);
    c->shines = (uint8_t *)(void *)(c->id + area);
    for (int k = 0; k < 4; k++) c->apart[k] = c->shines + (size_t)(k + 1) * area;
    f->edge = c->shines + 5 * area;
    f->mixed = f->edge + area;
    return 0;
}

static bool may_shine(const struct mixed_finder *f, uint32_t full_id)
{
    const struct render_scene *scene = f->context->queries->scene;
    if (full_id == 0) return false;
    return scene->meshes[scene->blob->instances[full_id - 1].mesh].traits & MESH_SHINES;
}

/* Fills a pixel beside the tile. */
static void fill_beside(const struct mixed_finder *f, int32_t x, int32_t y)
{
    const struct plan *plan = f->context->plan;
    const struct mixed_cells *c = &f->cells;
    const size_t i = mixed_cell(f, x, y);
    const bool outside = x < 0 || y < 0 || x >= plan->width_px || y >= plan->height_px;
    struct shown_surface shown = {.distance = 0.0f};
    uint32_t full_id = 0;
    if (!lone_finder_pixel(f->lone, x, y, &shown, &full_id)) {
        memset(&shown, 0, sizeof shown);
        shown.distance = outside ? -1.0f : 0.0f;
        full_id = 0;
    }
    for (int k = 0; k < 3; k++) {
        c->point[k][i] = shown.point[k];
        c->normal[k][i] = shown.normal[k];
    }
    c->distance[i] = shown.distance;
    c->id[i] = shown.id;
    c->shines[i] = may_shine(f, full_id);
}

/* Fills the tile's own pixels of a row. */
static void fill_row(const struct mixed_finder *f, int32_t y)
{
    const size_t width = (size_t)rect_width(f->tile), e = (size_t)(y - f->tile.y0) * width;
    const size_t first = mixed_cell(f, f->tile.x0, y);
    const uint32_t *id = samples_u32(f->samples, PLANE_ID, 0) + e;
    f->lone->kernels->place_cells(
        &f->lone->view, f->tile.x0, y, width, samples_f32(f->samples, PLANE_DEPTH, 0) + e,
        samples_u32(f->samples, PLANE_NORMAL, 0) + e, id, &f->cells, first);
    for (size_t i = 0; i < width; i++)
        f->cells.shines[first + i] =
            i > 0 && id[i] == id[i - 1] ? f->cells.shines[first + i - 1] : may_shine(f, id[i]);
}

static void fill_cells(const struct mixed_finder *f)
{
    const struct rect around = rect_grow(f->tile, 1);
    for (int32_t x = around.x0; x < around.x1; x++) {
        fill_beside(f, x, around.y0);
        fill_beside(f, x, around.y1 - 1);
    }
    for (int32_t y = f->tile.y0; y < f->tile.y1; y++) {
        fill_beside(f, around.x0, y);
        fill_row(f, y);
        fill_beside(f, around.x1 - 1, y);
    }
}

struct shown_surface mixed_surface(const struct mixed_cells *cells, size_t cell)
{
    struct shown_surface out = {.distance = cells->distance[cell], .id = cells->id[cell]};
    for (int k = 0; k < 3; k++) {
        out.point[k] = cells->point[k][cell];
        out.normal[k] = cells->normal[k][cell];
    }
    return out;
}

/* -- centres around -- */

/* Compares each cell with the one to the right and the three below; of the last row, which is not
 * the tile's, nothing is asked. */
static void compare_cells(const struct mixed_finder *f)
{
    const struct mixed_cells *c = &f->cells;
    const struct rect around = rect_grow(f->tile, 1);
    const size_t offsets[4] = {1, c->stride - 1, c->stride, c->stride + 1};
    for (int k = 0; k < 4; k++)
        for (int32_t y = around.y0; y + 1 < around.y1; y++)
            f->lone->kernels->compare_cells(&f->lone->view, c,
                                            mixed_cell(f, around.x0, y) + (k == 1), offsets[k],
                                            c->stride - 1, c->apart[k]);
}

/* Marks pixels of which one of the eight centres around shows another surface. */
static void mark_apart(const struct mixed_finder *f)
{
    const struct mixed_cells *c = &f->cells;
    const size_t width = (size_t)rect_width(f->tile), s = c->stride;
    for (int32_t y = f->tile.y0; y < f->tile.y1; y++) {
        const size_t first = mixed_cell(f, f->tile.x0, y);
        const uint8_t *right = c->apart[0] + first, *left_below = c->apart[1] + first;
        const uint8_t *below = c->apart[2] + first, *right_below = c->apart[3] + first;
        uint8_t *edge = f->edge + (size_t)(y - f->tile.y0) * width;
        for (size_t i = 0; i < width; i++)
            edge[i] = right[i] | left_below[i] | below[i] | right_below[i] | *(right + i - 1) |
                      *(left_below + i - s + 1) | *(below + i - s) | *(right_below + i - s - 1);
    }
}

bool mixed_is_beside_lamp(const struct mixed_finder *f, int32_t x, int32_t y)
{
    const struct mixed_cells *c = &f->cells;
    const size_t i = mixed_cell(f, x, y), s = c->stride;
    bool any = false;
    for (size_t k = i - 1; k <= i + 1; k++)
        any |= c->shines[k - s] | c->shines[k] | c->shines[k + s];
    return any;
}

/* -- sub-samples -- */

/* Returns whether sub-sample k, of the centre's object, shows another surface than it. */
static bool is_other(const struct mixed_finder *f, size_t e, uint32_t k, uint16_t depth)
{
    const struct plan *plan = f->context->plan;
    const size_t width = (size_t)rect_width(f->tile);
    const int32_t x = f->tile.x0 + (int32_t)(e % width), y = f->tile.y0 + (int32_t)(e / width);
    const struct shown_surface own = mixed_surface(&f->cells, mixed_cell(f, x, y));
    struct shown_surface sub;
    float at[2], normal[3];
    octahedron_unpack8(samples_u16(f->samples, PLANE_SUB_NORMAL, k)[e], normal);
    pattern_pixel(&plan->pattern, x, y, k, plan->sub_samples, at);
    const float distance =
        surface_sub_distance(half_to_float(depth), own.distance, plan->length_unit);
    shown_surface_init(&f->lone->view, (float)x + at[0], (float)y + at[1], distance, normal, own.id,
                       &sub);
    return surface_match(&f->lone->view, &sub, &own) < 0.5f;
}

/* Marks pixels of which sub-sample k shows another surface than the centre. A depth of 0 says that
 * it does not (lone_finder.h). */
static void mark_others(const struct mixed_finder *f, uint32_t k)
{
    const size_t area = (size_t)rect_area(f->tile);
    const uint16_t *depth = samples_u16(f->samples, PLANE_SUB_DEPTH, k);
    const uint16_t *id = samples_u16(f->samples, PLANE_SUB_ID, k);
    const uint32_t *own = samples_u32(f->samples, PLANE_ID, 0);
    for (size_t e = 0; e < area; e++) {
        const uint32_t shown = own[e] > 0 ? surface_sub_id(own[e]) : 0;
        f->mixed[e] |= id[e] != shown;
        if (f->mixed[e] || id[e] == 0 || (depth[e] & 0x7fffu) == 0) continue;
        f->mixed[e] |= is_other(f, e, k, depth[e]);
    }
}

/* -- colours -- */

static void mark_plane(const struct mixed_finder *f, enum plane_id own, uint32_t own_component,
                       enum plane_id sub, uint32_t sub_component)
{
    const uint16_t *a = samples_u16(f->samples, own, own_component);
    const uint16_t *b = samples_u16(f->samples, sub, sub_component);
    if (a && b) f->lone->kernels->mark_colours(a, b, (size_t)rect_area(f->tile), f->mixed);
}

/* Marks pixels of which a sub-sample's colours are not the centre's. */
static void mark_colours(const struct mixed_finder *f, uint32_t k)
{
    for (uint32_t c = 0; c < 3; c++) {
        mark_plane(f, PLANE_ALBEDO, c, PLANE_SUB_ALBEDO, 3 * k + c);
        mark_plane(f, PLANE_GLOSSY_LOBE, c, PLANE_SUB_REFLECTANCE, 3 * k + c);
    }
}

int mixed_finder_look_around(struct mixed_finder *f, const struct path_context *c,
                             struct lone_finder *lone, const struct samples *samples)
{
    f->lone = lone;
    f->context = c;
    f->samples = samples;
    f->tile = lone->tile;
    lone_finder_resume(lone, c);
    const int error = reserve(f);
    if (error) return error;
    fill_cells(f);
    compare_cells(f);
    mark_apart(f);
    return 0;
}

int mixed_finder_look(struct mixed_finder *f, const struct path_context *c,
                      struct lone_finder *lone, const struct samples *samples)
{
    const int error = mixed_finder_look_around(f, c, lone, samples);
    if (error) return error;
    memcpy(f->mixed, f->edge, (size_t)rect_area(f->tile));
    for (uint32_t k = 0; k < c->plan->sub_samples; k++) {
        mark_others(f, k);
        mark_colours(f, k);
    }
    return 0;
}
