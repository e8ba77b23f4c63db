#pragma once
/* The kernels' tables with every kernel between a call before it and one after, so that the cases
 * of tests/kernel run it as they do and what surrounds it is not measured. */
#include "tests/kernel/kernel_glossy.h"
#include "tests/kernel/kernel_indirect.h"
#include "tests/kernel/kernel_lens.h"
#include "tests/kernel/kernel_lens_light.h"
#include "tests/kernel/kernel_v_plane.h"

/* What is done around the kernel that is measured; the others' calls pass. `outputs`: how many
 * pixels, samples or rows the call writes. */
static void around_begin(const void *kernel);
static void around_end(const void *kernel, double outputs);

#define WRAP(table, kernel, outputs, parameters, ...)                                              \
    static void wrapped_##table##_##kernel parameters                                              \
    {                                                                                              \
        around_begin((const void *)&KERNELS_BEST(table##_kernels)->kernel);                        \
        KERNELS_BEST(table##_kernels)->kernel(__VA_ARGS__);                                        \
        around_end((const void *)&KERNELS_BEST(table##_kernels)->kernel, outputs);                 \
    }

WRAP(shadow, unoccluded, n,
     (const struct shadow_rectangle *l, uint32_t n, const float *const p[3],
      const float *const m[3], float *out),
     l, n, p, m, out)
WRAP(shadow, place_receivers, n,
     (const struct receiver_light *l, uint32_t n, const float *d, size_t first,
      const struct shadow_pixels *p),
     l, n, d, first, p)
WRAP(shadow, shear_receivers, n,
     (const struct wedge_shear *w, const uint32_t *pixels, uint32_t n, const float *most,
      const float *least, const struct shadow_pixels *p),
     w, pixels, n, most, least, p)
WRAP(shadow, mark_walks, n,
     (const struct shadow_field *f, uint32_t axis, const uint32_t *pixels, uint32_t n, uint8_t *m),
     f, axis, pixels, n, m)
WRAP(shadow, project_columns, n,
     (const struct shadow_field *f, const uint32_t *pixels, uint32_t n, const float *jitter,
      const uint32_t *seen),
     f, pixels, n, jitter, seen)
WRAP(shadow, walk_columns, n,
     (const struct shadow_field *f, const uint32_t *pixels, uint32_t n, float *out), f, pixels, n,
     out)
WRAP(shadow, project_rows, n,
     (const struct shadow_field *f, const uint32_t *pixels, uint32_t n, const float *cells), f,
     pixels, n, cells)
WRAP(shadow, walk_rows, n,
     (const struct shadow_field *f, const uint32_t *pixels, uint32_t n, float *out), f, pixels, n,
     out)
WRAP(shadow, blur, n,
     (const struct shadow_blur *b, int32_t step, size_t first, uint32_t n, float *out), b, step,
     first, n, out)
WRAP(shadow, estimate, n,
     (const struct shadow_rectangle *r, uint32_t l, uint32_t n, const float *const p[3],
      const float *const m[3], const float *const j[2], const uint32_t *bits, size_t stride,
      float *out),
     r, l, n, p, m, j, bits, stride, out)
WRAP(shadow, filter_edges, n,
     (const struct edge_field *f, const uint32_t *pixels, const float *sigma, uint32_t n,
      float *out),
     f, pixels, sigma, n, out)
WRAP(shadow, sum_slopes, n,
     (const struct shadow_field *f, const uint32_t *pixels, uint32_t n, const float *a,
      const float *b, float *out),
     f, pixels, n, a, b, out)

static const struct shadow_kernels wrapped_shadow = {
    .unoccluded = wrapped_shadow_unoccluded,
    .place_receivers = wrapped_shadow_place_receivers,
    .shear_receivers = wrapped_shadow_shear_receivers,
    .mark_walks = wrapped_shadow_mark_walks,
    .project_columns = wrapped_shadow_project_columns,
    .walk_columns = wrapped_shadow_walk_columns,
    .project_rows = wrapped_shadow_project_rows,
    .walk_rows = wrapped_shadow_walk_rows,
    .blur = wrapped_shadow_blur,
    .estimate = wrapped_shadow_estimate,
    .filter_edges = wrapped_shadow_filter_edges,
    .sum_slopes = wrapped_shadow_sum_slopes,
};

WRAP(indirect, mean, r->count,
     (const struct indirect_field *f, const struct indirect_run *r, uint32_t n,
      const float *const *in, float *const *out),
     f, r, n, in, out)
WRAP(indirect, line, r->count,
     (const struct indirect_field *f, const struct indirect_run *r, uint32_t n,
      const float *const *in, float *const *out),
     f, r, n, in, out)
WRAP(indirect, nearness, r->count,
     (const struct indirect_field *f, const struct indirect_run *r, const float *in, float *out), f,
     r, in, out)

static const struct indirect_kernels wrapped_indirect = {
    .mean = wrapped_indirect_mean,
    .line = wrapped_indirect_line,
    .nearness = wrapped_indirect_nearness,
};

WRAP(glossy, spread, r->count,
     (const struct glossy_field *f, const struct glossy_rule *rule, const struct glossy_run *r,
      uint32_t n, const float *const *in, float *const *out),
     f, rule, r, n, in, out)

static const struct glossy_kernels wrapped_glossy = {.spread = wrapped_glossy_spread};

WRAP(lens, gather, n,
     (const struct lens_gather *g, size_t first, uint32_t n, float *out, size_t stride), g, first,
     n, out, stride)
WRAP(lens, add, n, (const struct lens_place *p, uint32_t n, float *sums), p, n, sums)

static const struct lens_kernels wrapped_lens = {
    .gather = wrapped_lens_gather,
    .add = wrapped_lens_add,
};

WRAP(lens_light, place, end - begin,
     (const struct lens_light_row *row, uint32_t begin, uint32_t end), row, begin, end)
WRAP(lens_light, own, n, (const uint32_t *packed, float scale, uint32_t n, float *const light[3]),
     packed, scale, n, light)
WRAP(lens_light, add, n,
     (const uint32_t *albedo, const float *light, const float *shine, uint32_t c, uint32_t n,
      float *out),
     albedo, light, shine, c, n, out)

static float wrapped_lens_light_most(const float *slope, uint32_t n, float most)
{
    const struct lens_light_kernels *best = KERNELS_BEST(lens_light_kernels);
    around_begin((const void *)&best->most);
    const float found = best->most(slope, n, most);
    around_end((const void *)&best->most, n);
    return found;
}

static const struct lens_light_kernels wrapped_lens_light = {
    .place = wrapped_lens_light_place,
    .own = wrapped_lens_light_own,
    .add = wrapped_lens_light_add,
    .most = wrapped_lens_light_most,
};

WRAP(v_plane, strata, s->count, (const struct v_plane_strata *s, const float *u, const float *v), s,
     u, v)
WRAP(v_plane, slopes, s->count,
     (const struct v_plane_strata *s, const struct v_plane_planes *p,
      const struct v_plane_source *sources, float least, float *mean, float *deviation),
     s, p, sources, least, mean, deviation)
WRAP(v_plane, average, n,
     (const struct v_plane_slopes_field *in, size_t first, uint32_t n, float *mean,
      float *deviation),
     in, first, n, mean, deviation)
WRAP(v_plane, records, s->count,
     (const struct v_plane_strata *s, const struct v_plane_planes *p, uint32_t lanes,
      const uint8_t *needs, uint8_t mask, float scale, float *out),
     s, p, lanes, needs, mask, scale, out)
WRAP(v_plane, columns, n,
     (const struct v_plane_field *f, int32_t y, const int32_t *x, uint32_t n,
      const float *const *rows, float *out),
     f, y, x, n, rows, out)
WRAP(v_plane, rows, n,
     (const struct v_plane_field *f, int32_t y, const int32_t *x, uint32_t n,
      const float *const *rows, float *out),
     f, y, x, n, rows, out)

static const struct v_plane_kernels wrapped_v_plane = {
    .strata = wrapped_v_plane_strata,
    .slopes = wrapped_v_plane_slopes,
    .average = wrapped_v_plane_average,
    .records = wrapped_v_plane_records,
    .columns = wrapped_v_plane_columns,
    .rows = wrapped_v_plane_rows,
};
