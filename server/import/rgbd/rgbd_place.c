#include "server/import/rgbd/rgbd_place.h"

#include <math.h>

#include "server/import/rgbd/plane_fit.h"

#define PLACE     "/rgbd/place/pixel"
#define REACH_PX  24 /* the surface around the pixel that tells of its slope */
#define LEAST_PX  64
#define FIT_STEPS 6
#define STEEP     0.02 /* sine to the normal below which a camera looks straight down */

/* Adds the pixels around one. In later steps those count less that are off the plane so far. */
static void add(const struct depth_map *m, const int32_t at[2], const double *plane,
                struct plane_fit *f)
{
    for (int32_t v = -REACH_PX; v <= REACH_PX; v++)
        for (int32_t u = -REACH_PX; u <= REACH_PX; u++) {
            const int32_t x = at[0] + u, y = at[1] + v;
            if (x < 0 || y < 0 || x >= m->width || y >= m->height) continue;
            const double z = (double)m->z[(size_t)y * (size_t)m->width + (size_t)x];
            if (z > 0) plane_fit_add(f, u, v, z, plane);
        }
}

static int fit_plane(const struct depth_map *m, const double pixel[2], double out[3],
                     struct fault *fault)
{
    const int32_t at[2] = {(int32_t)lround(pixel[0]), (int32_t)lround(pixel[1])};
    if (!(pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] <= m->width - 1 && pixel[1] <= m->height - 1))
        return fault_set(fault, ERR_RANGE, PLACE, "%g, %g is not in an image of %d x %d px",
                         pixel[0], pixel[1], m->width, m->height);
    for (int step = 0; step < FIT_STEPS; step++) {
        struct plane_fit f = {.weight = 0};
        add(m, at, step > 0 ? out : NULL, &f);
        if (!(f.weight > LEAST_PX) || !plane_fit_solve(&f, out) || !(out[0] > 0))
            return fault_set(fault, ERR_NOT_FOUND, PLACE,
                             "too little depth is known around it to find a surface");
    }
    return 0;
}

/* Computes point and normal of the plane in the camera's coordinates. */
static void plane_in_space(const struct rgbd_document *d, const double plane[3], double point[3],
                           double normal[3])
{
    const double x = d->place.pixel[0], y = d->place.pixel[1];
    const double there =
        plane[0] + plane[1] * (x - (double)lround(x)) + plane[2] * (y - (double)lround(y));
    const double z = 1 / there;
    point[0] = (x - d->cx) / d->fx * z;
    point[1] = (y - d->cy) / d->fy * z;
    point[2] = z;
    normal[0] = -plane[1] * d->fx;
    normal[1] = -plane[2] * d->fy;
    normal[2] = -(there + plane[1] * (d->cx - x) + plane[2] * (d->cy - y));
    normalize3(normal);
}

/* y along the normal, z as far towards the camera as that allows, or where the camera looks
 * straight down, towards the image's lower edge; both turned about y. */
static void axes_of(const double normal[3], const double to_camera[3], const double down[3],
                    double turn_rad, double axes[3][3])
{
    double x[3], z[3];
    cross3(normal, to_camera, x);
    if (dot3(x, x) < STEEP * STEEP * dot3(to_camera, to_camera)) cross3(normal, down, x);
    normalize3(x);
    cross3(x, normal, z);
    for (int i = 0; i < 3; i++) {
        axes[0][i] = cos(turn_rad) * x[i] - sin(turn_rad) * z[i];
        axes[1][i] = normal[i];
        axes[2][i] = sin(turn_rad) * x[i] + cos(turn_rad) * z[i];
    }
}

static int place_on(const struct rgbd_document *d, const struct depth_map *m, struct affine *out,
                    struct fault *fault)
{
    const struct affine *pose = &d->frames[d->place.frame - 1].pose;
    double plane[3] = {0}, point[3], normal[3], n[3], to_camera[3], axes[3][3];
    float world[3];
    int rc = fit_plane(m, d->place.pixel, plane, fault);
    if (rc != 0) return rc;
    plane_in_space(d, plane, point, normal);
    affine_point(pose, (float[3]){(float)point[0], (float)point[1], (float)point[2]}, world);
    affine_direction(pose, normal, n);
    for (int i = 0; i < 3; i++) to_camera[i] = pose->m[4 * i + 3] - (double)world[i];
    const double down[3] = {pose->m[1], pose->m[5], pose->m[9]};
    axes_of(n, to_camera, down, d->place.turn_deg * M_PI / 180, axes);
    for (int i = 0; i < 3; i++) {
        double moved = 0;
        for (int j = 0; j < 3; j++) {
            out->m[4 * i + j] = d->place.scale * axes[i][j];
            moved -= out->m[4 * i + j] * (double)world[j];
        }
        out->m[4 * i + 3] = moved;
    }
    return 0;
}

int rgbd_place_find(const struct rgbd_document *d, struct files *files, struct affine *out,
                    struct warnings *warnings, struct fault *fault)
{
    struct depth_map m;
    *out = d->to_scene;
    if (d->has_to_scene) return 0;
    int rc = depth_map_read(d, files, d->place.frame - 1, false, &m, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(&m);
    rc = place_on(d, &m, out, fault);
    depth_map_destroy(&m);
    return rc;
}
