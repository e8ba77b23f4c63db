#include "server/reconstruct/indirect/v_plane_filter.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/indirect/v_plane_slopes.h"

#define ALIGN_BYTES 64u
#define FIT_POINTS  64
#define RING        (2 * V_PLANE_REACH_PX + 1) /* rows that a walk looks at */

enum need { NEED_NODES = 1, NEED_RECORD = 2 };

/* The passes over one block, row by row: records of RING rows, node sums of RING rows. */
struct v_plane {
    struct v_plane_neighbourhood around;
    uint8_t *needs; /* of each pixel of the field: bits of enum need */
    float *records, *nodes, *ratios;
    size_t record_row, node_row; /* floats */
    int32_t *x;                  /* columns of a row's pixels */
    float *sums;                 /* four of each of these */
    int32_t records_end;         /* rows of the field that have records lie before */
};

int32_t v_plane_halo_px(const struct plan *plan)
{
    return plan->indirect_filter == INDIRECT_FILTER_SHEARED ? V_PLANE_HALO_PX : 0;
}

static bool can_filter(const struct plan *plan, const struct patch *p, struct rect inner)
{
    const struct rect common = rect_intersect(inner, p->rect);
    const uint32_t l = plan->indirect_strata_per_axis;
    return plan->indirect_filter == INDIRECT_FILTER_SHEARED && l > 0 && l <= V_PLANE_STRATA_MAX &&
           p->depth && p->normal[0] && p->id && p->bounce_distance_min && p->indirect_strata &&
           !rect_is_empty(inner) && rect_area(common) == rect_area(inner);
}

static void clear(const struct patch *patch, struct rect inner, float *const out[3],
                  float *width_px)
{
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        const size_t to = patch_pixel(patch, inner.x0, y);
        const size_t bytes = (size_t)rect_width(inner) * sizeof(float);
        for (int c = 0; c < 3; c++) memset(out[c] + to, 0, bytes);
        if (width_px) memset(width_px + to, 0, bytes);
    }
}

/* One of the points that a polynomial in c is fitted to. */
struct fit_point {
    double c, weight, ratio;
};

static double polynomial(const double fit[V_PLANE_POWERS], double c)
{
    double sum = 0.0;
    for (int k = V_PLANE_POWERS - 1; k >= 0; k--) sum = sum * c + fit[k];
    return sum;
}

/* The least squares fit of 1, c, ... c^(powers - 1), by elimination: the matrix is positive
 * definite. Higher ones are 0. */
static void fit_powers(const struct fit_point *points, int powers, double fit[V_PLANE_POWERS])
{
    double m[V_PLANE_POWERS][V_PLANE_POWERS + 1] = {{0.0}};
    for (int i = 0; i < FIT_POINTS; i++) {
        double row = points[i].weight;
        for (int r = 0; r < powers; r++, row *= points[i].c) {
            double product = row;
            for (int k = 0; k < powers; k++, product *= points[i].c) m[r][k] += product;
            m[r][powers] += row * points[i].ratio;
        }
    }
    for (int p = 0; p < powers; p++)
        for (int r = p + 1; r < powers; r++) {
            const double by = m[r][p] / m[p][p];
            for (int k = p; k <= powers; k++) m[r][k] -= by * m[p][k];
        }
    for (int r = V_PLANE_POWERS - 1; r >= 0; r--) {
        fit[r] = r < powers ? m[r][powers] : 0.0;
        for (int k = r + 1; k < powers; k++) fit[r] -= m[r][k] * fit[k];
        if (r < powers) fit[r] /= m[r][r];
    }
}

/* Shifted by s along x, a sample weighs by 1 / (1 - k c)^2 with k = (2 v1 s - s^2) / (1 + v1^2) of
 * its column and c = (1 + v1^2) / (1 + |v|^2), its cosine^2 within. Its sums over 1, c and c^2
 * being all that is kept of a cell, it has to be a parabola of c: the best one under the column's
 * own distribution, which is even over the unit disc (with c = 1 - u^2, sqrt(1 - u^2) du), unless
 * that gives negative weights. Its mean is right, the marginal's ((1 + v1^2) / (1 + (v1 -
 * s)^2))^(3/2). */
static void fit_ratio(double k, double fit[V_PLANE_POWERS])
{
    struct fit_point points[FIT_POINTS];
    for (int i = 0; i < FIT_POINTS; i++) {
        const double u = ((double)i + 0.5) / FIT_POINTS, c = 1.0 - u * u;
        const double inverse = 1.0 / (1.0 - k * c); /* k < 0.62 */
        points[i] = (struct fit_point){c, sqrt(c), inverse * inverse};
    }
    for (int powers = V_PLANE_POWERS; powers > 0; powers--) {
        bool negative = false;
        fit_powers(points, powers, fit);
        for (int i = 0; i <= FIT_POINTS; i++)
            negative |= polynomial(fit, (double)i / FIT_POINTS) < 0.0;
        if (!negative) return;
    }
}

/* Fills the parabola of every node and every cell of directions along x, with v1 in the cell's
 * middle. Each number stands four times. */
static void fill_ratios(uint32_t cells, float *out)
{
    memset(out, 0, (size_t)cells * V_PLANE_POWERS * V_PLANE_NODE_FLOATS * sizeof *out);
    for (uint32_t c = 0; c < cells; c++) {
        const double u = ((double)c + 0.5) / (double)cells, a = 2.0 * u - 1.0;
        const double height = 2.0 * sqrt(u * (1.0 - u)); /* 1 / sqrt(1 + v1^2) = a / v1 */
        float *first = out + (size_t)c * V_PLANE_POWERS * V_PLANE_NODE_FLOATS;
        for (int32_t i = 0; i < V_PLANE_NODES; i++) {
            const double s = 2.0 * (double)i / (V_PLANE_NODES - 1) - 1.0;
            double fit[V_PLANE_POWERS];
            fit_ratio(s * height * (2.0 * a - s * height), fit);
            for (int k = 0; k < 4 * V_PLANE_POWERS; k++)
                first[k / 4 * V_PLANE_NODE_FLOATS + 4 * i + k % 4] = (float)fit[k / 4];
        }
    }
}

static float *floats(size_t count)
{
    const size_t unit = ALIGN_BYTES / sizeof(float);
    return aligned_alloc(ALIGN_BYTES, (count + unit) / unit * unit * sizeof(float));
}

static int v_plane_create(const struct plan *plan, const struct patch *patch, struct rect inner,
                          struct v_plane *out)
{
    *out = (struct v_plane){0};
    int error = v_plane_neighbourhood_create(plan, patch, inner, KERNELS_BEST(v_plane_kernels),
                                             &out->around);
    if (!error) error = v_plane_slopes(&out->around);
    if (error) return error;
    struct v_plane_field *field = &out->around.field;
    const size_t width = (size_t)field->width, cells = V_PLANE_CELLS * (size_t)field->strata;
    out->record_row = v_plane_record_floats(field) * width;
    out->node_row = V_PLANE_NODE_FLOATS * width;
    out->needs = calloc(width * (size_t)field->height, 1);
    out->records = floats(out->record_row * RING);
    out->nodes = floats(out->node_row * RING);
    out->ratios = floats(cells * V_PLANE_POWERS * V_PLANE_NODE_FLOATS);
    out->x = malloc(width * sizeof *out->x);
    out->sums = malloc(4 * width * sizeof *out->sums);
    if (!out->needs || !out->records || !out->nodes || !out->ratios || !out->x || !out->sums)
        return ERR_MEMORY;
    memset(out->records, 0, out->record_row * RING * sizeof *out->records); /* spare lanes */
    fill_ratios((uint32_t)cells, out->ratios);
    field->ratios = out->ratios;
    return 0;
}

static void v_plane_fini(struct v_plane *v)
{
    free(v->sums);
    free(v->x);
    free(v->ratios);
    free(v->nodes);
    free(v->records);
    free(v->needs);
    v_plane_neighbourhood_fini(&v->around);
}

/* Marks what the walk of field pixel i can reach. */
static void mark_walk(struct v_plane *v, int axis, size_t i, enum need need)
{
    const struct v_plane_walk *w = &v->around.walks[axis][i];
    const ptrdiff_t width = v->around.field.width;
    const ptrdiff_t major = w->along_x ? 1 : width, minor = w->along_x ? width : 1;
    uint8_t *at = v->needs + i;
    for (int32_t k = -w->reach; k <= w->reach; k++) {
        uint8_t *to = at + k * major + (ptrdiff_t)floorf((float)k * w->slant + 0.5f) * minor;
        *to = (uint8_t)(*to | need);
    }
}

/* Finds which pixels take part, and in which pass. */
static void mark(struct v_plane *v)
{
    const struct v_plane_neighbourhood *p = &v->around;
    const struct rect wide = rect_grow(p->inner, V_PLANE_REACH_PX);
    for (int32_t y = p->inner.y0; y < p->inner.y1; y++) {
        const size_t first = v_plane_index(p, p->inner.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(p->inner); i++)
            if (v_plane_is_source(&p->sources[i])) mark_walk(v, 0, i, NEED_NODES);
    }
    for (int32_t y = wide.y0; y < wide.y1; y++) {
        const size_t first = v_plane_index(p, wide.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(wide); i++)
            if (v->needs[i] & NEED_NODES && v_plane_is_source(&p->sources[i]))
                mark_walk(v, 1, i, NEED_RECORD);
    }
}

/* Returns where row y of the field lies in a ring. */
static float *ring_row(float *ring, size_t row_floats, int32_t y)
{
    return ring + (size_t)(y % RING) * row_floats;
}

/* The ring's rows around row y, as the kernels want them. */
static void ring_rows(float *ring, size_t row_floats, int32_t y, const float *rows[RING])
{
    for (int32_t k = 0; k < RING; k++)
        rows[k] = ring_row(ring, row_floats, y - V_PLANE_REACH_PX + k);
}

/* Records of row y of the field, where there is something. */
static void load_records(struct v_plane *v, int32_t y)
{
    struct v_plane_neighbourhood *p = &v->around;
    const struct rect seen = rect_intersect(p->rect, p->patch->rect);
    const int32_t image_y = p->rect.y0 + y;
    struct v_plane_planes planes;
    if (image_y < seen.y0 || image_y >= seen.y1) return;
    const size_t first = (size_t)(seen.x0 - p->rect.x0);
    float *out = ring_row(v->records, v->record_row, y) + first * v_plane_record_floats(&p->field);
    v_plane_neighbourhood_row(p, seen.x0, image_y, (uint32_t)rect_width(seen), &planes);
    p->kernels->records(&p->strata, &planes, p->field.lanes,
                        v->needs + v_plane_index(p, seen.x0, image_y), NEED_RECORD,
                        p->plan->radiance_scale, out);
}

/* The columns of row y within `rect` whose pixels were measured and, if need is not 0, are needed.
 */
static uint32_t list_row(struct v_plane *v, struct rect rect, int32_t y, uint8_t need)
{
    const struct v_plane_neighbourhood *p = &v->around;
    const size_t row = (size_t)y * (size_t)p->field.width;
    uint32_t count = 0;
    for (int32_t x = rect.x0 - p->rect.x0; x < rect.x1 - p->rect.x0; x++) {
        const size_t i = row + (size_t)x;
        if (!v_plane_is_source(&p->sources[i]) || (need && !(v->needs[i] & need))) continue;
        v->x[count++] = x;
    }
    return count;
}

/* Passes 1a, 1b, 2a of row y of the field. */
static void run_columns(struct v_plane *v, int32_t y)
{
    const struct v_plane_neighbourhood *p = &v->around;
    const struct rect wide = rect_grow(p->inner, V_PLANE_REACH_PX);
    const float *rows[RING];
    const uint32_t count = list_row(v, wide, y, NEED_NODES);
    for (; v->records_end <= y + V_PLANE_REACH_PX; v->records_end++)
        load_records(v, v->records_end);
    ring_rows(v->records, v->record_row, y, rows);
    p->kernels->columns(&p->field, y, v->x, count, rows, ring_row(v->nodes, v->node_row, y));
}

/* Pass 2b of row y of the field, and the division. */
static void run_rows(struct v_plane *v, int32_t y, float *const out[3], float *width_px)
{
    const struct v_plane_neighbourhood *p = &v->around;
    const float inverse_scale = 1.0f / p->plan->radiance_scale; /* a power of two */
    const size_t to = patch_pixel(p->patch, p->rect.x0, p->rect.y0 + y);
    const float *rows[RING];
    const uint32_t count = list_row(v, p->inner, y, 0);
    ring_rows(v->nodes, v->node_row, y, rows);
    p->kernels->rows(&p->field, y, v->x, count, rows, v->sums);
    for (uint32_t k = 0; k < count; k++) {
        const size_t i = to + (size_t)v->x[k];
        const float *sum = v->sums + 4 * (size_t)k, weight = sum[3];
        for (int c = 0; c < 3; c++)
            out[c][i] = weight > 0.0f ? sum[c] / weight * inverse_scale : 0.0f;
        if (width_px)
            width_px[i] = v_plane_width_px(p, (size_t)y * (size_t)p->field.width + (size_t)v->x[k]);
    }
}

/* Each row's first half runs V_PLANE_REACH_PX rows ahead of its second. */
static void run(struct v_plane *v, float *const out[3], float *width_px)
{
    const struct v_plane_neighbourhood *p = &v->around;
    const int32_t first = p->inner.y0 - p->rect.y0, end = p->inner.y1 - p->rect.y0;
    mark(v);
    v->records_end = first - 2 * V_PLANE_REACH_PX;
    for (int32_t y = first - V_PLANE_REACH_PX; y < end + V_PLANE_REACH_PX; y++) {
        run_columns(v, y);
        if (y - V_PLANE_REACH_PX >= first) run_rows(v, y - V_PLANE_REACH_PX, out, width_px);
    }
}

int v_plane_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                   float *const out[3], float *width_px, struct indirect_statistics *statistics)
{
    struct v_plane v;
    if (!can_filter(plan, patch, inner)) return ERR_RANGE;
    const uint64_t measured = patch_count_measured(patch, inner);
    int error = 0;
    clear(patch, inner, out, width_px);
    if (measured > 0) {
        error = v_plane_create(plan, patch, inner, &v);
        if (!error) run(&v, out, width_px);
        v_plane_fini(&v);
    }
    if (error) return error;
    statistics->pixels_filtered += measured;
    statistics->pixels_skipped += (uint64_t)rect_area(inner) - measured;
    statistics->blocks_skipped += measured == 0 ? 1 : 0;
    return 0;
}
