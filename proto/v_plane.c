#include "proto/v_plane.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define PI 3.14159265358979323846

static double within_ends(float x)
{
    const float most = 1.0f - V_PLANE_END, low = x > V_PLANE_END ? x : V_PLANE_END;
    return (double)(low < most ? low : most);
}

void v_plane_column(float u, float *side, float *height)
{
    const double x = within_ends(u);
    *side = (float)(2.0 * x - 1.0);
    *height = (float)(2.0 * sqrt(x * (1.0 - x)));
}

/* Sine and cosine on [0, pi/2]: Taylor series around 0 of at most half of it, doubled. */
static void sincos_quarter(double x, double *sine, double *cosine)
{
    const double h = 0.5 * x, s = h * h;
    const double sin_h =
        h *
        (1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110 * (1 - s / 156))))));
    const double cos_h =
        1 - s / 2 * (1 - s / 12 * (1 - s / 30 * (1 - s / 56 * (1 - s / 90 * (1 - s / 132)))));
    *sine = 2.0 * sin_h * cos_h;
    *cosine = cos_h * cos_h - sin_h * sin_h;
}

/* e - sin e on [0, pi], with its digits near 0. */
static double lag(double e)
{
    const double s = e * e;
    double sum = 1.0;
    for (int k = 22; k >= 4; k -= 2) sum = 1.0 - s / (double)(k * (k + 1)) * sum;
    return e * s / 6.0 * sum;
}

/* The cube root of a normal number: a third of its exponent, then Newton's steps, each of which
 * doubles the five bits or so that are right. */
static double cube_root(double x)
{
    uint64_t bits;
    double r;
    memcpy(&bits, &x, sizeof bits);
    bits = bits / 3 + UINT64_C(0x2a9f7893782da1ce);
    memcpy(&r, &bits, sizeof r);
    for (int i = 0; i < 4; i++) r += (x / (r * r) - r) / 3.0;
    return r;
}

/* e of e - sin e = q for q in (0, pi]: Kepler's equation at eccentricity 1, which is 6q = e^3 near
 * 0. The series in that cube root is right to 0.034 at worst, and three of Newton's steps to
 * 1e-15. */
static double solve(double q)
{
    const double r = cube_root(6.0 * q), s = r * r;
    double e = r * (1.0 + s * (1.0 / 60 + s * (1.0 / 1400 + s / 25200)));
    for (int i = 0; i < 3; i++) {
        double sine, cosine;
        sincos_quarter(0.5 * e, &sine, &cosine);
        e -= (lag(e) - q) / (2.0 * sine * sine); /* 1 - cos e; q keeps e from 0 */
    }
    return e;
}

/* theta = +-(pi - e): what theta lacks to the end is small where its equation is flat. */
void v_plane_row(float v, float *sine, float *cosine)
{
    const double x = within_ends(v), rest = x < 0.5 ? x : 1.0 - x;
    double s, c;
    sincos_quarter(0.5 * solve(2.0 * PI * rest), &s, &c);
    *sine = (float)(x < 0.5 ? -c : c);
    *cosine = (float)s;
}
