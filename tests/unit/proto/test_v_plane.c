/* The map onto the v-plane: its equations, its density, its ends. */
#include <math.h>

#include "proto/v_plane.h"
#include "tests/unit/unit.h"

#define PI 3.14159265358979323846

static void near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.12g is not %.12g within %g", a, b, tolerance);
}

static void direction(double u, double v, double d[3])
{
    float side, height, sine, cosine, out[3];
    v_plane_column((float)u, &side, &height);
    v_plane_row((float)v, &sine, &cosine);
    v_plane_direction(side, height, sine, cosine, out);
    for (int i = 0; i < 3; i++) d[i] = (double)out[i];
}

TEST(solves_its_equations)
{
    enum { N = 4096 };
    for (int i = 0; i <= N; i++) {
        const double x = fmin(fmax((double)i / N, 0x1p-24), 1 - 0x1p-24);
        float side, height, sine, cosine;
        v_plane_column((float)x, &side, &height);
        near((double)side, 2 * x - 1, 1e-7);
        near((double)height, sqrt(1 - (2 * x - 1) * (2 * x - 1)), 1e-7);
        v_plane_row((float)x, &sine, &cosine);
        near((double)sine * (double)sine + (double)cosine * (double)cosine, 1, 2e-7);
        const double theta = 2 * atan2((double)sine, (double)cosine);
        near(theta + sin(theta), PI * (2 * x - 1), 1e-6);
        assert_true(cosine > 0 && height > 0);
        /* relative, where the plane's coordinates grow */
        double rest = 2 * PI * fmin(x, 1 - x), e = PI - fabs(theta);
        if (rest < 0.01) near(e / cbrt(6 * rest), 1, 0.003);
    }
}

/* Many rows at once are rows one by one. */
TEST(rows_are_rows)
{
    enum { N = 37 };
    float v[N], sines[N], cosines[N];
    for (int i = 0; i < N; i++) v[i] = (float)i / (N - 1);
    v_plane_rows(v, N, sines, cosines);
    for (int i = 0; i < N; i++) {
        float sine, cosine;
        v_plane_row(v[i], &sine, &cosine);
        assert_true(sine == sines[i] && cosine == cosines[i]);
    }
}

/* Lines of one u are lines of one v1, whatever v. */
TEST(columns_are_straight)
{
    for (int i = 1; i < 32; i++)
        for (int j = 1; j < 32; j++) {
            double d[3], a = 2 * i / 32.0 - 1;
            direction(i / 32.0, j / 32.0, d);
            near(d[0] / d[2], a / sqrt(1 - a * a), 1e-5 * (1 + fabs(d[0] / d[2])));
        }
}

/* The area of the disc that a cell of the square covers is pi over the number of cells: directions
 * over which a unit disc is uniform are cosine-distributed. Corners by the map, edges along u are
 * chords, those along v are pieces of ellipses: fine cells, summed by the shoelace formula. */
TEST(density_is_the_cosine)
{
    enum { CELLS = 16, FINE = 64 };
    for (int cu = 0; cu < CELLS; cu++)
        for (int cv = 0; cv < CELLS; cv++) {
            double area = 0, last[3] = {0}, first[3] = {0};
            for (int k = 0; k <= 4 * FINE; k++) {
                const int edge = k / FINE % 4;
                const double t = (double)(k % FINE) / FINE;
                const double at[4][2] = {{t, 0}, {1, t}, {1 - t, 1}, {0, 1 - t}};
                double d[3];
                direction((cu + at[edge][0]) / CELLS, (cv + at[edge][1]) / CELLS, d);
                if (k == 0)
                    for (int c = 0; c < 3; c++) first[c] = d[c];
                else
                    area += 0.5 * (last[0] * d[1] - last[1] * d[0]);
                for (int c = 0; c < 3; c++) last[c] = d[c];
            }
            near(last[0], first[0], 1e-7);
            near(area * CELLS * CELLS / PI, 1,
                 cu == 0 || cu == CELLS - 1 || cv == 0 || cv == CELLS - 1 ? 0.02 : 2e-3);
        }
}

/* Moments of the cosine distribution: z, z^2, x^2, y^2 and the product. */
TEST(moments_are_the_cosines)
{
    enum { N = 512 };
    double z = 0, zz = 0, xx = 0, yy = 0, xy = 0, unit = 0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            double d[3];
            direction((i + 0.5) / N, (j + 0.5) / N, d);
            z += d[2], zz += d[2] * d[2], xx += d[0] * d[0], yy += d[1] * d[1];
            xy += d[0] * d[1];
            unit = fmax(unit, fabs(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1));
        }
    near(z / (N * N), 2.0 / 3, 1e-4);
    near(zz / (N * N), 0.5, 1e-4);
    near(xx / (N * N), 0.25, 1e-4);
    near(yy / (N * N), 0.25, 1e-4);
    near(xy / (N * N), 0, 1e-6);
    assert_true(unit < 4e-7);
}

TEST(ends_are_finite)
{
    static const double ends[] = {0, 0x1p-149, 0x1p-30, 1 - 0x1p-24, 1};
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++) {
            double d[3];
            direction(ends[i], ends[j], d);
            assert_true(d[2] > 0);
            assert_true(fabs(d[0] / d[2]) < 4096 && fabs(d[1] / d[2]) < 2097152);
            near(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 4e-7);
        }
}
