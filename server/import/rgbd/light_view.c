#include "server/import/rgbd/light_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/rgbd/depth_links.h"
#include "server/import/rgbd/rgbd_parts.h"
#include "server/import/rgbd/white.h"

#define SIDE_PX        160 /* a view's longer side at most */
#define STEPS_MOST     (2 * SIDE_PX)
#define SLOPE_LEAST_PX 2 /* on each side that tell of a slope, and this part of the longer side */
#define SLOPE_PART     32
#define NEAR_M         0.02 /* of a ray, along the camera's axis */
#define FAR_M          100.0

/* A ray is behind a surface and within what it may hide. */
#define BEHIND(z) (2 * depth_noise_m(z) + 0.005f * (z))
#define THICK(z)  (0.1f * (z))

static float color_of(const struct depth_map *map, int32_t x, int32_t y, int32_t step, size_t c)
{
    float sum = 0;
    for (int32_t v = 0; v < step; v++)
        for (int32_t u = 0; u < step; u++)
            sum += map->color[3 * ((size_t)(y + v) * (size_t)map->width + (size_t)(x + u)) + c];
    return sum / (float)(step * step);
}

/* What is as bright as most files can tell may be a lamp; its surroundings say how bright. */
static bool is_cut(const float color[3])
{
    const float least = fminf(color[0], fminf(color[1], color[2]));
    return least >= LIGHT_CUT_LOW && fmaxf(color[0], fmaxf(color[1], color[2])) <= LIGHT_CUT_HIGH;
}

static int32_t longer_side(const struct depth_map *map)
{
    return map->width > map->height ? map->width : map->height;
}

static void find_normal(const struct rgbd_document *d, const struct depth_links *links, int32_t x,
                        int32_t y, const struct light_view *v, struct light_pixel *out)
{
    const int32_t reach_px = SLOPE_LEAST_PX + longer_side(links->map) / SLOPE_PART;
    const float slopes[2] = {depth_links_slope(links, x, y, DEPTH_LINK_RIGHT, reach_px),
                             depth_links_slope(links, x, y, DEPTH_LINK_DOWN, reach_px)};
    double away[3], n[3];
    depth_normal(d, x, y, out->z, slopes, away);
    affine_direction(&v->to_scene, away, n);
    if (!normalize3(n)) return;
    for (int c = 0; c < 3; c++) out->normal[c] = (float)-n[c];
}

static void fill(const struct rgbd_document *d, const struct depth_map *map,
                 const struct depth_links *links, int32_t step, struct light_view *v)
{
    for (int32_t y = 0; y < v->height; y++)
        for (int32_t x = 0; x < v->width; x++) {
            struct light_pixel *p = &v->pixels[(size_t)y * (size_t)v->width + (size_t)x];
            const int32_t u = x * step + step / 2, w = y * step + step / 2;
            for (size_t c = 0; c < 3; c++) p->color[c] = color_of(map, x * step, y * step, step, c);
            p->shines = white_is_outshone(v->white, p->color) || is_cut(p->color);
            p->z = map->z[(size_t)w * (size_t)map->width + (size_t)u];
            if (p->z > 0) find_normal(d, links, u, w, v, p);
        }
}

/* A step pixels of the frame are one of the view. */
static int reduce(const struct rgbd_document *d, const struct depth_map *map, struct light_view *v)
{
    const int32_t shorter = map->width > map->height ? map->height : map->width;
    const int32_t wanted = (longer_side(map) + SIDE_PX - 1) / SIDE_PX;
    const int32_t step = wanted < shorter ? wanted : shorter;
    struct depth_links links;
    v->width = map->width / step;
    v->height = map->height / step;
    v->fx = d->fx / step;
    v->fy = d->fy / step;
    v->cx = (d->cx - 0.5 * (step - 1)) / step;
    v->cy = (d->cy - 0.5 * (step - 1)) / step;
    v->pixels = calloc((size_t)v->width * (size_t)v->height, sizeof *v->pixels);
    const int rc = depth_links_find(map, &links);
    if (rc == 0 && v->pixels != NULL) fill(d, map, &links, step, v);
    depth_links_fini(&links);
    return rc == 0 && v->pixels == NULL ? ERR_MEMORY : rc;
}

static int read_view(const struct rgbd_document *d, struct files *files, uint32_t frame,
                     const struct affine *place, struct light_view *v, struct warnings *warnings,
                     struct fault *fault)
{
    static const double nowhere[3];
    struct depth_map map;
    int rc = depth_map_read(d, files, frame, true, &map, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(&map);
    v->to_scene = rgbd_camera_in(d, frame, place, nowhere);
    const double *m = v->to_scene.m;
    v->units_per_m = sqrt(m[0] * m[0] + m[4] * m[4] + m[8] * m[8]);
    white_find(&map, d, v->white);
    if (reduce(d, &map, v) != 0)
        rc = fault_set(fault, ERR_MEMORY, "/rgbd", "no memory to estimate the light");
    depth_map_destroy(&map);
    return rc;
}

int light_views_read(const struct rgbd_document *d, struct files *files, const struct affine *place,
                     struct light_views *out, struct warnings *warnings, struct fault *fault)
{
    const uint32_t used = d->frame_count < LIGHT_VIEWS ? d->frame_count : LIGHT_VIEWS;
    const struct warnings kept = *warnings; /* frames that are taken warn of the same */
    int rc = 0;
    *out = (struct light_views){.count = used};
    for (uint32_t i = 0; i < used && rc == 0; i++)
        rc = read_view(d, files, (uint32_t)((uint64_t)i * d->frame_count / used), place,
                       &out->list[i], warnings, fault);
    *warnings = kept;
    return rc;
}

void light_views_destroy(struct light_views *views)
{
    for (uint32_t i = 0; i < views->count; i++) free(views->list[i].pixels);
    views->count = 0;
}

/* The view's coordinates of a direction of the scene, or of a point less the camera's, in metres.
 */
static void to_view(const struct light_view *v, const double in[3], double out[3])
{
    const double *m = v->to_scene.m, by = 1 / (v->units_per_m * v->units_per_m);
    for (int c = 0; c < 3; c++) out[c] = by * (m[c] * in[0] + m[4 + c] * in[1] + m[8 + c] * in[2]);
}

/* The view's coordinates of a pixel at a depth. */
static void place_pixel(const struct light_view *v, const struct light_pixel *pixel, double z,
                        double out[3])
{
    const size_t i = (size_t)(pixel - v->pixels), width = (size_t)v->width;
    const size_t x = i % width, y = i / width;
    out[0] = ((double)x - v->cx) / v->fx * z;
    out[1] = ((double)y - v->cy) / v->fy * z;
    out[2] = z;
}

void light_view_ray(const struct light_view *v, const struct light_pixel *pixel, double out[3])
{
    double there[3];
    place_pixel(v, pixel, 1, there);
    affine_direction(&v->to_scene, there, out);
}

void light_view_point(const struct light_view *v, const struct light_pixel *pixel, double out[3])
{
    light_view_ray(v, pixel, out);
    for (int c = 0; c < 3; c++) out[c] = v->to_scene.m[4 * c + 3] + (double)pixel->z * out[c];
}

const struct light_pixel *light_view_look(const struct light_view *v, const double direction[3])
{
    double q[3];
    to_view(v, direction, q);
    if (!(q[2] > 0)) return NULL;
    const double x = floor(v->fx * q[0] / q[2] + v->cx + 0.5);
    const double y = floor(v->fy * q[1] / q[2] + v->cy + 0.5);
    if (!(x >= 0 && y >= 0 && x < v->width && y < v->height)) return NULL;
    return &v->pixels[(size_t)y * (size_t)v->width + (size_t)x];
}

/* A ray in a view: pixels and 1/z at both ends, between which all three are linear. */
struct line {
    double from[3], to[3];
};

static void project(const struct light_view *v, const double p[3], double out[3])
{
    out[0] = v->fx * p[0] / p[2] + v->cx;
    out[1] = v->fy * p[1] / p[2] + v->cy;
    out[2] = 1 / p[2];
}

static bool make_line(const struct light_view *v, const double o[3], const double q[3],
                      struct line *out)
{
    double first = 0, last = FAR_M, a[3], b[3];
    if (q[2] > 0 && o[2] < NEAR_M) first = (NEAR_M - o[2]) / q[2];
    if (q[2] < 0 && o[2] + last * q[2] < NEAR_M) last = (NEAR_M - o[2]) / q[2];
    if (!(q[2] > 0) && !(o[2] > NEAR_M)) return false;
    if (!(first < last)) return false;
    for (int c = 0; c < 3; c++) {
        a[c] = o[c] + first * q[c];
        b[c] = o[c] + last * q[c];
    }
    project(v, a, out->from);
    project(v, b, out->to);
    return true;
}

/* Cuts first..last to where the line lies within an axis of `count` pixels. */
static bool clip(double from, double to, int32_t count, double *first, double *last)
{
    const double low = -0.5, high = count - 0.5, way = to - from;
    if (fabs(way) < 1e-9) return from >= low && from < high;
    const double a = (low - from) / way, b = (high - from) / way;
    *first = fmax(*first, fmin(a, b));
    *last = fmin(*last, fmax(a, b));
    return *first < *last;
}

static double between(const double from[3], const double to[3], int c, double at)
{
    return from[c] + at * (to[c] - from[c]);
}

/* Returns the pixel of the line's stretch from a to b, if that passes behind what it shows. */
static const struct light_pixel *meet(const struct light_view *v, const struct line *l, double a,
                                      double b)
{
    const int32_t x = (int32_t)floor(between(l->from, l->to, 0, 0.5 * (a + b)) + 0.5);
    const int32_t y = (int32_t)floor(between(l->from, l->to, 1, 0.5 * (a + b)) + 0.5);
    if (x < 0 || y < 0 || x >= v->width || y >= v->height) return NULL;
    const struct light_pixel *p = &v->pixels[(size_t)y * (size_t)v->width + (size_t)x];
    const float za = (float)(1 / between(l->from, l->to, 2, a));
    const float zb = (float)(1 / between(l->from, l->to, 2, b));
    const float behind = p->z + BEHIND(p->z);
    return p->z > 0 && fmaxf(za, zb) > behind && fminf(za, zb) < behind + THICK(p->z) ? p : NULL;
}

struct light_hit light_view_trace(const struct light_view *v, const double from[3],
                                  const double direction[3])
{
    struct light_hit hit = {.view = v};
    double away[3], o[3], q[3], there[3], first = 0, last = 1;
    struct line l;
    for (int c = 0; c < 3; c++) away[c] = from[c] - v->to_scene.m[4 * c + 3];
    to_view(v, away, o);
    to_view(v, direction, q);
    if (!normalize3(q) || !make_line(v, o, q, &l)) return hit;
    if (!clip(l.from[0], l.to[0], v->width, &first, &last) ||
        !clip(l.from[1], l.to[1], v->height, &first, &last))
        return hit;
    const double way = fmax(fabs(l.to[0] - l.from[0]), fabs(l.to[1] - l.from[1])) * (last - first);
    const int32_t steps = 1 + (int32_t)fmin(way, STEPS_MOST);
    for (int32_t i = 0; i < steps && hit.pixel == NULL; i++)
        hit.pixel = meet(v, &l, first + (last - first) * i / steps,
                         first + (last - first) * (i + 1) / steps);
    if (hit.pixel == NULL) return hit;
    place_pixel(v, hit.pixel, (double)hit.pixel->z, there);
    for (int c = 0; c < 3; c++) there[c] -= o[c];
    hit.distance = sqrt(dot3(there, there)) * v->units_per_m;
    return hit;
}
