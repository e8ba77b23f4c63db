#pragma once
/* Cosine-distributed directions by the plane z = 1 in which a bounce ray (x, y, z) passes through
 * v = (x/z, y/z): a map of the unit square for the sheared filter of indirect light, which works
 * along one axis of that plane, then along the other (filters.md section 3).
 *
 *   a = 2u - 1,                    v1 = a / sqrt(1 - a^2)
 *   theta + sin theta = pi (2v-1), v2 = sqrt(1 + v1^2) tan(theta / 2)
 *
 * A column of strata, of one u, is a line of one v1. The density over the v-plane is (1/pi) /
 * (1 + |v|^2)^2, which is cos/pi per solid angle: (x, y) is uniform on the unit disc, u chooses the
 * place along a chord and v the chord. Own arithmetic, the same bits on every CPU; errors are below
 * 1e-7. */

/* Numbers nearer to the ends count as these: |v1| stays below 2^12, |v2| below 2^21. */
#define V_PLANE_END 0x1p-24f

/* a and sqrt(1 - a^2): v1 = side / height. */
void v_plane_column(float u, float *side, float *height);

/* Sine and cosine of theta / 2. */
void v_plane_row(float v, float *sine, float *cosine);

/* The unit direction around +z of a column and a row. */
static inline void v_plane_direction(float side, float height, float sine, float cosine,
                                     float direction[3])
{
    direction[0] = side * cosine;
    direction[1] = sine;
    direction[2] = height * cosine;
}
