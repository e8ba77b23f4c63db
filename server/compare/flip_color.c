#include "server/compare/flip_color.h"

#include <math.h>

static const double white[3] = {0.950428545, 1, 1.088900371};

static const double to_xyz[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

/* Its inverse. */
static const double from_xyz[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                      {-0.969224334, 1.875930071, 0.041554224},
                                      {0.055639423, -0.204011202, 1.057148933}};

static void multiply(const double m[3][3], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

void flip_color_opponent(const double encoded[3], double out[3])
{
    double linear[3], xyz[3];
    for (int c = 0; c < 3; c++)
        linear[c] =
            encoded[c] <= 0.04045 ? encoded[c] / 12.92 : pow((encoded[c] + 0.055) / 1.055, 2.4);
    multiply(to_xyz, linear, xyz);
    for (int c = 0; c < 3; c++) xyz[c] /= white[c];
    out[0] = 116 * xyz[1] - 16;
    out[1] = 500 * (xyz[0] - xyz[1]);
    out[2] = 200 * (xyz[1] - xyz[2]);
}

static double lightness(double v)
{
    const double delta = 6.0 / 29;
    return v > delta * delta * delta ? cbrt(v) : v / (3 * delta * delta) + 4.0 / 29;
}

static void hunt_of_linear(const double linear[3], double out[3])
{
    double xyz[3];
    multiply(to_xyz, linear, xyz);
    for (int c = 0; c < 3; c++) xyz[c] = lightness(xyz[c] / white[c]);
    out[0] = 116 * xyz[1] - 16;
    out[1] = 0.01 * out[0] * 500 * (xyz[0] - xyz[1]);
    out[2] = 0.01 * out[0] * 200 * (xyz[1] - xyz[2]);
}

void flip_color_hunt(const double opponent[3], double out[3])
{
    const double y = (opponent[0] + 16) / 116;
    const double xyz[3] = {(y + opponent[1] / 500) * white[0], y,
                           (y - opponent[2] / 200) * white[2]};
    double linear[3];
    multiply(from_xyz, xyz, linear);
    for (int c = 0; c < 3; c++) linear[c] = fmin(fmax(linear[c], 0), 1);
    hunt_of_linear(linear, out);
}

double flip_color_distance(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

double flip_color_largest(void)
{
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double a[3], b[3];
    hunt_of_linear(green, a);
    hunt_of_linear(blue, b);
    return flip_color_distance(a, b);
}
