#include "server/import/rgbd/depth_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/rgbd/depth_links.h"
#include "server/import/rgbd/white.h"

#define EVEN_STEPS 2

struct corner {
    float x, y; /* pixels from the image's corner */
};

struct maker {
    const struct depth_map *map;
    const struct rgbd_document *d;
    struct depth_links links;
    struct corner *corners; /* a corner: (width + 1) * (height + 1) */
    struct corner *before;
    uint32_t *vertices; /* four a pixel: left top, right top, left bottom, right bottom */
    const float *white;
};

static size_t pixel_at(const struct maker *k, int32_t x, int32_t y)
{
    return (size_t)y * (size_t)k->map->width + (size_t)x;
}

static float inverse(const struct maker *k, int32_t x, int32_t y)
{
    return depth_links_inverse(&k->links, x, y);
}

/* Says which of a corner's four sides part two surfaces: up, down, left, right. */
static unsigned jumps_at(const struct maker *k, int32_t x, int32_t y)
{
    return (depth_links_has(&k->links, x - 1, y - 1, DEPTH_LINK_RIGHT) ? 0u : 1u) |
           (depth_links_has(&k->links, x - 1, y, DEPTH_LINK_RIGHT) ? 0u : 2u) |
           (depth_links_has(&k->links, x - 1, y - 1, DEPTH_LINK_DOWN) ? 0u : 4u) |
           (depth_links_has(&k->links, x, y - 1, DEPTH_LINK_DOWN) ? 0u : 8u);
}

/* Moves the corners of a jump to where they make the straightest line. */
static void even_out(struct maker *k)
{
    const int32_t across = k->map->width + 1;
    static const int32_t to[4][2] = {{0, -1}, {0, 1}, {-1, 0}, {1, 0}};
    memcpy(k->before, k->corners,
           (size_t)across * ((size_t)k->map->height + 1) * sizeof *k->corners);
    for (int32_t y = 1; y < k->map->height; y++)
        for (int32_t x = 1; x < k->map->width; x++) {
            const unsigned jumps = jumps_at(k, x, y);
            struct corner *at = &k->corners[(size_t)y * (size_t)across + (size_t)x];
            if (__builtin_popcount(jumps) != 2) continue;
            float sum[2] = {2 * at->x, 2 * at->y};
            for (int side = 0; side < 4; side++) {
                if (!(jumps >> side & 1)) continue;
                const struct corner *n = &k->before[(size_t)(y + to[side][1]) * (size_t)across +
                                                    (size_t)(x + to[side][0])];
                sum[0] += n->x;
                sum[1] += n->y;
            }
            at->x = sum[0] / 4;
            at->y = sum[1] / 4;
        }
}

/* Computes 1/z of a pixel's surface at a corner. */
static float reach(const struct maker *k, int32_t x, int32_t y, const struct corner *at)
{
    const float own = inverse(k, x, y);
    const float v =
        own + depth_links_slope(&k->links, x, y, DEPTH_LINK_RIGHT, 1) * (at->x - (float)x - 0.5f) +
        depth_links_slope(&k->links, x, y, DEPTH_LINK_DOWN, 1) * (at->y - (float)y - 0.5f);
    return fminf(fmaxf(v, 0.5f * own), 2 * own);
}

/* Adds a vertex for those of a corner's pixels that are in `group`. */
static void add_vertex(struct maker *k, int32_t x, int32_t y, unsigned group, struct mesh *m)
{
    const struct corner *at = &k->corners[(size_t)y * (size_t)(k->map->width + 1) + (size_t)x];
    float sum = 0, rgb[3] = {0}, count = 0;
    for (int i = 0; i < 4; i++) {
        const int32_t px = x - 1 + i % 2, py = y - 1 + i / 2;
        if (!(group >> i & 1)) continue;
        sum += reach(k, px, py, at);
        for (size_t c = 0; c < 3; c++) rgb[c] += k->map->color[3 * pixel_at(k, px, py) + c];
        k->vertices[4 * pixel_at(k, px, py) + (size_t)(3 - i)] = m->vertex_count;
        count++;
    }
    const float z = count / sum;
    float *p = m->positions + 3 * (size_t)m->vertex_count;
    float *color = m->colors + 4 * (size_t)m->vertex_count++;
    p[0] = (float)(((double)at->x - 0.5 - k->d->cx) / k->d->fx) * z;
    p[1] = (float)(((double)at->y - 0.5 - k->d->cy) / k->d->fy) * z;
    p[2] = z;
    for (size_t c = 0; c < 3; c++) color[c] = white_albedo(rgb[c] / count, k->white[c]);
    color[3] = 1;
}

/* The pixels around a corner, left top first, in groups that links connect. */
static void add_corner(struct maker *k, int32_t x, int32_t y, struct mesh *m)
{
    const unsigned jumps = jumps_at(k, x, y);
    unsigned group[4];
    for (int i = 0; i < 4; i++)
        group[i] = inverse(k, x - 1 + i % 2, y - 1 + i / 2) > 0 ? 1u << i : 0;
    static const int pairs[4][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}};
    for (int side = 0; side < 4; side++) {
        const unsigned both = group[pairs[side][0]] | group[pairs[side][1]];
        if (jumps >> side & 1) continue;
        for (int i = 0; i < 4; i++)
            if (both >> i & 1) group[i] = both;
    }
    for (int i = 0; i < 4; i++)
        if (group[i] && !(group[i] & ((1u << i) - 1))) add_vertex(k, x, y, group[i], m);
}

/* Two triangles of a pixel, whose fronts face the camera. */
static void add_square(const struct maker *k, size_t pixel, struct mesh *m)
{
    const uint32_t *v = k->vertices + 4 * pixel;
    const uint32_t both[6] = {v[0], v[2], v[1], v[1], v[2], v[3]};
    memcpy(m->triangles + 3 * (size_t)m->triangle_count, both, sizeof both);
    m->triangle_count += 2;
}

/* Sets the mean of the triangles around each vertex, larger ones counting more. */
static void set_normals(struct mesh *m)
{
    for (size_t t = 0; t < m->triangle_count; t++) {
        double n[3];
        const uint32_t *v = m->triangles + 3 * t;
        mesh_triangle_normal(m->positions, v, n);
        for (int k = 0; k < 3; k++)
            for (size_t c = 0; c < 3; c++) m->normals[3 * (size_t)v[k] + c] += (float)n[c];
    }
    for (size_t i = 0; i < m->vertex_count; i++) {
        float *at = m->normals + 3 * i;
        double n[3] = {(double)at[0], (double)at[1], (double)at[2]};
        if (!normalize3(n)) n[0] = n[1] = 0, n[2] = -1;
        for (int c = 0; c < 3; c++) at[c] = (float)n[c];
    }
}

static int allocate(struct maker *k, struct mesh *m)
{
    const size_t pixels = (size_t)k->map->width * (size_t)k->map->height;
    const size_t corners = ((size_t)k->map->width + 1) * ((size_t)k->map->height + 1);
    k->corners = calloc(corners, sizeof *k->corners);
    k->before = calloc(corners, sizeof *k->before);
    k->vertices = calloc(4 * pixels, sizeof *k->vertices);
    m->positions = malloc(4 * pixels * 3 * sizeof *m->positions);
    m->normals = calloc(4 * pixels, 3 * sizeof *m->normals);
    m->colors = malloc(4 * pixels * 4 * sizeof *m->colors);
    m->triangles = malloc(2 * pixels * 3 * sizeof *m->triangles);
    return depth_links_find(k->map, &k->links) == 0 && k->corners && k->before && k->vertices &&
                   m->positions && m->normals && m->colors && m->triangles
               ? 0
               : ERR_MEMORY;
}

static void add_squares(const struct maker *k, bool shining, struct mesh *m)
{
    const size_t count = (size_t)k->map->width * (size_t)k->map->height;
    for (size_t i = 0; i < count; i++)
        if (k->map->z[i] > 0 && white_is_outshone(k->white, k->map->color + 3 * i) == shining)
            add_square(k, i, m);
}

static void build(struct maker *k, struct mesh *m, uint32_t *first_shining)
{
    const int32_t width = k->map->width, height = k->map->height;
    for (int32_t y = 0; y <= height; y++)
        for (int32_t x = 0; x <= width; x++)
            k->corners[(size_t)y * (size_t)(width + 1) + (size_t)x] =
                (struct corner){(float)x, (float)y};
    for (int step = 0; step < EVEN_STEPS; step++) even_out(k);
    for (int32_t y = 0; y <= height; y++)
        for (int32_t x = 0; x <= width; x++) add_corner(k, x, y, m);
    add_squares(k, false, m);
    *first_shining = m->triangle_count;
    add_squares(k, true, m);
    set_normals(m);
}

int depth_mesh_make(const struct depth_map *map, const struct rgbd_document *d,
                    const float white[3], struct mesh *out, uint32_t *first_shining,
                    struct fault *fault)
{
    struct maker k = {.map = map, .d = d, .white = white};
    *out = (struct mesh){0};
    int rc = allocate(&k, out);
    if (rc == 0) build(&k, out, first_shining);
    depth_links_fini(&k.links);
    free(k.corners);
    free(k.before);
    free(k.vertices);
    if (rc == 0) return 0;
    mesh_fini(out);
    return fault_set(fault, rc, "/rgbd", "no memory for the mesh of a frame");
}
