#include "server/import/rgbd/plane_fit.h"

#include <math.h>
#include <string.h>

#include "server/import/rgbd/depth_map.h"

void plane_fit_add(struct plane_fit *f, double u, double v, double z, const double *plane)
{
    const double row[3] = {1, u, v};
    double weight = 1;
    if (plane != NULL) {
        const double off = (dot3(plane, row) - 1 / z) * z * z / (double)depth_noise_m((float)z);
        weight = 1 / (1 + off * off);
    }
    f->weight += weight;
    for (int i = 0; i < 3; i++) {
        f->b[i] += weight * row[i] / z;
        for (int j = 0; j < 3; j++) f->a[i][j] += weight * row[i] * row[j];
    }
}

static double determinant(double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

bool plane_fit_solve(const struct plane_fit *f, double plane[3])
{
    double m[3][3];
    memcpy(m, f->a, sizeof m);
    const double det = determinant(m);
    if (!(fabs(det) > 1e-12)) return false;
    for (int k = 0; k < 3; k++) {
        memcpy(m, f->a, sizeof m);
        for (int i = 0; i < 3; i++) m[i][k] = f->b[i];
        plane[k] = determinant(m) / det;
    }
    return true;
}
