#pragma once
/* Affine transforms in double precision. Node hierarchies multiply many of them, and only the
 * product is rounded to float. */
#include <stdbool.h>

struct affine {
    double m[12]; /* 3 rows of 4: x' = R x + t */
};

struct affine affine_identity(void);
struct affine affine_translation(const double by[3]);

/* Returns the transform x' = a (b x). */
struct affine affine_multiply(const struct affine *a, const struct affine *b);

/* Returns translation * rotation * scale. `rotation` is a unit quaternion x, y, z, w. */
struct affine affine_from_trs(const double translation[3], const double rotation[4],
                              const double scale[3]);

/* Reads 16 numbers by columns, as glTF writes them. Returns false if the last row is not 0 0 0 1.
 */
bool affine_from_columns(const double columns[16], struct affine *out);

/* Returns a * diag(-1, 1, 1), which undoes a mirroring of x in the geometry. */
struct affine affine_mirrored(const struct affine *a);

void affine_point(const struct affine *a, const float in[3], float out[3]);

/* Transforms a direction along a surface to R d, not normalised. */
void affine_direction(const struct affine *a, const double in[3], double out[3]);

/* Transforms a surface normal by the cofactor matrix of R, not normalised. That needs no inverse,
 * so a transform may flatten. The result points to the back if R mirrors. */
void affine_normal(const struct affine *a, const double in[3], double out[3]);

double affine_determinant(const struct affine *a);

/* Returns whether R flattens space, relative to the lengths of its columns. */
bool affine_is_singular(const struct affine *a);

bool affine_is_finite(const struct affine *a);
bool affine_is_identity(const struct affine *a);

/* Scales v to length 1. Returns false, and leaves v, if its length is zero or not finite. */
bool normalize3(double v[3]);
void cross3(const double a[3], const double b[3], double out[3]);
double dot3(const double a[3], const double b[3]);
