#pragma once
/* Affine transforms in double precision: node hierarchies multiply many of them, and only the
 * product is rounded to float. */
#include <stdbool.h>

struct affine {
    double m[12]; /* 3 rows of 4: x' = R x + t */
};

struct affine affine_identity(void);

/* x' = a (b x). */
struct affine affine_multiply(const struct affine *a, const struct affine *b);

/* Translation * rotation * scale; `rotation` is a unit quaternion x, y, z, w. */
struct affine affine_from_trs(const double translation[3], const double rotation[4],
                              const double scale[3]);

/* From 16 numbers by columns, as glTF writes them. False when the last row is not 0 0 0 1. */
bool affine_from_columns(const double columns[16], struct affine *out);

/* a * diag(-1, 1, 1): undoes a mirroring of x in the geometry. */
struct affine affine_mirrored(const struct affine *a);

void affine_point(const struct affine *a, const float in[3], float out[3]);

/* Directions along a surface: R d, not normalised. */
void affine_direction(const struct affine *a, const double in[3], double out[3]);

/* Surface normals: the cofactor matrix of R times n, not normalised. Needs no inverse, so that it
 * also holds for a transform that flattens; points to the back when R mirrors. */
void affine_normal(const struct affine *a, const double in[3], double out[3]);

double affine_determinant(const struct affine *a);

/* True when R flattens space, judged relative to the lengths of its columns. */
bool affine_is_singular(const struct affine *a);

bool affine_is_finite(const struct affine *a);
bool affine_is_identity(const struct affine *a);

/* Scales v to length 1. False, and v untouched, when its length is zero or not finite. */
bool normalize3(double v[3]);
void cross3(const double a[3], const double b[3], double out[3]);
double dot3(const double a[3], const double b[3]);
