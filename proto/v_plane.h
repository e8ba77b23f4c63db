#pragma once
/* Cosine-distributed directions by the plane z = 1 in which a bounce ray (x, y, z) passes through
 * v = (x/z, y/z): a map of the unit square for the sheared filter of indirect light, which works
 * along one axis of that plane, then along the other (docs/reconstruction.md, V-plane filter).
 *
 *   a = 2u - 1,                    v1 = a / sqrt(1 - a^2)
 *   theta + sin theta = pi (2v-1), v2 = sqrt(1 + v1^2) tan(theta / 2)
 *
 * A column of strata, of one u, is a line of one v1. The density over the v-plane is (1/pi) /
 * (1 + |v|^2)^2, which is cos/pi per solid angle: (x, y) is uniform on the unit disc, u chooses the
 * place along a chord and v the chord. Own arithmetic, the same bits on every CPU; errors are below
 * 1e-7. */

#include <stdint.h>

/* Numbers nearer to the ends count as these: |v1| stays below 2^12, |v2| below 2^21. */
#define V_PLANE_END 0x1p-24f

/* Computes a and sqrt(1 - a^2), of which v1 = side / height. */
void v_plane_column(float u, float *side, float *height);

/* Computes the sine and cosine of theta / 2. */
void v_plane_row(float v, float *sine, float *cosine);

/* Does the same for `count` numbers; no array overlaps another. */
void v_plane_rows(const float *v, uint32_t count, float *sine, float *cosine);

/* Computes tangents of a unit normal n, all in the camera's axes (right, up, back); Frisvad 2012,
 * "Building an orthonormal basis from a 3D unit vector without normalization". Its pole, n = (0, 0,
 * -1), lies where no visible normal points; nearer to it than V_PLANE_POLE 1 / (1 + n_z) has lost
 * its digits. Bounce rays of light fields are given around them, so that workers and filters must
 * agree. */
#define V_PLANE_POLE (-0.9999f)
static inline void v_plane_tangents(float x, float y, float z, float first[3], float second[3])
{
    const int pole = z < V_PLANE_POLE;
    const float a = 1.0f / (1.0f + (pole ? 0.0f : z)), b = -x * y * a;
    first[0] = pole ? 0.0f : 1.0f - x * x * a;
    first[1] = pole ? -1.0f : b;
    first[2] = pole ? 0.0f : -x;
    second[0] = pole ? -1.0f : b;
    second[1] = pole ? 0.0f : 1.0f - y * y * a;
    second[2] = pole ? 0.0f : -y;
}

/* Computes the unit direction around +z of a column and a row. */
static inline void v_plane_direction(float side, float height, float sine, float cosine,
                                     float direction[3])
{
    direction[0] = side * cosine;
    direction[1] = sine;
    direction[2] = height * cosine;
}
