#include "server/import/rgbd/fusion.h"

#include <math.h>
#include <stdlib.h>

#include "server/import/rgbd/depth_links.h"
#include "server/import/rgbd/white.h"

/* Half the band: so many voxels, or so many standard deviations of a measurement, up to more
 * voxels. */
#define BAND_VOXELS 4.0f
#define BAND_NOISE  3.0f
#define BAND_MOST   32.0f

/* How many pixels on each side tell of a surface's slope. */
#define SLOPE_PX 3

/* How far beside the image surfaces go on. */
#define BESIDE_VOXELS 2.0

/* Blocks lie within so many of the first camera, by each axis. */
#define FAR_BLOCKS 1e6

#define TABLE_SIZE (4u * LIMIT_FUSION_BLOCKS)
_Static_assert((TABLE_SIZE & (TABLE_SIZE - 1)) == 0, "a power of two");

int fusion_create(double voxel_m, const double origin[3], struct fusion *out)
{
    *out = (struct fusion){.voxel_m = voxel_m, .origin = {origin[0], origin[1], origin[2]}};
    out->blocks = calloc(LIMIT_FUSION_BLOCKS, sizeof(struct fusion_block *));
    out->table = calloc(TABLE_SIZE, sizeof *out->table);
    if (out->blocks && out->table) return 0;
    fusion_destroy(out);
    return ERR_MEMORY;
}

void fusion_destroy(struct fusion *f)
{
    for (uint32_t i = 0; i < f->count; i++) free(f->blocks[i]);
    free(f->blocks);
    free(f->table);
    *f = (struct fusion){0};
}

/* Returns where a block is in the table, or would be. */
static uint32_t slot_of(const struct fusion *f, const int32_t at[3])
{
    uint32_t hash =
        (uint32_t)at[0] * 73856093u ^ (uint32_t)at[1] * 19349663u ^ (uint32_t)at[2] * 83492791u;
    for (;; hash++) {
        const uint32_t slot = hash & (TABLE_SIZE - 1), one = f->table[slot];
        const int32_t *its = one > 0 ? f->blocks[one - 1]->at : at;
        if (its[0] == at[0] && its[1] == at[1] && its[2] == at[2]) return slot;
    }
}

uint32_t fusion_find(const struct fusion *f, const int32_t at[3])
{
    const uint32_t one = f->table[slot_of(f, at)];
    return one > 0 ? one - 1 : LIMIT_FUSION_BLOCKS;
}

static int make_block(struct fusion *f, const int32_t at[3])
{
    uint32_t *slot = &f->table[slot_of(f, at)];
    if (*slot > 0) return 0;
    if (f->count == LIMIT_FUSION_BLOCKS) return ERR_LIMIT;
    struct fusion_block *block = calloc(1, sizeof *block);
    if (block == NULL) return ERR_MEMORY;
    for (int c = 0; c < 3; c++) block->at[c] = at[c];
    f->blocks[f->count++] = block;
    *slot = f->count;
    return 0;
}

static float band_m(const struct fusion *f, float z)
{
    const float voxel = (float)f->voxel_m;
    return fminf(fmaxf(BAND_VOXELS * voxel, BAND_NOISE * depth_noise_m(z)), BAND_MOST * voxel);
}

/* What a frame is added with. */
struct adding {
    struct fusion *f;
    const struct depth_map *map;
    const struct rgbd_document *d;
    const struct affine *pose;
    const float *white;
    float (*slopes)[2]; /* of 1/z, a pixel to the right and down */
};

static int find_slopes(struct adding *k)
{
    struct depth_links links;
    const size_t width = (size_t)k->map->width, height = (size_t)k->map->height;
    int rc = depth_links_find(k->map, &links);
    k->slopes = malloc(width * height * sizeof *k->slopes);
    if (k->slopes == NULL) rc = ERR_MEMORY;
    for (size_t i = 0; i < width * height && rc == 0; i++) {
        const int32_t x = (int32_t)(i % width), y = (int32_t)(i / width);
        k->slopes[i][0] = depth_links_slope(&links, x, y, DEPTH_LINK_RIGHT, SLOPE_PX);
        k->slopes[i][1] = depth_links_slope(&links, x, y, DEPTH_LINK_DOWN, SLOPE_PX);
    }
    depth_links_fini(&links);
    return rc;
}

static void normal_of(const struct adding *k, size_t i, double out[3])
{
    const size_t width = (size_t)k->map->width;
    depth_normal(k->d, (int32_t)(i % width), (int32_t)(i / width), k->map->z[i], k->slopes[i], out);
}

/* Makes the block that a point of the camera's coordinates is in. */
static int make_at(const struct adding *k, const double p[3], int32_t last[3])
{
    const double side = FUSION_SIDE * k->f->voxel_m, *m = k->pose->m;
    int32_t at[3];
    for (int c = 0; c < 3; c++, m += 4) {
        const double there = dot3(m, p) + m[3] - k->f->origin[c];
        if (!(fabs(there) < FAR_BLOCKS * side)) return ERR_LIMIT;
        at[c] = (int32_t)floor(there / side);
    }
    if (at[0] == last[0] && at[1] == last[1] && at[2] == last[2]) return 0;
    for (int c = 0; c < 3; c++) last[c] = at[c];
    return make_block(k->f, at);
}

/* Makes the blocks before and behind what a pixel shows. */
static int make_around(const struct adding *k, size_t i, int32_t last[3])
{
    const struct rgbd_document *d = k->d;
    const double z = (double)k->map->z[i], band = (double)band_m(k->f, k->map->z[i]);
    const double step = FUSION_SIDE / 2.0 * k->f->voxel_m;
    const double x = (double)(i % (size_t)k->map->width), y = (double)(i / (size_t)k->map->width);
    double n[3];
    int rc = 0;
    normal_of(k, i, n);
    if (!normalize3(n)) return 0;
    for (double at = -band; at < band + step && rc == 0; at += step) {
        const double by = fmin(at, band);
        const double p[3] = {(x - d->cx) / d->fx * z + by * n[0],
                             (y - d->cy) / d->fy * z + by * n[1], z + by * n[2]};
        rc = make_at(k, p, last);
    }
    return rc;
}

static int make_blocks(const struct adding *k)
{
    const size_t count = (size_t)k->map->width * (size_t)k->map->height;
    int32_t last[3] = {INT32_MAX, 0, 0};
    int rc = 0;
    for (size_t i = 0; i < count && rc == 0; i++)
        if (k->map->z[i] > 0) rc = make_around(k, i, last);
    return rc;
}

static void mix(uint16_t *mean, float value, float share)
{
    *mean = (uint16_t)lrintf((float)*mean + (value * 65535.0f - (float)*mean) * share);
}

/* Adds what pixel `i` shows to a voxel that is `off` metres before its surface. Behind a surface
 * little is known: it may be thin. */
static void add_to(const struct adding *k, size_t i, float off, struct fusion_voxel *v)
{
    const float z = k->map->z[i], band = band_m(k->f, z);
    const float *color = k->map->color + 3 * i;
    if (off <= -band) return;
    const float ratio = depth_noise_m(1) / depth_noise_m(z);
    const float weight = k->map->sure[i] * ratio * ratio * (off < 0 ? 1 + off / band : 1);
    if (!(weight > 0)) return;
    const float share = weight / (v->weight + weight);
    v->distance += (fminf(off, band) - v->distance) * share;
    v->weight += weight;
    for (int c = 0; c < 3; c++) mix(&v->albedo[c], white_albedo(color[c], k->white[c]), share);
    mix(&v->shining, white_is_outshone(k->white, color) ? 1 : 0, share);
}

/* Finds the pixel that shows x along an axis of `count`. Beside the image it is the last one, up to
 * `most` pixels away: a surface goes on to the image's end. */
static bool find_pixel(double x, int32_t count, double most, int32_t *out)
{
    if (!(x >= -0.5 - most && x < count - 0.5 + most)) return false;
    const double at = floor(x + 0.5);
    *out = at < 0 ? 0 : at > count - 1 ? count - 1 : (int32_t)at;
    return true;
}

/* Adds the pixel that shows a point of the camera's coordinates, as a plane: by the way along the
 * ray alone, a floor that is seen from low above it would be far away. */
static void add_point(const struct adding *k, const double p[3], struct fusion_voxel *v)
{
    const struct rgbd_document *d = k->d;
    if (!(p[2] > 0)) return;
    const double x = d->fx * p[0] / p[2] + d->cx, y = d->fy * p[1] / p[2] + d->cy;
    const double beside = BESIDE_VOXELS * k->f->voxel_m / p[2];
    double n[3];
    int32_t u, w;
    if (!find_pixel(x, k->map->width, beside * d->fx, &u) ||
        !find_pixel(y, k->map->height, beside * d->fy, &w))
        return;
    const size_t i = (size_t)w * (size_t)k->map->width + (size_t)u;
    if (!(k->map->z[i] > 0)) return;
    normal_of(k, i, n);
    const double own = 1 / (double)k->map->z[i];
    const double there =
        own + (double)k->slopes[i][0] * (x - u) + (double)k->slopes[i][1] * (y - w);
    if (there > 0) add_to(k, i, (float)((1 - p[2] * there) / sqrt(dot3(n, n))), v);
}

/* Computes a point of a block, in voxels from its first, in the camera's coordinates. */
static void see_point(const struct adding *k, const struct fusion_block *block, const double in[3],
                      double out[3])
{
    const double *m = k->pose->m;
    double off[3];
    for (int c = 0; c < 3; c++)
        off[c] = k->f->origin[c] - m[4 * c + 3] +
                 k->f->voxel_m * (FUSION_SIDE * (double)block->at[c] + in[c]);
    for (int c = 0; c < 3; c++) out[c] = m[c] * off[0] + m[4 + c] * off[1] + m[8 + c] * off[2];
}

/* Returns whether a pixel may show a point within r of p, along one axis. */
static bool may_show(double p, double z, double r, double focal, double centre, int32_t count)
{
    const double at = focal * p / z + centre;
    const double most = focal * r / (z - r) * (1 + fabs(p) / z) + 0.5;
    return at >= -most && at <= count - 1 + most;
}

/* A ball around the block, and what goes on beside the image. */
static bool is_seen(const struct adding *k, const struct fusion_block *block)
{
    static const double middle[3] = {FUSION_SIDE / 2.0, FUSION_SIDE / 2.0, FUSION_SIDE / 2.0};
    const double r = (FUSION_SIDE * 0.87 + BESIDE_VOXELS) * k->f->voxel_m;
    const struct rgbd_document *d = k->d;
    double p[3];
    see_point(k, block, middle, p);
    if (p[2] <= r) return p[2] > -r;
    return may_show(p[0], p[2], r, d->fx, d->cx, k->map->width) &&
           may_show(p[1], p[2], r, d->fy, d->cy, k->map->height);
}

static void add_block(const struct adding *k, struct fusion_block *block)
{
    for (int i = 0; i < FUSION_VOXELS; i++) {
        const double in[3] = {i % FUSION_SIDE, i / FUSION_SIDE % FUSION_SIDE,
                              i / (FUSION_SIDE * FUSION_SIDE)};
        double p[3];
        see_point(k, block, in, p);
        add_point(k, p, &block->voxels[i]);
    }
}

int fusion_add(struct fusion *f, const struct depth_map *map, const struct rgbd_document *d,
               const struct affine *pose, const float white[3])
{
    struct adding k = {f, map, d, pose, white, NULL};
    int rc = find_slopes(&k);
    if (rc == 0) rc = make_blocks(&k);
    for (uint32_t i = 0; i < f->count && rc == 0; i++)
        if (is_seen(&k, f->blocks[i])) add_block(&k, f->blocks[i]);
    free(k.slopes);
    return rc;
}
