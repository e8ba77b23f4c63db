#include "tests/golden/analytic_formula.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

double formula_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void formula_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

void formula_normalise(double v[3])
{
    double length = sqrt(formula_dot(v, v));
    for (int i = 0; i < 3; i++) v[i] /= length;
}

/* Sutherland and Hodgman's cut of a polygon, relative to the point, by normal . x >= 0. */
static int cut_at_horizon(double in[][3], int count, const double normal[3], double out[][3])
{
    int n = 0;
    for (int i = 0; i < count; i++) {
        const double *a = in[i], *b = in[(i + 1) % count];
        double ha = formula_dot(a, normal), hb = formula_dot(b, normal);
        if (ha >= 0) memcpy(out[n++], a, sizeof out[0]);
        if ((ha >= 0) == (hb >= 0)) continue;
        for (int k = 0; k < 3; k++) out[n][k] = a[k] + (b[k] - a[k]) * ha / (ha - hb);
        n++;
    }
    return n;
}

double formula_rectangle(const double c[3], const double u[3], const double v[3],
                         const double point[3], const double normal[3])
{
    static const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    double polygon[4][3], cut[8][3], front[3], away[3], sum = 0;
    for (int k = 0; k < 3; k++) away[k] = point[k] - c[k];
    formula_cross(u, v, front);
    if (formula_dot(front, away) <= 0) return 0;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            polygon[i][k] = c[k] + corner[i][0] * u[k] + corner[i][1] * v[k] - point[k];
    int count = cut_at_horizon(polygon, 4, normal, cut);
    for (int i = 0; i < count; i++) {
        double a[3], b[3], edge[3];
        memcpy(a, cut[i], sizeof a);
        memcpy(b, cut[(i + 1) % count], sizeof b);
        formula_normalise(a);
        formula_normalise(b);
        formula_cross(a, b, edge);
        double sine = sqrt(formula_dot(edge, edge));
        if (sine > 0) sum += atan2(sine, formula_dot(a, b)) * formula_dot(edge, normal) / sine;
    }
    return fabs(sum) / 2;
}

double formula_gaussian_rectangle(const double c[3], const double u[3], const double v[3],
                                  const double point[3], const double normal[3])
{
    enum { STEPS = 400 };
    double front[3], sum = 0;
    formula_cross(u, v, front);
    double area = 4 * sqrt(formula_dot(front, front));
    formula_normalise(front);
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            double a = (2.0 * i + 1) / STEPS - 1, b = (2.0 * j + 1) / STEPS - 1, w[3];
            for (int k = 0; k < 3; k++) w[k] = c[k] + a * u[k] + b * v[k] - point[k];
            double d2 = formula_dot(w, w);
            sum += exp(-2 * (a * a + b * b)) * formula_dot(w, normal) * -formula_dot(w, front) /
                   (d2 * d2);
        }
    return sum * area / (STEPS * STEPS);
}

/* Cosine-weighted directions are uniform over the unit disc of their horizontal parts: blocked is
 * the segment beyond the chord distance/reach. */
double formula_corner_openness(double distance, double reach)
{
    double s = distance / reach;
    if (s >= 1) return 1;
    return 1 - (acos(s) - s * sqrt(1 - s * s)) / PI;
}

static double ggx_lambda(const double w[3], double alpha)
{
    double tangent2 = (1 - w[2] * w[2]) / (w[2] * w[2]);
    return (sqrt(1 + alpha * alpha * tangent2) - 1) / 2;
}

/* The mean over half vectors distributed as D(h) cos(h) of G (wo.h) / (cos_o cos_h). */
double formula_ggx_albedo(double cos_o, double alpha)
{
    enum { RINGS = 2000, SECTORS = 400 };
    const double wo[3] = {sqrt(1 - cos_o * cos_o), 0, cos_o};
    double sum = 0;
    for (int i = 0; i < RINGS; i++) {
        double u = (i + 0.5) / RINGS, tangent2 = alpha * alpha * u / (1 - u);
        double z = 1 / sqrt(1 + tangent2), r = sqrt(1 - z * z);
        for (int j = 0; j < SECTORS; j++) {
            double phi = 2 * PI * (j + 0.5) / SECTORS;
            double h[3] = {r * cos(phi), r * sin(phi), z}, wi[3], oh = formula_dot(wo, h);
            for (int k = 0; k < 3; k++) wi[k] = 2 * oh * h[k] - wo[k];
            if (oh <= 0 || wi[2] <= 0) continue;
            double g = 1 / (1 + ggx_lambda(wo, alpha) + ggx_lambda(wi, alpha));
            sum += g * oh / (cos_o * z);
        }
    }
    return sum / (RINGS * SECTORS);
}

double formula_schlick(double f0, double cosine)
{
    return f0 + (1 - f0) * pow(1 - cosine, 5);
}

double formula_slab(double f, double t)
{
    double inner = 1 - f * f * t * t;
    double reflected = f + (1 - f) * (1 - f) * f * t * t / inner;
    double transmitted = (1 - f) * (1 - f) * t / inner;
    return reflected + transmitted;
}
