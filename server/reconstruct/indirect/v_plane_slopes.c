#include "server/reconstruct/indirect/v_plane_slopes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/v_plane.h"
#include "server/reconstruct/indirect/indirect_width.h"

#define LINES         512.0f /* what pixels below are counted at */
#define SAMPLES       16.0f
#define HEIGHT_MIN_PX 8.0f
#define BANDWIDTH     3.0f
#define SIGMA_V       (2.0f / 2.8f)
#define SIGMA_MAX_PX  8.0f /* half a walk */
#define DEVIATION_MIN 1e-6f
#define FALLOFF_MAX   1e30f

/* Arrays of the field, in pixels' own sizes. */
struct slopes {
    float *mean, *deviation; /* of a pixel's own samples; mean -1: they say nothing */
    float *normal[3];
    int32_t *object;
    float *eta, *spread; /* of the pixels around, too */
};

static float sigma_per_deviation(const struct plan *plan)
{
    const float l = (float)plan->indirect_strata_per_axis;
    return plan->mu * SIGMA_V / (2.0f * BANDWIDTH * indirect_root(l * l / SAMPLES, 3));
}

static int slopes_create(const struct v_plane_neighbourhood *around, struct slopes *out)
{
    const size_t area = (size_t)rect_area(around->rect);
    float *memory = calloc(8 * area, sizeof *memory);
    if (!memory) return ERR_MEMORY;
    out->mean = memory;
    out->deviation = memory + area;
    out->eta = memory + 2 * area;
    out->spread = memory + 3 * area;
    for (size_t k = 0; k < 3; k++) out->normal[k] = memory + (4 + k) * area;
    out->object = (int32_t *)(void *)(memory + 7 * area);
    for (size_t i = 0; i < area; i++) out->mean[i] = -1.0f;
    return 0;
}

/* Measures heights from each pixel's own samples. */
static void measure(struct v_plane_neighbourhood *around, const struct slopes *s)
{
    const int32_t reach_px = V_PLANE_REACH_PX + V_PLANE_SLOPES_PX;
    const struct patch *patch = around->patch;
    const struct rect seen = rect_intersect(rect_grow(around->inner, reach_px), patch->rect);
    const float least_px = HEIGHT_MIN_PX * (float)around->plan->height_px / LINES;
    for (int32_t y = seen.y0; y < seen.y1; y++) {
        const size_t to = v_plane_index(around, seen.x0, y);
        const size_t from = patch_pixel(patch, seen.x0, y);
        const uint32_t count = (uint32_t)rect_width(seen);
        struct v_plane_planes planes;
        v_plane_neighbourhood_row(around, seen.x0, y, count, &planes);
        around->kernels->slopes(&around->strata, &planes, around->sources + to, least_px,
                                s->mean + to, s->deviation + to);
        memcpy(s->object + to, patch->id + from, count * sizeof *s->object);
        for (int k = 0; k < 3; k++)
            memcpy(s->normal[k] + to, patch->normal[k] + from, count * sizeof(float));
    }
}

/* Pixels that a point moves on the screen for each scene unit along t. */
static void screen_step(const struct surface_view *view, const float point[3], const float t[3],
                        float step[2])
{
    const float per_pixel[2] = {view->a_step, view->b_step};
    const float inverse = -1.0f / point[2]; /* a surface is in front of the eye */
    for (int k = 0; k < 2; k++) {
        const float moved =
            view->orthographic ? t[k] : (t[k] + point[k] * inverse * t[2]) * inverse;
        step[k] = moved / per_pixel[k];
    }
}

static void set_walk(const struct surface_view *view, const struct v_plane_source *source,
                     float eta, float sigma, struct v_plane_walk *w)
{
    float step[2];
    screen_step(view, source->point, w->tangent, step);
    w->along_x = fabsf(step[0]) >= fabsf(step[1]);
    const float major = step[w->along_x ? 0 : 1], minor = step[w->along_x ? 1 : 0];
    const float px = fabsf(major) * sigma; /* on the screen */
    w->eta = eta;
    if (!(px > 0.0f) || !(fabsf(major) < INFINITY)) return;
    const float width = px < SIGMA_MAX_PX ? px : SIGMA_MAX_PX, inverse = fabsf(major) / width;
    const float falloff = 0.5f * inverse * inverse;
    w->falloff = falloff < FALLOFF_MAX ? falloff : FALLOFF_MAX;
    w->slant = minor / major;
    w->reach = (int32_t)ceilf(2.0f * width);
}

/* `scale` over the deviation is sigma. */
static void set_walks(struct v_plane_neighbourhood *around, const struct slopes *s, float scale,
                      size_t i)
{
    const struct v_plane_source *source = &around->sources[i];
    struct v_plane_walk *first = &around->walks[0][i], *second = &around->walks[1][i];
    if (!v_plane_is_source(source)) return;
    const float eta = s->eta[i] / source->pixel;
    const float spread = s->spread[i] > DEVIATION_MIN ? s->spread[i] : DEVIATION_MIN;
    const float sigma_px = scale / spread;
    const float *n = source->normal;
    v_plane_tangents(n[0], n[1], n[2], first->tangent, second->tangent);
    set_walk(&around->view, source, eta, sigma_px * source->pixel, first);
    set_walk(&around->view, source, eta, sigma_px * source->pixel, second);
}

int v_plane_slopes(struct v_plane_neighbourhood *around)
{
    const struct rect rect =
        rect_intersect(rect_grow(around->inner, V_PLANE_REACH_PX), around->patch->rect);
    struct slopes s;
    const int error = slopes_create(around, &s);
    if (error) return error;
    const struct v_plane_slopes_field field = {
        .width = around->field.width,
        .object = s.object,
        .normal = {s.normal[0], s.normal[1], s.normal[2]},
        .mean = s.mean,
        .deviation = s.deviation,
    };
    const float scale = sigma_per_deviation(around->plan);
    measure(around, &s);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t first = v_plane_index(around, rect.x0, y), count = (size_t)rect_width(rect);
        around->kernels->average(&field, first, (uint32_t)count, s.eta, s.spread);
        for (size_t i = first; i < first + count; i++) set_walks(around, &s, scale, i);
    }
    free(s.mean);
    return 0;
}

float v_plane_width_px(const struct v_plane_neighbourhood *around, size_t i)
{
    const struct v_plane_source *source = &around->sources[i];
    float sum = 0.0f;
    for (int axis = 0; axis < 2; axis++) {
        const struct v_plane_walk *w = &around->walks[axis][i];
        float step[2];
        if (w->reach == 0) continue;
        screen_step(&around->view, source->point, w->tangent, step);
        sum += fabsf(step[w->along_x ? 0 : 1]) * sqrtf(0.5f / w->falloff);
    }
    return 0.5f * sum;
}
