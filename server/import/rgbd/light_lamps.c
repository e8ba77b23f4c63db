#include "server/import/rgbd/light_lamps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/rgbd/plane_fit.h"

#define LEAST_PX   4    /* of a view; what shines in fewer is a glint */
#define GRAZING    0.05 /* cosine below which a pixel's area is not known */
#define AROUND_PX  2    /* of a lamp, which tell of its plane, too */
#define FIT_STEPS  6
#define FARTHER    4.0   /* parts of a lamp than its middle, at most */
#define LONGEST    16.0  /* of a lamp's sides */
#define BESIDE     1.5   /* lamps so many of their sizes apart are one */
#define OFF_NOISES 2.0   /* how far before the surface they hang: noises, */
#define OFF_DEPTH  0.005 /* and shares of the depth */
#define SIDE_STEPS 3     /* of a lamp's quadrature */

/* Sums over the pixels of a lamp. */
struct sums {
    double count, color[3];
    double middle[2]; /* pixel that the plane is told from */
    double plane[3];  /* plane_fit.h */
    double normal[3]; /* towards the camera, in the scene */
    double depth;     /* metres */
    double area, point[3], square[3][3];
    float most;
};

struct finder {
    const struct light_view *view;
    uint32_t *queue; /* owned */
    bool *done;      /* owned */
    struct light_lamp *lamps;
    int count;
};

static double luminance(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

static double power(const struct light_lamp *l)
{
    return l->area * luminance(l->radiance);
}

/* Adds a pixel and those around it, whose surface is the lamp's or goes on beside it. */
static void add_around(const struct light_view *v, uint32_t pixel, const double *plane,
                       const struct sums *s, struct plane_fit *fit)
{
    const int32_t x = (int32_t)(pixel % (uint32_t)v->width);
    const int32_t y = (int32_t)(pixel / (uint32_t)v->width);
    for (int32_t j = y - AROUND_PX; j <= y + AROUND_PX; j++)
        for (int32_t i = x - AROUND_PX; i <= x + AROUND_PX; i++) {
            if (i < 0 || j < 0 || i >= v->width || j >= v->height) continue;
            const float z = v->pixels[(size_t)j * (size_t)v->width + (size_t)i].z;
            if (z > 0) plane_fit_add(fit, i - s->middle[0], j - s->middle[1], (double)z, plane);
        }
}

/* Returns 1/z of the lamp's plane at a pixel. */
static double inverse_at(const struct light_view *v, const struct sums *s, uint32_t pixel)
{
    const uint32_t x = pixel % (uint32_t)v->width, y = pixel / (uint32_t)v->width;
    return s->plane[0] + s->plane[1] * (x - s->middle[0]) + s->plane[2] * (y - s->middle[1]);
}

/* Fits the lamp's plane. Returns false where no depth is known. */
static bool find_plane(const struct finder *f, uint32_t count, struct sums *s)
{
    const struct light_view *v = f->view;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t x = f->queue[i] % (uint32_t)v->width, y = f->queue[i] / (uint32_t)v->width;
        s->middle[0] += (double)x / count;
        s->middle[1] += (double)y / count;
    }
    for (int step = 0; step < FIT_STEPS; step++) {
        struct plane_fit fit = {.weight = 0};
        for (uint32_t i = 0; i < count; i++)
            add_around(v, f->queue[i], step > 0 ? s->plane : NULL, s, &fit);
        if (!(fit.weight > LEAST_PX) || !plane_fit_solve(&fit, s->plane)) return false;
    }
    const double x = s->middle[0], y = s->middle[1];
    const double away[3] = {-s->plane[1] * v->fx, -s->plane[2] * v->fy,
                            s->plane[1] * (x - v->cx) + s->plane[2] * (y - v->cy) - s->plane[0]};
    affine_direction(&v->to_scene, away, s->normal);
    s->depth = 1 / s->plane[0];
    return s->plane[0] > 0 && normalize3(s->normal);
}

/* Adds the part of the plane that a pixel shows. */
static void add_part(const struct light_view *v, uint32_t pixel, struct sums *s)
{
    double ray[3], at[3];
    const double inverse = fmax(inverse_at(v, s, pixel), s->plane[0] / FARTHER), z = 1 / inverse;
    light_view_ray(v, &v->pixels[pixel], ray);
    const double length = sqrt(dot3(ray, ray)), facing = -dot3(ray, s->normal) / length;
    const double side = z * v->units_per_m;
    /* The second factor is the cosine to the camera's axis. */
    const double area =
        side * side / (v->fx * v->fy) * (v->units_per_m / length) / fmax(facing, GRAZING);
    for (int i = 0; i < 3; i++) at[i] = v->to_scene.m[4 * i + 3] + z * ray[i];
    s->area += area;
    for (int i = 0; i < 3; i++) {
        s->point[i] += area * at[i];
        for (int j = 0; j < 3; j++) s->square[i][j] += area * at[i] * at[j];
    }
}

/* Finds the pixels that shine and hang together with one of them: f->queue. Returns their number.
 */
static uint32_t flood(struct finder *f, uint32_t from)
{
    const struct light_view *v = f->view;
    const uint32_t width = (uint32_t)v->width, height = (uint32_t)v->height;
    uint32_t first = 0, end = 1;
    f->queue[0] = from;
    f->done[from] = true;
    while (first < end) {
        const uint32_t i = f->queue[first++], x = i % width, y = i / width;
        const uint32_t near[4] = {i - 1, i + 1, i - width, i + width};
        const bool there[4] = {x > 0, x + 1 < width, y > 0, y + 1 < height};
        for (int k = 0; k < 4; k++) {
            if (!there[k] || f->done[near[k]] || !v->pixels[near[k]].shines) continue;
            f->done[near[k]] = true;
            f->queue[end++] = near[k];
        }
    }
    return end;
}

/* Sums up the pixels of f->queue. Returns whether they are a lamp whose place is known. */
static bool sum_up(const struct finder *f, uint32_t count, struct sums *s)
{
    *s = (struct sums){.count = count};
    if (count < LEAST_PX || !find_plane(f, count, s)) return false;
    for (uint32_t i = 0; i < count; i++) {
        const struct light_pixel *p = &f->view->pixels[f->queue[i]];
        add_part(f->view, f->queue[i], s);
        for (int c = 0; c < 3; c++) {
            s->color[c] += (double)p->color[c];
            s->most = fmaxf(s->most, p->color[c]);
        }
    }
    return s->area > 0 && isfinite(s->area);
}

/* Finds the longer axis of the pixels' spread across the normal by power iteration, and how much
 * longer it is. */
static double find_axis(const struct sums *s, const double center[3], const double normal[3],
                        double u[3])
{
    double m[3][3], v[3], moved[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[i][j] = s->square[i][j] / s->area - center[i] * center[j];
    const int axis = fabs(normal[0]) < 0.6 ? 0 : fabs(normal[1]) < 0.6 ? 1 : 2;
    const double any[3] = {axis == 0, axis == 1, axis == 2};
    cross3(normal, any, u);
    normalize3(u);
    for (int step = 0; step < 32; step++) {
        for (int i = 0; i < 3; i++) moved[i] = dot3(m[i], u);
        const double off = dot3(moved, normal);
        for (int i = 0; i < 3; i++) moved[i] -= off * normal[i];
        if (!normalize3(moved)) break;
        memcpy(u, moved, sizeof moved);
    }
    cross3(normal, u, v);
    double along = 0, across = 0;
    for (int i = 0; i < 3; i++) {
        along += u[i] * dot3(m[i], u);
        across += v[i] * dot3(m[i], v);
    }
    return fmin(sqrt(fmax(along, 0) / fmax(across, 1e-12 * fmax(along, 1e-30))), LONGEST);
}

static void make_lamp(const struct finder *f, const struct sums *s, struct light_lamp *out)
{
    double u[3], v[3];
    *out = (struct light_lamp){.area = s->area, .depth_m = s->depth};
    memcpy(out->normal, s->normal, sizeof out->normal);
    for (int c = 0; c < 3; c++) {
        out->center[c] = s->point[c] / s->area;
        out->radiance[c] = s->color[c] / s->count;
    }
    const double longer = find_axis(s, out->center, out->normal, u);
    cross3(out->normal, u, v);
    const double half = 0.5 * sqrt(s->area);
    const double noise = (double)depth_noise_m((float)out->depth_m);
    const double off = f->view->units_per_m * (OFF_NOISES * noise + OFF_DEPTH * out->depth_m);
    for (int c = 0; c < 3; c++) {
        out->half_u[c] = half * sqrt(longer) * u[c];
        out->half_v[c] = half / sqrt(longer) * v[c];
        out->center[c] += off * out->normal[c];
    }
    out->is_cut = s->most >= LIGHT_CUT_LOW && s->most <= LIGHT_CUT_HIGH;
}

static bool is_same(const struct light_lamp *a, const struct light_lamp *b)
{
    double off[3];
    for (int c = 0; c < 3; c++) off[c] = a->center[c] - b->center[c];
    const double size = 0.5 * (sqrt(a->area) + sqrt(b->area));
    return dot3(off, off) < BESIDE * BESIDE * size * size;
}

/* Keeps the stronger of those that are the same, and of too many. */
static void keep(struct finder *f, const struct light_lamp *lamp)
{
    int weakest = 0, kept = 0;
    for (int i = 0; i < f->count; i++)
        if (is_same(&f->lamps[i], lamp) && power(&f->lamps[i]) >= power(lamp)) return;
    for (int i = 0; i < f->count; i++)
        if (!is_same(&f->lamps[i], lamp)) f->lamps[kept++] = f->lamps[i];
    f->count = kept;
    for (int i = 0; i < f->count; i++)
        if (power(&f->lamps[i]) < power(&f->lamps[weakest])) weakest = i;
    if (f->count < LIGHT_LAMPS)
        f->lamps[f->count++] = *lamp;
    else if (power(lamp) > power(&f->lamps[weakest]))
        f->lamps[weakest] = *lamp;
}

static int find_in_view(struct finder *f)
{
    const uint32_t pixels = (uint32_t)f->view->width * (uint32_t)f->view->height;
    f->queue = malloc(pixels * sizeof *f->queue);
    f->done = calloc(pixels, sizeof *f->done);
    for (uint32_t i = 0; f->queue && f->done && i < pixels; i++) {
        struct sums s;
        struct light_lamp lamp;
        if (f->done[i] || !f->view->pixels[i].shines) continue;
        if (!sum_up(f, flood(f, i), &s)) continue;
        make_lamp(f, &s, &lamp);
        keep(f, &lamp);
    }
    const int rc = f->queue && f->done ? 0 : ERR_MEMORY;
    free(f->queue);
    free(f->done);
    return rc;
}

static int by_power(const void *a, const void *b)
{
    const double x = power(a), y = power(b);
    return (x < y) - (x > y);
}

int light_lamps_find(const struct light_views *views, struct light_lamp out[LIGHT_LAMPS])
{
    struct finder f = {.lamps = out};
    for (uint32_t i = 0; i < views->count; i++) {
        f.view = &views->list[i];
        if (find_in_view(&f) != 0) return -1;
    }
    qsort(out, (size_t)f.count, sizeof *out, by_power);
    return f.count;
}

double light_lamp_falls(const struct light_lamp *lamp, const double point[3],
                        const double normal[3])
{
    double sum = 0;
    for (int i = 0; i < SIDE_STEPS * SIDE_STEPS; i++) {
        const int column = i % SIDE_STEPS, row = i / SIDE_STEPS;
        const double u = (2 * column + 1.0) / SIDE_STEPS - 1;
        const double v = (2 * row + 1.0) / SIDE_STEPS - 1;
        double to[3];
        for (int c = 0; c < 3; c++)
            to[c] = lamp->center[c] + u * lamp->half_u[c] + v * lamp->half_v[c] - point[c];
        const double square = fmax(dot3(to, to), lamp->area / (SIDE_STEPS * SIDE_STEPS));
        const double here = dot3(to, normal), there = -dot3(to, lamp->normal);
        if (here > 0 && there > 0) sum += here * there / (square * square);
    }
    return sum * lamp->area / (SIDE_STEPS * SIDE_STEPS);
}
