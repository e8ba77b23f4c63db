#include "worker/trace/path/centre_gbuffer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "proto/lens_lobe.h"
#include "proto/lens_slope.h"
#include "proto/samples.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/path/glossy_lobes.h"

/* Two points match if their normals are up to about 8 degrees apart and if they are off each
 * other's tangent planes by three quarters of a pixel and SLACK of their distance at most. */
#define COSINE_MIN 0.99f
#define PLANE_PX   0.75f
#define SLACK      0.015f

/* Bounce rays leave surfaces that reflect this much of some colour (ALBEDO_BLACK), by a margin. */
#define ALBEDO_MIN (1.0f / 65535.0f)

/* The lens as the surface sees it may take this part of the spread of what a lobe reflects. */
#define LOBE_SHARE 0.5f
#define REFLECTED  1.330380f /* 2 / sqrt(2.26) */

struct gbuffer_pixel {
    float point[3], normal[3];
    float alpha; /* of its glossy lobe; 0: none */
    bool lit;    /* shows a surface whose light a field has */
};

static int32_t cell_of(int32_t pixel)
{
    return pixel >= 0 ? pixel / LANES_ACROSS : -((LANES_ACROSS - 1 - pixel) / LANES_ACROSS);
}

int centre_gbuffer_init(struct centre_gbuffer *out, const struct path_context *c, struct rect tile)
{
    const struct rect image = {0, 0, c->plan->width_px, c->plan->height_px};
    const int32_t reach = (int32_t)LENS_RELIGHT_SLOPE_MAX + 1;
    const struct rect r = rect_intersect(rect_grow(tile, reach), image);
    out->cells =
        (struct rect){cell_of(r.x0), cell_of(r.y0), cell_of(r.x1 - 1) + 1, cell_of(r.y1 - 1) + 1};
    const size_t count = (size_t)rect_area(out->cells);
    out->memory = malloc(count * (LANES * sizeof *out->centres + sizeof *out->traced));
    if (!out->memory) return ERR_MEMORY;
    out->centres = out->memory;
    out->traced = (bool *)(void *)(out->centres + count * LANES);
    memset(out->traced, 0, count * sizeof *out->traced);
    out->context = *c;
    queries_init_rays(&out->rays);
    return 0;
}

void centre_gbuffer_fini(struct centre_gbuffer *centres)
{
    free(centres->memory);
    centres->memory = NULL;
}

/* Returns whether a plan's light field has light of this lane's surface. */
static bool is_lit(const struct plan *plan, const struct surface *s, int i)
{
    if (!s->hit.on[i]) return false;
    return plan->lens_relight == LENS_RELIGHT_DIFFUSE || (s->albedo.x[i] >= ALBEDO_MIN) |
                                                             (s->albedo.y[i] >= ALBEDO_MIN) |
                                                             (s->albedo.z[i] >= ALBEDO_MIN);
}

static void trace_cell(struct centre_gbuffer *l, int32_t column, int32_t row, size_t cell)
{
    const struct path_context *c = &l->context;
    const struct plan *plan = c->plan;
    const struct rect image = {0, 0, plan->width_px, plan->height_px};
    const struct surface *s = &l->vertex.surface;
    struct gbuffer_pixel *out = l->centres + cell * LANES;
    block_init(&l->block, column * LANES_ACROSS, row * LANES_ACROSS, plan->width_px,
               plan->height_px, image);
    primary_trace(c->queries, plan, &l->block, &l->rays, &l->vertex.surface);
    l->vertex.depth = 0;
    l->vertex.mirrors.any = false;
    if (c->mirrors) mirrors_follow(c, NULL, &l->rays, &l->vertex);
    l->vertex.active = l->vertex.surface.hit;
    path_resolve(c, &l->rays, &l->vertex);
    struct glossy_lobes lobes = {.on = {{0}}};
    if (plan->planes & PLANE_BIT(LENS_LOBE)) glossy_lobes_find(&l->vertex, &lobes);
    for (int i = 0; i < LANES; i++) {
        out[i] = (struct gbuffer_pixel){.alpha = lobes.on.on[i] ? lobes.alpha[i] : 0.0f,
                                        .lit = is_lit(plan, s, i) || lobes.on.on[i]};
        mirrors_image(&l->vertex, i, out[i].point, out[i].normal);
    }
    l->traced[cell] = true;
    c->counters->value[COUNTER_RAYS_LENS_CENTRES] += lanes_count(&l->block.inside);
}

/* Returns the pixel's centre, or NULL outside the image and out of reach. */
static const struct gbuffer_pixel *centre_at(struct centre_gbuffer *l, float x, float y)
{
    const struct plan *plan = l->context.plan;
    if (!(x >= 0.0f && y >= 0.0f && x < (float)plan->width_px && y < (float)plan->height_px))
        return NULL;
    const int32_t px = (int32_t)x, py = (int32_t)y;
    const int32_t column = px / LANES_ACROSS, row = py / LANES_ACROSS;
    if (column < l->cells.x0 || column >= l->cells.x1 || row < l->cells.y0 || row >= l->cells.y1)
        return NULL;
    const size_t cell =
        (size_t)(row - l->cells.y0) * (size_t)rect_width(l->cells) + (size_t)(column - l->cells.x0);
    if (!l->traced[cell]) trace_cell(l, column, row, cell);
    return l->centres + cell * LANES + (size_t)(py % LANES_ACROSS * LANES_ACROSS) +
           (size_t)(px % LANES_ACROSS);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the depth as a sample sends it. */
static float travelled(const struct plan *plan, float z)
{
    return half_to_float(half_from_float(z / plan->length_unit)) * plan->length_unit;
}

static bool is_same(const struct plan *plan, const float point[3], const float normal[3],
                    float distance, const struct gbuffer_pixel *centre)
{
    const float d[3] = {point[0] - centre->point[0], point[1] - centre->point[1],
                        point[2] - centre->point[2]};
    const float allowed = PLANE_PX * plan_pixel_size(plan, distance) + SLACK * sqrtf(dot(d, d));
    return dot(normal, centre->normal) >= COSINE_MIN && fabsf(dot(d, centre->normal)) <= allowed &&
           fabsf(dot(d, normal)) <= allowed;
}

/* Returns whether fields light a sample that far ahead. Its slope as it is sent decides. */
static bool is_near_focus(const struct plan *plan, float ahead)
{
    const float slope = half_to_float(half_from_float(lens_slope(lens_sloper_of(plan), ahead)));
    return fabsf(slope) < LENS_RELIGHT_SLOPE_MAX;
}

/* Returns the centre that shows lane i's point, or NULL. */
static const struct gbuffer_pixel *find_centre(struct centre_gbuffer *l,
                                               const struct path_vertex *v, int i)
{
    const struct plan *plan = l->context.plan;
    const struct plan_camera *c = &plan->camera;
    float at[3], normal[3];
    mirrors_image(v, i, at, normal);
    const float from[3] = {at[0] - c->eye[0], at[1] - c->eye[1], at[2] - c->eye[2]};
    const float z = dot(from, c->forward), read = travelled(plan, z);
    if (!(z > 0.0f)) return NULL;
    const float a = dot(from, c->right) / z, b = dot(from, c->up) / z;
    const float x = 0.5f * (a / c->half_width + c->centre_x + 1.0f) * (float)plan->width_px;
    const float y = 0.5f * (1.0f - c->centre_y - b / c->half_height) * (float)plan->height_px;
    const struct gbuffer_pixel *centre = centre_at(l, x, y);
    if (!centre || !centre->lit) return NULL;
    const float scale = read / z;
    const float point[3] = {c->eye[0] + from[0] * scale, c->eye[1] + from[1] * scale,
                            c->eye[2] + from[2] * scale};
    const float distance = read * sqrtf(1.0f + a * a + b * b);
    return is_same(plan, point, normal, distance, centre) ? centre : NULL;
}

/* Returns whether a sample's lobe and the centre's are alike, and wide beside the lens. A GGX
 * lobe's facets are spread by alpha / sqrt(2.26), and what it reflects by twice that. */
static bool is_same_lobe(const struct plan *plan, float ahead, const struct glossy_lobes *lobes,
                         int i, const struct gbuffer_pixel *centre)
{
    const float lens = plan->camera.aperture_radius, alpha = lobes->alpha[i];
    const float least = lobes->stretch[i] > 0.0f ? alpha * sqrtf(lobes->stretch[i]) : alpha;
    return lens_lobes_alike(alpha, centre->alpha) && lens <= LOBE_SHARE * REFLECTED * least * ahead;
}

void centre_gbuffer_match(struct centre_gbuffer *centres, const struct path_packet *p,
                          const struct path_vertex *v, struct glossy_lobes *lobes,
                          struct lanes_mask *lit)
{
    const struct plan *plan = centres->context.plan;
    for (int i = 0; i < LANES; i++) {
        const struct gbuffer_pixel *centre = NULL;
        const bool active = i < (int)p->count && v->active.on[i];
        const float ahead = active ? path_ahead(&centres->context, p, v, (uint32_t)i) : 0.0f;
        if (active && is_near_focus(plan, ahead)) centre = find_centre(centres, v, i);
        lit->on[i] = centre ? -1 : 0;
        if (!centre || !is_same_lobe(plan, ahead, lobes, i, centre)) lobes->on.on[i] = 0;
    }
}
