/* Averages what several frames measured of the same points. */
#include <math.h>
#include <stdlib.h>

#include "server/import/rgbd/depth_map.h"

/* Measurements further apart than so many standard deviations are of different surfaces. */
#define APART 3.0f

struct fusion {
    struct depth_map *map;
    const struct depth_map *other;
    const struct rgbd_document *d;
};

/* Computes the point at a depth; columns and rows count from the first pixel's centre. */
static void place(const struct rgbd_document *d, double x, double y, double z, float out[3])
{
    out[0] = (float)((x - d->cx) / d->fx * z);
    out[1] = (float)((y - d->cy) / d->fy * z);
    out[2] = (float)z;
}

static bool project(const struct fusion *f, const float at[3], double *x, double *y)
{
    if (!(at[2] > 0)) return false;
    *x = f->d->fx * (double)at[0] / (double)at[2] + f->d->cx;
    *y = f->d->fy * (double)at[1] / (double)at[2] + f->d->cy;
    return *x >= 0 && *y >= 0 && *x <= f->other->width - 1 && *y <= f->other->height - 1;
}

/* Reads between four pixels, linear in 1/z as planes are. Returns 0 unless all are of one surface
 * at about that depth. */
static float read_between(const struct depth_map *m, double x, double y, float expected)
{
    const int32_t u = (int32_t)x < m->width - 1 ? (int32_t)x : m->width - 2;
    const int32_t v = (int32_t)y < m->height - 1 ? (int32_t)y : m->height - 2;
    const float fx = (float)(x - u), fy = (float)(y - v);
    const float near = APART * depth_noise_m(expected) + 0.01f * expected;
    float sum = 0;
    for (int k = 0; k < 4; k++) {
        const float z = m->z[(size_t)(v + k / 2) * (size_t)m->width + (size_t)(u + k % 2)];
        if (!(z > 0) || fabsf(z - expected) > near) return 0;
        sum += (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) / z;
    }
    return 1 / sum;
}

static void fuse_pixel(const struct fusion *f, const struct affine *to_other, int32_t x, int32_t y)
{
    struct depth_map *m = f->map;
    const size_t i = (size_t)y * (size_t)m->width + (size_t)x;
    float here[3], there[3];
    double u, v;
    if (!(m->z[i] > 0) || m->sure[i] < 1) return;
    place(f->d, x, y, (double)m->z[i], here);
    affine_point(to_other, here, there);
    if (!project(f, there, &u, &v)) return;
    const float z = read_between(f->other, u, v, there[2]), off = z - there[2];
    if (!(z > 0) || fabsf(off) > APART * sqrtf(2) * depth_noise_m(there[2])) return;
    const float ratio = depth_noise_m(there[2]) / depth_noise_m(m->z[i]);
    const float weight = 1 / (ratio * ratio), all = m->sure[i] + weight;
    m->z[i] += weight / all * off;
    m->sure[i] = all;
}

/* Gives pixels without a depth the nearest that the other frame's pixels have there. */
static void fill(const struct fusion *f, const struct affine *from_other, float *seen)
{
    const struct depth_map *o = f->other;
    const struct fusion back = {.map = f->map, .other = f->map, .d = f->d};
    for (int32_t y = 0; y < o->height; y++)
        for (int32_t x = 0; x < o->width; x++) {
            const float z = o->z[(size_t)y * (size_t)o->width + (size_t)x];
            float there[3], here[3];
            double u, v;
            if (!(z > 0)) continue;
            place(f->d, x, y, (double)z, there);
            affine_point(from_other, there, here);
            if (!project(&back, here, &u, &v)) continue;
            float *at = &seen[(size_t)lround(v) * (size_t)f->map->width + (size_t)lround(u)];
            if (*at == 0 || here[2] < *at) *at = here[2];
        }
}

int depth_map_fuse(struct depth_map *map, const struct depth_map *other,
                   const struct rgbd_document *d, const struct affine *to_other,
                   const struct affine *from_other, struct fault *fault)
{
    const struct fusion f = {.map = map, .other = other, .d = d};
    const size_t count = (size_t)map->width * (size_t)map->height;
    if (map->width < 2 || map->height < 2) return 0;
    float *seen = calloc(count, sizeof *seen);
    if (seen == NULL) return fault_set(fault, ERR_MEMORY, "/rgbd", "no memory for depth");
    fill(&f, from_other, seen);
    for (int32_t y = 0; y < map->height; y++)
        for (int32_t x = 0; x < map->width; x++) fuse_pixel(&f, to_other, x, y);
    for (size_t i = 0; i < count; i++) {
        const double z = (double)seen[i];
        if (map->z[i] > 0 || !(z > 0 && z >= d->near_m && z <= d->far_m)) continue;
        map->z[i] = seen[i];
        map->sure[i] = 0.5f;
    }
    free(seen);
    return 0;
}
