#include "server/import/scene/transform.h"

#include <math.h>
#include <string.h>

/* Relative volume of the image of the unit cube below which a transform counts as flat. */
#define SINGULAR_VOLUME 1e-8

/* Absolute volume below which an inverse in floats is out of reach. */
#define LEAST_VOLUME 1e-30

struct affine affine_identity(void)
{
    return (struct affine){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
}

struct affine affine_translation(const double by[3])
{
    return (struct affine){{1, 0, 0, by[0], 0, 1, 0, by[1], 0, 0, 1, by[2]}};
}

struct affine affine_multiply(const struct affine *a, const struct affine *b)
{
    struct affine out;
    for (int r = 0; r < 3; r++) {
        const double *row = a->m + 4 * r;
        for (int c = 0; c < 4; c++) {
            double sum = row[0] * b->m[c] + row[1] * b->m[4 + c] + row[2] * b->m[8 + c];
            out.m[4 * r + c] = c == 3 ? sum + row[3] : sum;
        }
    }
    return out;
}

struct affine affine_from_trs(const double translation[3], const double rotation[4],
                              const double scale[3])
{
    double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                   2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                   2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    struct affine out;
    for (int i = 0; i < 3; i++) {
        for (int c = 0; c < 3; c++) out.m[4 * i + c] = r[3 * i + c] * scale[c];
        out.m[4 * i + 3] = translation[i];
    }
    return out;
}

bool affine_from_columns(const double columns[16], struct affine *out)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) out->m[4 * r + c] = columns[4 * c + r];
    return fabs(columns[3]) < 1e-9 && fabs(columns[7]) < 1e-9 && fabs(columns[11]) < 1e-9 &&
           fabs(columns[15] - 1) < 1e-9;
}

struct affine affine_mirrored(const struct affine *a)
{
    struct affine out = *a;
    for (int r = 0; r < 3; r++) out.m[4 * r] = -out.m[4 * r];
    return out;
}

void affine_point(const struct affine *a, const float in[3], float out[3])
{
    double p[3] = {in[0], in[1], in[2]}, q[3];
    affine_direction(a, p, q);
    for (int i = 0; i < 3; i++) out[i] = (float)(q[i] + a->m[4 * i + 3]);
}

void affine_direction(const struct affine *a, const double in[3], double out[3])
{
    for (int r = 0; r < 3; r++) out[r] = dot3(a->m + 4 * r, in);
}

void affine_normal(const struct affine *a, const double in[3], double out[3])
{
    double cofactor[3];
    for (int r = 0; r < 3; r++) {
        cross3(a->m + 4 * ((r + 1) % 3), a->m + 4 * ((r + 2) % 3), cofactor);
        out[r] = dot3(cofactor, in);
    }
}

double affine_determinant(const struct affine *a)
{
    double cofactor[3];
    cross3(a->m + 4, a->m + 8, cofactor);
    return dot3(a->m, cofactor);
}

bool affine_is_singular(const struct affine *a)
{
    double volume = 1;
    for (int c = 0; c < 3; c++) {
        const double column[3] = {a->m[c], a->m[4 + c], a->m[8 + c]};
        volume *= sqrt(dot3(column, column));
    }
    double determinant = fabs(affine_determinant(a));
    return !(determinant > SINGULAR_VOLUME * volume && determinant > LEAST_VOLUME);
}

bool affine_is_finite(const struct affine *a)
{
    for (int i = 0; i < 12; i++)
        if (!isfinite((float)a->m[i])) return false;
    return true;
}

bool affine_is_identity(const struct affine *a)
{
    const struct affine identity = affine_identity();
    for (int i = 0; i < 12; i++)
        if (a->m[i] != identity.m[i]) return false;
    return true;
}

bool normalize3(double v[3])
{
    double length = hypot(hypot(v[0], v[1]), v[2]);
    if (!(length > 0) || !isfinite(length)) return false;
    for (int i = 0; i < 3; i++) v[i] /= length;
    return true;
}

void cross3(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
