/* Triangles are found by a grid over the mesh's box: a point of the surface lies in a cell that its
 * triangle's box meets. */
#include "server/reconstruct/motion/motion_mesh.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define CELLS_MAX 96 /* along an axis */
/* Where triangles are so large that they meet more cells than this each, cells are larger. */
#define CELLS_EACH 32u
/* Triangles that are looked at for one point. More of them in a cell are soup. */
#define LOOKED_AT_MAX 4096u
/* Boxes are widened by this share of the mesh's size: depths are floats. */
#define SLACK 1e-5

struct motion_mesh {
    uint32_t *triangles; /* owned, as all below */
    float *now, *sides[MOTION_SIDES];
    uint32_t triangle_count;
    int32_t cells[3];
    double low[3], cell[3]; /* the grid's corner, and the size of a cell; above 0 */
    double slack;
    uint32_t *first; /* by cell: where its triangles begin in `items`; one more at the end */
    uint32_t *items;
};

static void *copy(const void *from, size_t size_bytes)
{
    if (!from) return NULL;
    void *to = malloc(size_bytes + 1);
    if (to) memcpy(to, from, size_bytes);
    return to;
}

static void find_box(struct motion_mesh *m, uint32_t vertex_count)
{
    double high[3], size = 0;
    for (int c = 0; c < 3; c++) m->low[c] = INFINITY, high[c] = -INFINITY;
    for (size_t v = 0; v < vertex_count; v++)
        for (int c = 0; c < 3; c++) {
            m->low[c] = fmin(m->low[c], (double)m->now[3 * v + (size_t)c]);
            high[c] = fmax(high[c], (double)m->now[3 * v + (size_t)c]);
        }
    for (int c = 0; c < 3; c++) size = fmax(size, high[c] - m->low[c]);
    if (!(size > 0)) size = 1;
    m->slack = SLACK * size;
    /* About one cell a triangle of the surface along the longest axis. */
    const double along = fmin(CELLS_MAX, ceil(sqrt((double)m->triangle_count)));
    for (int c = 0; c < 3; c++) {
        m->cells[c] = (int32_t)fmax(1, ceil(along * (high[c] - m->low[c]) / size));
        m->cell[c] = fmax((high[c] - m->low[c]) / m->cells[c], m->slack);
    }
}

static int32_t cell_of(const struct motion_mesh *m, int axis, double x)
{
    const double at = floor((x - m->low[axis]) / m->cell[axis]);
    return (int32_t)fmin(fmax(at, 0), m->cells[axis] - 1);
}

/* The cells that a triangle's box meets: from low to high, both inside. */
static void cells_of(const struct motion_mesh *m, uint32_t t, int32_t low[3], int32_t high[3])
{
    for (int c = 0; c < 3; c++) {
        double from = INFINITY, to = -INFINITY;
        for (size_t k = 0; k < 3; k++) {
            const double x =
                (double)m->now[3 * (size_t)m->triangles[3 * (size_t)t + k] + (size_t)c];
            from = fmin(from, x);
            to = fmax(to, x);
        }
        low[c] = cell_of(m, c, from - m->slack);
        high[c] = cell_of(m, c, to + m->slack);
    }
}

static size_t index_of(const struct motion_mesh *m, int32_t x, int32_t y, int32_t z)
{
    return ((size_t)z * (size_t)m->cells[1] + (size_t)y) * (size_t)m->cells[0] + (size_t)x;
}

/* Returns how many cells a triangle meets. */
static uint64_t count_cells(const struct motion_mesh *m, uint32_t t)
{
    int32_t low[3], high[3];
    uint64_t count = 1;
    cells_of(m, t, low, high);
    for (int c = 0; c < 3; c++) count *= (uint64_t)(high[c] - low[c] + 1);
    return count;
}

/* Halves the grid's cells until triangles meet few. One cell is enough in any case. */
static void coarsen(struct motion_mesh *m)
{
    const uint64_t each = (uint64_t)CELLS_EACH * m->triangle_count;
    const uint64_t most =
        each < INT32_MAX ? each : INT32_MAX; /* more than triangles that there are */
    for (;;) {
        uint64_t sum = 0;
        for (uint32_t t = 0; t < m->triangle_count && sum <= most; t++) sum += count_cells(m, t);
        if (sum <= most) return;
        for (int c = 0; c < 3; c++) {
            const int32_t half = (m->cells[c] + 1) / 2;
            m->cell[c] *= (double)m->cells[c] / half;
            m->cells[c] = half;
        }
    }
}

/* Counts a triangle in its cells, or notes it there. */
static void enter(struct motion_mesh *m, uint32_t t, uint32_t *next)
{
    int32_t low[3], high[3];
    cells_of(m, t, low, high);
    for (int32_t z = low[2]; z <= high[2]; z++)
        for (int32_t y = low[1]; y <= high[1]; y++)
            for (int32_t x = low[0]; x <= high[0]; x++) {
                const size_t i = index_of(m, x, y, z);
                if (next)
                    m->items[next[i]++] = t;
                else
                    m->first[i + 1]++;
            }
}

static int fill_grid(struct motion_mesh *m)
{
    const size_t cells = (size_t)m->cells[0] * (size_t)m->cells[1] * (size_t)m->cells[2];
    m->first = calloc(cells + 1, sizeof *m->first);
    if (!m->first) return ERR_MEMORY;
    for (uint32_t t = 0; t < m->triangle_count; t++) enter(m, t, NULL);
    for (size_t i = 0; i < cells; i++) m->first[i + 1] += m->first[i];
    m->items = malloc(((size_t)m->first[cells] + 1) * sizeof *m->items);
    uint32_t *next = copy(m->first, cells * sizeof *next);
    for (uint32_t t = 0; m->items && next && t < m->triangle_count; t++) enter(m, t, next);
    const bool made = m->items && next;
    free(next);
    return made ? 0 : ERR_MEMORY;
}

int motion_mesh_create(const uint32_t *triangles, uint32_t triangle_count, uint32_t vertex_count,
                       const float *now, const float *const sides[MOTION_SIDES],
                       struct motion_mesh **out)
{
    const size_t bytes = (size_t)vertex_count * 3 * sizeof(float);
    struct motion_mesh *m = calloc(1, sizeof *m);
    if (!m) return ERR_MEMORY;
    m->triangle_count = triangle_count;
    m->triangles = copy(triangles, (size_t)triangle_count * 3 * sizeof *triangles);
    m->now = copy(now, bytes);
    int error = m->triangles && m->now ? 0 : ERR_MEMORY;
    for (int side = 0; side < MOTION_SIDES; side++) {
        m->sides[side] = copy(sides[side], bytes);
        if (sides[side] && !m->sides[side]) error = ERR_MEMORY;
    }
    if (!error) find_box(m, vertex_count);
    if (!error) coarsen(m);
    if (!error) error = fill_grid(m);
    if (error) motion_mesh_destroy(&m);
    *out = m;
    return error;
}

void motion_mesh_destroy(struct motion_mesh **mesh)
{
    struct motion_mesh *m = *mesh;
    *mesh = NULL;
    if (!m) return;
    free(m->triangles);
    free(m->now);
    for (int side = 0; side < MOTION_SIDES; side++) free(m->sides[side]);
    free(m->first);
    free(m->items);
    free(m);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Sets the weights of a segment's point nearest to p, which lies along `edge` from a corner. */
static void along_edge(const double edge[3], const double p[3], int from, int to, double w[3])
{
    const double length2 = dot(edge, edge);
    const double u = length2 > 0 ? fmin(fmax(dot(edge, p) / length2, 0), 1) : 0;
    w[0] = w[1] = w[2] = 0;
    w[from] = 1 - u;
    w[to] = u;
}

/* Returns the squared distance of a point, relative to corner 0, from that of the weights. */
static double distance2(const double u[3], const double v[3], const double p[3], const double w[3])
{
    double d[3];
    for (int c = 0; c < 3; c++) d[c] = p[c] - w[1] * u[c] - w[2] * v[c];
    return dot(d, d);
}

/* Finds the weights of a triangle's point nearest to p: within, or on the nearest of its edges.
 * Returns the squared distance. */
static double nearest(const double corner[3][3], const double at[3], double w[3])
{
    double u[3], v[3], p[3], across[3], q[3];
    for (int c = 0; c < 3; c++) {
        u[c] = corner[1][c] - corner[0][c];
        v[c] = corner[2][c] - corner[0][c];
        p[c] = at[c] - corner[0][c];
        across[c] = corner[2][c] - corner[1][c];
        q[c] = at[c] - corner[1][c];
    }
    const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), up = dot(u, p), vp = dot(v, p);
    const double area2 = uu * vv - uv * uv;
    w[1] = area2 > 0 ? (vv * up - uv * vp) / area2 : -1;
    w[2] = area2 > 0 ? (uu * vp - uv * up) / area2 : -1;
    w[0] = 1 - w[1] - w[2];
    if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0) return distance2(u, v, p, w);
    double best = INFINITY;
    const double *edges[3] = {u, v, across}, *points[3] = {p, p, q};
    static const int ends[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    for (int e = 0; e < 3; e++) {
        double along[3];
        along_edge(edges[e], points[e], ends[e][0], ends[e][1], along);
        const double d = distance2(u, v, p, along);
        if (!(d < best)) continue;
        best = d;
        memcpy(w, along, sizeof along);
    }
    return best;
}

static void corners_of(const struct motion_mesh *m, uint32_t t, const float *positions,
                       double out[3][3])
{
    for (size_t k = 0; k < 3; k++)
        for (size_t c = 0; c < 3; c++)
            out[k][c] = (double)positions[3 * (size_t)m->triangles[3 * (size_t)t + k] + c];
}

void motion_mesh_follow(const struct motion_mesh *m, enum motion_side side, double at[3])
{
    double best = INFINITY, weights[3] = {1, 0, 0}, corner[3][3];
    uint32_t found = UINT32_MAX;
    if (!m->sides[side]) return;
    const size_t cell =
        index_of(m, cell_of(m, 0, at[0]), cell_of(m, 1, at[1]), cell_of(m, 2, at[2]));
    const uint32_t held = m->first[cell + 1] - m->first[cell];
    const uint32_t looked_at = held < LOOKED_AT_MAX ? held : LOOKED_AT_MAX;
    for (uint32_t i = m->first[cell]; i < m->first[cell] + looked_at; i++) {
        double w[3];
        corners_of(m, m->items[i], m->now, corner);
        const double d = nearest((const double(*)[3])corner, at, w);
        if (!(d < best)) continue;
        best = d;
        found = m->items[i];
        memcpy(weights, w, sizeof w);
    }
    if (found == UINT32_MAX) return;
    corners_of(m, found, m->sides[side], corner);
    for (int c = 0; c < 3; c++)
        at[c] = weights[0] * corner[0][c] + weights[1] * corner[1][c] + weights[2] * corner[2][c];
}
