#include "worker/scene/openness_grid.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "worker/scene/render_scene.h"

#define SIDE_MAX 32u

/* The number of triangles whose places are taken, with the same share for each instance. */
#define ASKED_MAX 1024u

/* The second box is around a cube that holds this share of the corners and is a quarter as long as
 * the whole, or, if it has such a cube itself, around that one. More than half of the corners may
 * belong to a dome or a terrain. */
#define SHARE 0.4f

/* The number of cells along a box's longest side in which corners are counted. */
#define SIDE 8u

struct counts {
    uint32_t in[SIDE][SIDE][SIDE];
};

struct extent {
    float low[3], high[3];
};

static float longest_of(const struct extent *e)
{
    float longest = 0.0f;
    for (int k = 0; k < 3; k++) longest = fmaxf(longest, e->high[k] - e->low[k]);
    return longest;
}

static uint32_t box_cells(const struct openness_box *b)
{
    return b->size[0] * b->size[1] * b->size[2];
}

/* Divides the box into cells about as long each way, as many as `most` allows. */
static void box_set(struct openness_box *b, const struct extent *e, uint32_t most)
{
    const float longest = longest_of(e);
    for (uint32_t along = SIDE_MAX; along == SIDE_MAX || box_cells(b) > most; along--)
        for (int k = 0; k < 3; k++) {
            const float part = longest > 0.0f ? (e->high[k] - e->low[k]) / longest : 0.0f;
            const float cells = ceilf(part * (float)along);
            b->size[k] = cells > 1.0f ? (uint32_t)cells : 1;
        }
    for (int k = 0; k < 3; k++) {
        const float wide = e->high[k] - e->low[k];
        b->low[k] = e->low[k];
        b->per_cell[k] = wide > 0.0f ? (float)b->size[k] / wide : 0.0f;
        if (!isfinite(b->per_cell[k])) b->per_cell[k] = 0.0f;
    }
}

/* Returns the box around the scene; a point without triangles. */
static struct extent extent_of(const struct render_scene *scene)
{
    struct RTCBounds b;
    rtcGetSceneBounds(scene->top, &b);
    struct extent e = {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
    for (int k = 0; k < 3; k++) {
        if (!isfinite(e.low[k])) e.low[k] = 0.0f;
        if (!(e.high[k] > e.low[k])) e.high[k] = e.low[k];
    }
    return e;
}

/* ---- where most triangles are ---- */

struct places {
    uint32_t count;
    float at[3 * ASKED_MAX][3];
};

static void add_triangle(struct places *p, const struct mesh_view *mesh, uint32_t triangle,
                         const float m[12])
{
    const uint32_t *corner = mesh->triangles + (size_t)3 * triangle;
    for (int i = 0; i < 3; i++, p->count++) {
        const float *c = mesh->positions + (size_t)3 * corner[i];
        for (int k = 0; k < 3; k++) {
            const float *row = m + (ptrdiff_t)4 * k;
            p->at[p->count][k] = row[0] * c[0] + row[1] * c[1] + row[2] * c[2] + row[3];
        }
    }
}

/* Takes places of triangles, the same number of each instance, because one of many small triangles
 * is not the whole scene. */
static void find_places(const struct render_scene *scene, struct places *p)
{
    const uint64_t instances = scene->blob->count[SCENE_INSTANCES];
    const uint64_t used = instances < ASKED_MAX ? instances : ASKED_MAX;
    const uint64_t share = used > 0 ? ASKED_MAX / used : 0;
    p->count = 0;
    for (uint64_t i = 0; i < used; i++) {
        const struct scene_instance *instance = &scene->blob->instances[i * instances / used];
        const struct mesh_view *mesh = &scene->meshes[instance->mesh];
        const uint64_t triangles = mesh->triangle_count;
        const uint64_t count = triangles < share ? triangles : share;
        for (uint64_t t = 0; t < count; t++)
            add_triangle(p, mesh, (uint32_t)(t * triangles / count), instance->to_world);
    }
}

static void cell_of(const struct extent *e, const float place[3], uint32_t cell[3])
{
    const float longest = longest_of(e);
    for (int k = 0; k < 3; k++) {
        const float at = (place[k] - e->low[k]) / longest * (float)SIDE;
        cell[k] = at > 0.0f ? at < (float)SIDE ? (uint32_t)at : SIDE - 1 : 0;
    }
}

static bool is_in(const struct extent *e, const float place[3])
{
    bool in = true;
    for (int k = 0; k < 3; k++) in &= place[k] >= e->low[k] && place[k] <= e->high[k];
    return in;
}

static void count_places(const struct places *p, const struct extent *e, struct counts *counts)
{
    memset(counts, 0, sizeof *counts);
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t cell[3];
        if (!is_in(e, p->at[i])) continue;
        cell_of(e, p->at[i], cell);
        counts->in[cell[2]][cell[1]][cell[0]]++;
    }
}

static uint32_t count_cube(const struct counts *counts, uint32_t x, uint32_t y, uint32_t z)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < 8; i++) sum += counts->in[z + i / 4][y + i / 2 % 2][x + i % 2];
    return sum;
}

/* Finds the cube of 2 x 2 x 2 cells that holds most places. Returns how many. */
static uint32_t fullest(const struct counts *counts, uint32_t cube[3])
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < (SIDE - 1) * (SIDE - 1) * (SIDE - 1); i++) {
        const uint32_t x = i % (SIDE - 1), y = i / (SIDE - 1) % (SIDE - 1);
        const uint32_t z = i / ((SIDE - 1) * (SIDE - 1));
        const uint32_t sum = count_cube(counts, x, y, z);
        if (sum <= most) continue;
        most = sum;
        cube[0] = x, cube[1] = y, cube[2] = z;
    }
    return most;
}

/* Returns the bounds of the places in a cube of cells of `e`. */
static struct extent bounds_in(const struct places *p, const struct extent *e,
                               const uint32_t cube[3])
{
    struct extent inner = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t cell[3];
        if (!is_in(e, p->at[i])) continue;
        cell_of(e, p->at[i], cell);
        if (cell[0] - cube[0] > 1 || cell[1] - cube[1] > 1 || cell[2] - cube[2] > 1) continue;
        for (int k = 0; k < 3; k++) {
            inner.low[k] = fminf(inner.low[k], p->at[i][k]);
            inner.high[k] = fmaxf(inner.high[k], p->at[i][k]);
        }
    }
    return inner;
}

/* Shrinks `e` to the extent of what is close together in it. Returns false if nothing is. */
static bool go_inside(const struct places *p, struct extent *e)
{
    struct counts counts;
    uint32_t cube[3] = {0};
    if (!(longest_of(e) > 0.0f) || !isfinite(longest_of(e))) return false;
    count_places(p, e, &counts);
    if ((float)fullest(&counts, cube) < fmaxf(SHARE * (float)p->count, 1.0f)) return false;
    const struct extent inner = bounds_in(p, e, cube);
    if (!(longest_of(&inner) > 0.0f)) return false;
    *e = inner;
    return true;
}

void openness_grid_init(struct openness_grid *g, const struct render_scene *scene)
{
    struct places p;
    const struct extent whole = extent_of(scene);
    find_places(scene, &p);
    struct extent dense = whole;
    bool both = false;
    while (go_inside(&p, &dense)) both = true;
    g->whole.first = 0;
    box_set(&g->whole, &whole, both ? OPENNESS_CELLS_MAX / 2 : OPENNESS_CELLS_MAX);
    g->dense = g->whole;
    g->cells = box_cells(&g->whole);
    if (!both) return;
    g->dense.first = g->cells;
    box_set(&g->dense, &dense, OPENNESS_CELLS_MAX / 2);
    g->cells += box_cells(&g->dense);
}
