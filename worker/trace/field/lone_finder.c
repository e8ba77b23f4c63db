#include "worker/trace/field/lone_finder.h"

#include <string.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "worker/trace/field/field_kernels.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/hit/primary.h"

void lone_finder_init(struct lone_finder *f, const struct path_context *c, struct rect tile,
                      struct samples *samples)
{
    const struct plan *plan = c->plan;
    const struct rect image = {0, 0, plan->width_px, plan->height_px};
    const struct rect r = rect_intersect(rect_grow(tile, 1), image);
    f->kernels = KERNELS_FOR(field_kernels, c->queries->scene->isa);
    f->context = c;
    f->samples = samples;
    f->tile = tile;
    f->cells = (struct rect){r.x0 / LANES_ACROSS, r.y0 / LANES_ACROSS,
                             (r.x1 - 1) / LANES_ACROSS + 1, (r.y1 - 1) / LANES_ACROSS + 1};
    for (size_t i = 0; i < sizeof f->ring / sizeof f->ring[0]; i++) f->ring[i].traced = false;
    surface_view_init(&f->view, plan);
    queries_init_rays(&f->rays);
}

void lone_finder_resume(struct lone_finder *f, const struct path_context *c)
{
    f->context = c;
}

/* -- pixels around -- */

static void trace_cell(struct lone_finder *f, int32_t column, int32_t row, struct lone_cell *out)
{
    const struct path_context *c = f->context;
    const struct plan *plan = c->plan;
    const struct rect image = {0, 0, plan->width_px, plan->height_px};
    const struct surface *s = &f->surface;
    block_init(&f->block, column * LANES_ACROSS, row * LANES_ACROSS, plan->width_px,
               plan->height_px, image);
    primary_trace(c->queries, plan, &f->block, &f->rays, &f->surface);
    c->queries->kernels->pack_normals(&s->normal, 16, out->normal);
    memcpy(out->depth, s->distance, sizeof out->depth);
    memcpy(out->id, s->id, sizeof out->id);
    out->traced = true;
    c->counters->value[COUNTER_RAYS_PRIMARY] += lanes_count(&f->block.inside);
}

/* Returns the cell of a pixel beside the tile, which lies at the border of the cells. */
static struct lone_cell *cell_at(struct lone_finder *f, int32_t x, int32_t y)
{
    const struct rect c = f->cells;
    const int32_t column = x / LANES_ACROSS, row = y / LANES_ACROSS;
    struct lone_cell *side = f->ring + 3 * LONE_SIDE_CELLS + (row - c.y0);
    if (row == c.y0)
        side = f->ring + (column - c.x0);
    else if (row == c.y1 - 1)
        side = f->ring + LONE_SIDE_CELLS + (column - c.x0);
    else if (column == c.x0)
        side = f->ring + 2 * LONE_SIDE_CELLS + (row - c.y0);
    if (!side->traced) trace_cell(f, column, row, side);
    return side;
}

static bool is_in(struct rect r, int32_t x, int32_t y)
{
    return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
}

bool lone_finder_pixel(struct lone_finder *f, int32_t x, int32_t y, struct shown_surface *out,
                       uint32_t *full_id)
{
    const struct plan *plan = f->context->plan;
    float depth, facing[3];
    uint32_t normal, id;
    if (is_in(f->tile, x, y)) {
        const size_t e =
            (size_t)(y - f->tile.y0) * (size_t)rect_width(f->tile) + (size_t)(x - f->tile.x0);
        depth = samples_f32(f->samples, PLANE_DEPTH, 0)[e];
        normal = samples_u32(f->samples, PLANE_NORMAL, 0)[e];
        id = samples_u32(f->samples, PLANE_ID, 0)[e];
    } else {
        if (!is_in((struct rect){0, 0, plan->width_px, plan->height_px}, x, y)) return false;
        const struct lone_cell *cell = cell_at(f, x, y);
        const int lane = y % LANES_ACROSS * LANES_ACROSS + x % LANES_ACROSS;
        depth = cell->depth[lane];
        normal = cell->normal[lane];
        id = cell->id[lane];
    }
    if (!(depth > 0.0f)) return false;
    if (full_id) *full_id = id;
    octahedron_unpack16(normal, facing);
    shown_surface_init(&f->view, (float)x + 0.5f, (float)y + 0.5f, surface_distance(depth), facing,
                       surface_sub_id(id), out);
    return true;
}

/* Returns whether any pixel of the 3 x 3 shows the candidate's surface. */
static bool is_shown(struct lone_finder *f, const struct lone_candidate *sub)
{
    struct shown_surface pixel;
    float own = 0.0f;
    if (lone_finder_pixel(f, sub->x_px, sub->y_px, &pixel, NULL))
        own = surface_match(&f->view, &sub->surface, &pixel);
    float sum = own;
    for (int32_t dy = -1; dy <= 1; dy++)
        for (int32_t dx = -1; dx <= 1; dx++) {
            if (sum >= SURFACE_WEIGHT_MIN) return true;
            if (dx == 0 && dy == 0) continue;
            if (!lone_finder_pixel(f, sub->x_px + dx, sub->y_px + dy, &pixel, NULL)) continue;
            sum += (1.0f - own) * surface_share(sub->offset, dx, dy) *
                   surface_match(&f->view, &sub->surface, &pixel);
        }
    return sum >= SURFACE_WEIGHT_MIN;
}

/* -- sub-samples -- */

static void load_pixels(const struct lone_finder *f, const struct block *b, struct lone_pixels *p)
{
    const struct samples *s = f->samples;
    block_gather(b, samples_f32(s, PLANE_DEPTH, 0), p->depth, sizeof p->depth[0]);
    block_gather(b, samples_u32(s, PLANE_NORMAL, 0), p->normal, sizeof p->normal[0]);
    block_gather(b, samples_u32(s, PLANE_ID, 0), p->id, sizeof p->id[0]);
    for (int i = 0; i < LANES; i++) {
        p->depth[i] = surface_distance(p->depth[i]);
        p->id[i] = surface_sub_id(p->id[i]);
        p->coarse[i] = octahedron_coarsen(p->normal[i]);
    }
    f->kernels->unpack_normals(p->normal, &p->facing);
}

static void load_subs(const struct lone_finder *f, const struct block *b, uint32_t k,
                      struct lone_pixels *p)
{
    const struct samples *s = f->samples;
    const float unit = f->context->plan->length_unit;
    _Alignas(LANES_ALIGN) uint16_t depth[LANES], normal[LANES], id[LANES];
    block_gather(b, samples_u16(s, PLANE_SUB_DEPTH, k), depth, sizeof depth[0]);
    block_gather(b, samples_u16(s, PLANE_SUB_NORMAL, k), normal, sizeof normal[0]);
    block_gather(b, samples_u16(s, PLANE_SUB_ID, k), id, sizeof id[0]);
    half_to_floats(depth, p->distance, LANES);
    for (int i = 0; i < LANES; i++) {
        p->distance[i] = surface_sub_distance(p->distance[i], p->depth[i], unit);
        p->sub_depth[i] = depth[i];
        p->sub_normal[i] = normal[i];
        p->sub_id[i] = id[i];
    }
}

static void store_settled(const struct lone_finder *f, const struct block *b, uint32_t k,
                          const struct lone_pixels *p)
{
    _Alignas(LANES_ALIGN) uint16_t depth[LANES], normal[LANES];
    for (int i = 0; i < LANES; i++) {
        depth[i] = (uint16_t)p->sub_depth[i];
        normal[i] = (uint16_t)p->sub_normal[i];
    }
    block_store_u16(b, depth, samples_u16(f->samples, PLANE_SUB_DEPTH, k));
    block_store_u16(b, normal, samples_u16(f->samples, PLANE_SUB_NORMAL, k));
}

static bool reflects(const struct samples *s, uint32_t k, uint32_t element)
{
    uint32_t sum = 0;
    for (uint32_t c = 3 * k; c < 3 * k + 3; c++) {
        const uint16_t *lobe = samples_u16(s, PLANE_SUB_REFLECTANCE, c);
        sum += samples_u16(s, PLANE_SUB_ALBEDO, c)[element];
        sum += lobe ? lobe[element] : 0;
    }
    return sum > 0;
}

/* Decides what match_subs has left open: true only when the sub-sample shows its own pixel's
 * surface. */
static bool is_surely_own(const struct lone_finder *f, const struct block *b,
                          const struct lone_pixels *p, int i, struct surface_facing *facing)
{
    if (!p->alike.on[i]) return false;
    if (!facing->known) {
        struct shown_surface pixel;
        const float normal[3] = {p->facing.x[i], p->facing.y[i], p->facing.z[i]};
        shown_surface_init(&f->view, (float)b->x_px[i] + 0.5f, (float)b->y_px[i] + 0.5f,
                           p->depth[i], normal, p->id[i], &pixel);
        surface_face(&f->view, &pixel, facing);
    }
    return surface_near_facing(&f->view, p->depth[i], p->distance[i], facing);
}

static bool is_lone(struct lone_finder *f, const struct block *b, const struct lone_pixels *p,
                    uint32_t k, int i)
{
    const struct plan *plan = f->context->plan;
    if (!reflects(f->samples, k, b->element[i])) return false;
    struct lone_candidate sub = {.x_px = b->x_px[i], .y_px = b->y_px[i]};
    float normal[3];
    octahedron_unpack8((uint16_t)p->sub_normal[i], normal);
    pattern_pixel(&plan->pattern, sub.x_px, sub.y_px, k, plan->sub_samples, sub.offset);
    shown_surface_init(&f->view, (float)sub.x_px + sub.offset[0], (float)sub.y_px + sub.offset[1],
                       p->distance[i], normal, p->sub_id[i], &sub.surface);
    return !is_shown(f, &sub);
}

/* Loads sub-samples k, and has those that surely show their pixel's surface lie and face as it
 * does; p->open: others that show something. */
static void settle(const struct lone_finder *f, const struct block *b, uint32_t k,
                   struct lone_pixels *p, struct surface_facing facing[LANES])
{
    load_subs(f, b, k, p);
    const bool open = f->kernels->match_subs(&f->view, &b->kept, p);
    for (int i = 0; open && i < LANES; i++) {
        if (!p->open.on[i] || !is_surely_own(f, b, p, i, &facing[i])) continue;
        p->open.on[i] = 0;
        p->sub_depth[i] = 0;
        p->sub_normal[i] = p->coarse[i];
        p->settled = true;
    }
    if (p->settled) store_settled(f, b, k, p);
}

uint32_t lone_finder_look(struct lone_finder *f, const struct block *b,
                          struct lanes_mask lone[LIMIT_SUB_SAMPLES])
{
    struct surface_facing facing[LANES] = {{.known = false}};
    struct lone_pixels p;
    uint32_t count = 0;
    load_pixels(f, b, &p);
    for (uint32_t k = 0; k < f->context->plan->sub_samples; k++) {
        settle(f, b, k, &p, facing);
        for (int i = 0; i < LANES; i++)
            lone[k].on[i] = p.open.on[i] ? -(int32_t)is_lone(f, b, &p, k, i) : 0;
        count += lanes_count(&lone[k]);
    }
    return count;
}

void lone_finder_settle(const struct lone_finder *f, const struct block *b)
{
    struct surface_facing facing[LANES] = {{.known = false}};
    struct lone_pixels p;
    load_pixels(f, b, &p);
    for (uint32_t k = 0; k < f->context->plan->sub_samples; k++) settle(f, b, k, &p, facing);
}
