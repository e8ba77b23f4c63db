#include "proto/scene/camera_fit.h"

#include <math.h>

#define YFOV_RAD      0.6108652381980153 /* 35 degrees: little distortion at the edges */
#define MARGIN        1.06               /* of the picture over what it shows */
#define AZIMUTH_RAD   0.5235987755982988 /* 30 degrees from +z towards +x */
#define ELEVATION_RAD 0.3490658503988659 /* 20 degrees */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Finds where an eye must stand along an axis of the picture, and how far in front of the box's
 * middle, so that it sees all corners within a slope. A corner at a, z in front of the middle, is
 * seen from e at distance d where |a - e| <= slope (d + z). */
static double fit_axis(double corner[8][3], const double axis[3], const double forward[3],
                       double slope, double *eye)
{
    double most = -INFINITY, least = INFINITY;
    for (int i = 0; i < 8; i++) {
        const double a = dot(corner[i], axis), z = dot(corner[i], forward);
        most = fmax(most, a - slope * z);
        least = fmin(least, a + slope * z);
    }
    *eye = (most + least) / 2;
    return (most - least) / (2 * slope);
}

void camera_fit(const float lowest[3], const float highest[3], double aspect,
                struct scene_camera *camera)
{
    const double sa = sin(AZIMUTH_RAD), ca = cos(AZIMUTH_RAD);
    const double se = sin(ELEVATION_RAD), ce = cos(ELEVATION_RAD);
    const double forward[3] = {-sa * ce, -se, -ca * ce}, right[3] = {ca, 0, -sa};
    const double up[3] = {-sa * se, ce, -ca * se}, slope = tan(YFOV_RAD / 2) / MARGIN;
    double corner[8][3], centre[3], radius = 0, across, down;
    for (int c = 0; c < 3; c++) {
        const double half = ((double)highest[c] - (double)lowest[c]) / 2;
        centre[c] = ((double)highest[c] + (double)lowest[c]) / 2;
        for (int i = 0; i < 8; i++) corner[i][c] = i >> c & 1 ? half : -half;
        radius += half * half;
    }
    double distance = fmax(fit_axis(corner, right, forward, slope * aspect, &across),
                           fit_axis(corner, up, forward, slope, &down));
    if (!(radius > 0)) distance = 1; /* of a point any will do */
    camera->yfov_rad = (float)YFOV_RAD;
    camera->is_default = 1;
    for (int c = 0; c < 3; c++) {
        camera->eye[c] =
            (float)(centre[c] + across * right[c] + down * up[c] - distance * forward[c]);
        camera->right[c] = (float)right[c];
        camera->up[c] = (float)up[c];
        camera->forward[c] = (float)forward[c];
    }
}
