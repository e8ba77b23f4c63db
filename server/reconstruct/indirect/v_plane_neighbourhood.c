#include "server/reconstruct/indirect/v_plane_neighbourhood.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ALIGN_BYTES 64u
#define TINY        1e-30f

_Static_assert(V_PLANE_STRATA_MAX == LIMIT_PLANE_STRATA_PER_AXIS, "whatever a plan may ask for");

static size_t rounded(size_t floats)
{
    const size_t unit = ALIGN_BYTES / sizeof(float);
    return (floats + unit - 1) / unit * unit;
}

/* Places all arrays of the neighbourhood in one allocation. */
static int carve(struct v_plane_neighbourhood *p)
{
    const size_t area = rounded((size_t)rect_area(p->rect)), l = p->field.strata;
    const size_t row = rounded((size_t)rect_width(p->rect)), per = sizeof(struct v_plane_walk) / 4;
    const size_t floats = 3 * per * area + (3 * l + 2) * row;
    float *next = p->memory = aligned_alloc(ALIGN_BYTES, floats * sizeof(float));
    if (!next) return ERR_MEMORY;
    memset(next, 0, floats * sizeof(float));
    p->sources = (struct v_plane_source *)(void *)next;
    p->walks[0] = (struct v_plane_walk *)(void *)(next += per * area);
    p->walks[1] = (struct v_plane_walk *)(void *)(next += per * area);
    p->strata.height = next += per * area;
    p->strata.sine = next += l * row;
    p->strata.cosine = next += l * row;
    p->jitter[0] = next += l * row;
    p->jitter[1] = next + row;
    p->strata.l = (uint32_t)l;
    p->strata.stride = row;
    return 0;
}

static void load_source(const struct surface_view *view, const struct patch *patch, size_t i,
                        struct v_plane_source *out)
{
    struct shown_surface s;
    if (!patch_is_measured(patch, i) || !surface_of_pixel(view, patch, i, &s)) return;
    const float pixel = surface_pixel_size(view, s.distance);
    out->pixel = pixel > TINY ? pixel : TINY;
    for (int k = 0; k < 3; k++) {
        const float way = k == 2 ? -1.0f : 1.0f; /* back, not forward */
        out->point[k] = way * s.point[k];
        out->normal[k] = way * s.normal[k];
    }
}

void v_plane_neighbourhood_row(struct v_plane_neighbourhood *p, int32_t x, int32_t y,
                               uint32_t count, struct v_plane_planes *planes)
{
    enum { RUN = 64 };
    int32_t at_x[RUN], at_y[RUN];
    planes->stride = (size_t)rect_area(p->patch->rect);
    planes->first = p->patch->indirect_strata + patch_pixel(p->patch, x, y);
    for (uint32_t k = 0; k < count; k += RUN) {
        const uint32_t n = count - k < RUN ? count - k : RUN;
        for (uint32_t i = 0; i < n; i++) {
            at_x[i] = x + (int32_t)(k + i);
            at_y[i] = y;
        }
        pattern_jitters(&p->plan->pattern, at_x, at_y, n, PATTERN_INDIRECT, p->jitter[0] + k,
                        p->jitter[1] + k);
    }
    p->strata.count = count;
    p->kernels->strata(&p->strata, p->jitter[0], p->jitter[1]);
}

static void load_row(struct v_plane_neighbourhood *p, struct rect seen, int32_t y)
{
    const size_t to = v_plane_index(p, seen.x0, y), from = patch_pixel(p->patch, seen.x0, y);
    struct v_plane_planes planes;
    v_plane_neighbourhood_row(p, seen.x0, y, (uint32_t)rect_width(seen), &planes);
    for (size_t i = 0; i < (size_t)rect_width(seen); i++) {
        struct v_plane_source *s = &p->sources[to + i];
        load_source(&p->view, p->patch, from + i, s);
        s->cell = (int32_t)(p->jitter[0][i] * V_PLANE_CELLS); /* jitter is below 1 */
    }
}

int v_plane_neighbourhood_create(const struct plan *plan, const struct patch *patch,
                                 struct rect inner, const struct v_plane_kernels *kernels,
                                 struct v_plane_neighbourhood *out)
{
    const uint32_t l = plan->indirect_strata_per_axis;
    *out = (struct v_plane_neighbourhood){
        .plan = plan, .patch = patch, .kernels = kernels, .inner = inner};
    out->rect = rect_grow(inner, V_PLANE_HALO_PX);
    out->field = (struct v_plane_field){
        .width = rect_width(out->rect),
        .height = rect_height(out->rect),
        .strata = l,
        .lanes = v_plane_lanes(l),
    };
    const int error = carve(out);
    if (error) return error;
    out->field.sources = out->sources;
    for (int axis = 0; axis < 2; axis++) out->field.walks[axis] = out->walks[axis];
    surface_view_init(&out->view, plan);
    const struct rect seen = rect_intersect(out->rect, patch->rect);
    for (int32_t y = seen.y0; y < seen.y1; y++) load_row(out, seen, y);
    return 0;
}

void v_plane_neighbourhood_fini(struct v_plane_neighbourhood *around)
{
    free(around->memory);
    *around = (struct v_plane_neighbourhood){0};
}
