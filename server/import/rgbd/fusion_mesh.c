#include "server/import/rgbd/fusion_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distances of neighbours differ by one voxel at most, and by noise. */
#define JUMP_VOXELS 3.0f

/* What is that much of a lamp is its edge. It is too bright to take a factor that is noise. */
#define SHINING_SHARE 0.05f

#define CORNERS 8 /* of a cell: bits of the number are x, y, z */
#define NONE    UINT32_MAX

struct net {
    const struct fusion *f;
    struct mesh *mesh;
    uint32_t (*vertices)[FUSION_VOXELS]; /* of each block's cells; NONE */
    uint8_t *shining;                    /* of each vertex */
};

/* Where a voxel is: its block, and its place there. */
struct place {
    uint32_t block; /* LIMIT_FUSION_BLOCKS: there is none */
    uint32_t voxel;
};

/* Finds a voxel by its offset from a block's first: at most a block away. */
static struct place find(const struct fusion *f, uint32_t block, const int32_t off[3])
{
    int32_t at[3], in[3];
    bool other = false;
    for (int c = 0; c < 3; c++) {
        const int32_t step = off[c] < 0 ? -1 : off[c] >= FUSION_SIDE ? 1 : 0;
        at[c] = f->blocks[block]->at[c] + step;
        in[c] = off[c] - FUSION_SIDE * step;
        other |= step != 0;
    }
    return (struct place){other ? fusion_find(f, at) : block,
                          (uint32_t)((in[2] * FUSION_SIDE + in[1]) * FUSION_SIDE + in[0])};
}

static const struct fusion_voxel *voxel_at(const struct fusion *f, struct place p)
{
    return p.block < f->count ? &f->blocks[p.block]->voxels[p.voxel] : NULL;
}

static void offset_of(int i, int32_t out[3])
{
    out[0] = i % FUSION_SIDE;
    out[1] = i / FUSION_SIDE % FUSION_SIDE;
    out[2] = i / (FUSION_SIDE * FUSION_SIDE);
}

/* Returns whether a surface passes between two voxels. */
static bool is_crossed(const struct fusion *f, const struct fusion_voxel *a,
                       const struct fusion_voxel *b)
{
    return (a->distance > 0) != (b->distance > 0) &&
           fabsf(a->distance - b->distance) <= JUMP_VOXELS * (float)f->voxel_m;
}

/* Finds the voxels at a cell's corners. Returns false unless all are known. */
static bool find_cell(const struct fusion *f, uint32_t block, const int32_t off[3],
                      const struct fusion_voxel *cell[CORNERS])
{
    for (int i = 0; i < CORNERS; i++) {
        const int32_t at[3] = {off[0] + (i & 1), off[1] + (i >> 1 & 1), off[2] + (i >> 2)};
        cell[i] = voxel_at(f, find(f, block, at));
        if (cell[i] == NULL || !(cell[i]->weight > 0)) return false;
    }
    return true;
}

/* Computes the mean of where the surface meets the cell's edges, in voxels from its first corner.
 * Returns false where it meets none. */
static bool find_middle(const struct fusion *f, const struct fusion_voxel *const cell[CORNERS],
                        float out[3])
{
    float sum[3] = {0}, count = 0;
    for (int i = 0; i < CORNERS; i++)
        for (int axis = 0; axis < 3; axis++) {
            const int j = i | 1 << axis;
            if (j == i || !is_crossed(f, cell[i], cell[j])) continue;
            const float a = cell[i]->distance, t = a / (a - cell[j]->distance);
            for (int c = 0; c < 3; c++) sum[c] += c == axis ? t : (float)(i >> c & 1);
            count++;
        }
    for (int c = 0; c < 3 && count > 0; c++) out[c] = sum[c] / count;
    return count > 0;
}

/* The distances' gradient points away from the surface; colours are means by what is known. */
static void set_vertex(struct net *k, const struct fusion_voxel *const cell[CORNERS])
{
    struct mesh *m = k->mesh;
    double n[3] = {0};
    float rgb[3] = {0}, shining = 0, weights = 0;
    for (int i = 0; i < CORNERS; i++) {
        const float w = cell[i]->weight;
        for (int c = 0; c < 3; c++) {
            n[c] += (double)(i >> c & 1 ? cell[i]->distance : -cell[i]->distance);
            rgb[c] += w * (float)cell[i]->albedo[c];
        }
        shining += w * (float)cell[i]->shining;
        weights += w;
    }
    if (!normalize3(n)) n[0] = n[1] = 0, n[2] = 1;
    float *normal = m->normals + 3 * (size_t)m->vertex_count;
    float *color = m->colors + 4 * (size_t)m->vertex_count;
    for (int c = 0; c < 3; c++) {
        normal[c] = (float)n[c];
        color[c] = rgb[c] / (weights * 65535.0f);
    }
    color[3] = 1;
    k->shining[m->vertex_count] = shining > SHINING_SHARE * 65535.0f * weights;
}

/* Counts the vertices, or makes them where there is room. */
static void find_vertices(struct net *k, bool make)
{
    struct mesh *m = k->mesh;
    m->vertex_count = 0;
    for (uint32_t b = 0; b < k->f->count; b++)
        for (int i = 0; i < FUSION_VOXELS; i++) {
            const struct fusion_voxel *cell[CORNERS];
            int32_t off[3];
            float in[3];
            offset_of(i, off);
            k->vertices[b][i] = NONE;
            if (!find_cell(k->f, b, off, cell) || !find_middle(k->f, cell, in)) continue;
            if (make) {
                float *p = m->positions + 3 * (size_t)m->vertex_count;
                for (int c = 0; c < 3; c++)
                    p[c] = (float)(k->f->voxel_m * (FUSION_SIDE * (double)k->f->blocks[b]->at[c] +
                                                    (double)off[c] + (double)in[c]));
                set_vertex(k, cell);
            }
            k->vertices[b][i] = m->vertex_count++;
        }
}

/* Finds the vertices of the four cells around the edge from a voxel along an axis, turning from the
 * next axis to the one after. */
static bool find_square(const struct net *k, uint32_t block, const int32_t off[3], int axis,
                        uint32_t out[4])
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < 4; i++) {
        int32_t at[3] = {off[0], off[1], off[2]};
        at[u] -= i == 0 || i == 3;
        at[v] -= i < 2;
        const struct place p = find(k->f, block, at);
        out[i] = p.block < k->f->count ? k->vertices[p.block][p.voxel] : NONE;
        if (out[i] == NONE) return false;
    }
    return true;
}

/* Two triangles whose fronts are on the free side. */
static void add_square(struct net *k, const uint32_t v[4], bool free_ahead)
{
    const uint32_t both[6] = {v[0], free_ahead ? v[1] : v[2], free_ahead ? v[2] : v[1],
                              v[0], free_ahead ? v[2] : v[3], free_ahead ? v[3] : v[2]};
    struct mesh *m = k->mesh;
    if (m->triangles) memcpy(m->triangles + 3 * (size_t)m->triangle_count, both, sizeof both);
    m->triangle_count += 2;
}

static bool shines(const struct net *k, const uint32_t v[4])
{
    return k->shining &&
           k->shining[v[0]] + k->shining[v[1]] + k->shining[v[2]] + k->shining[v[3]] > 0;
}

/* Counts the triangles that shine, or do not, or makes them where there is room. */
static void find_triangles(struct net *k, bool shining)
{
    for (uint32_t b = 0; b < k->f->count; b++)
        for (int i = 0; i < FUSION_VOXELS; i++) {
            const struct fusion_voxel *own = &k->f->blocks[b]->voxels[i];
            int32_t off[3];
            offset_of(i, off);
            for (int axis = 0; axis < 3 && own->weight > 0; axis++) {
                int32_t next[3] = {off[0], off[1], off[2]};
                uint32_t v[4];
                next[axis]++;
                const struct fusion_voxel *its = voxel_at(k->f, find(k->f, b, next));
                if (its == NULL || !(its->weight > 0) || !is_crossed(k->f, own, its)) continue;
                if (find_square(k, b, off, axis, v) && shines(k, v) == shining)
                    add_square(k, v, its->distance > 0);
            }
        }
}

static int make(struct net *k, uint32_t *first_shining)
{
    struct mesh *m = k->mesh;
    find_vertices(k, false);
    const size_t count = (size_t)m->vertex_count + 1;
    m->positions = malloc(count * 3 * sizeof *m->positions);
    m->normals = malloc(count * 3 * sizeof *m->normals);
    m->colors = malloc(count * 4 * sizeof *m->colors);
    k->shining = malloc(count);
    if (!m->positions || !m->normals || !m->colors || !k->shining) return ERR_MEMORY;
    find_vertices(k, true);
    find_triangles(k, false);
    *first_shining = m->triangle_count;
    find_triangles(k, true);
    const size_t triangles = m->triangle_count;
    m->triangles = malloc((triangles + 1) * 3 * sizeof *m->triangles);
    if (!m->triangles) return ERR_MEMORY;
    m->triangle_count = 0;
    find_triangles(k, false);
    find_triangles(k, true);
    return 0;
}

int fusion_mesh_make(const struct fusion *f, struct mesh *out, uint32_t *first_shining,
                     struct fault *fault)
{
    struct net k = {.f = f, .mesh = out};
    *out = (struct mesh){0};
    *first_shining = 0;
    k.vertices = malloc((f->count + (size_t)1) * sizeof *k.vertices);
    int rc = k.vertices ? make(&k, first_shining) : ERR_MEMORY;
    free(k.vertices);
    free(k.shining);
    if (rc == 0) return 0;
    mesh_fini(out);
    return fault_set(fault, rc, "/rgbd", "no memory for the mesh of all frames");
}
