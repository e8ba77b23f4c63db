#include "server/image/view_transform.h"

#include <math.h>

/* The exposure beyond which a float's range ends. */
#define EXPOSURE_MAX 126.0

/* Beyond this a curve has long reached 1, and squares are still finite. */
#define LIGHT_MAX 1e9

/* log2 of the least and the largest light that AgX tells apart: 10 stops below middle grey and 6.5
 * above it. */
#define AGX_LEAST_EV (-12.47393)
#define AGX_MOST_EV  4.026069

static const double rec2020_of_709[3][3] = {
    {0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0113}, {0.0164, 0.0880, 0.8956}};
static const double rec709_of_2020[3][3] = {
    {1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}};
static const double agx_inset[3][3] = {{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                                       {0.137318972929847, 0.761241990602591, 0.101439036467562},
                                       {0.11189821299995, 0.0767994186031903, 0.811302368396859}};
static const double agx_outset[3][3] = {
    {1.1271005818144368, -0.11060664309660323, -0.016493938717834573},
    {-0.1413297634984383, 1.157823702216272, -0.016493938717834257},
    {-0.14132976349843826, -0.11060664309660294, 1.2519364065950405}};

static double clip(double v, double most)
{
    return v > 0.0 ? (v < most ? v : most) : 0.0; /* NaN, too */
}

static void turn(const double matrix[3][3], double v[3])
{
    const double in[3] = {v[0], v[1], v[2]};
    for (int r = 0; r < 3; r++)
        v[r] = matrix[r][0] * in[0] + matrix[r][1] * in[1] + matrix[r][2] * in[2];
}

static double filmic(double v)
{
    const double x = 0.6 * v;
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

static double agx_sigmoid(double v)
{
    const double range = AGX_MOST_EV - AGX_LEAST_EV;
    const double x = clip((log2(v > 1e-10 ? v : 1e-10) - AGX_LEAST_EV) / range, 1.0);
    return (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x -
           0.00232;
}

static void agx(double v[3])
{
    turn(rec2020_of_709, v);
    turn(agx_inset, v);
    for (int c = 0; c < 3; c++) v[c] = agx_sigmoid(v[c]);
    turn(agx_outset, v);
    for (int c = 0; c < 3; c++) v[c] = v[c] > 0.0 ? pow(v[c], 2.2) : 0.0;
    turn(rec709_of_2020, v);
}

struct view_transform view_transform_of(enum view_curve curve, double exposure_ev)
{
    const double stops = isnan(exposure_ev) ? 0 : exposure_ev;
    return (struct view_transform){.curve = curve,
                                   .scale = exp2(fmin(fmax(stops, -EXPOSURE_MAX), EXPOSURE_MAX))};
}

void view_transform_apply(const struct view_transform *view, const double light[3], double shown[3])
{
    double v[3];
    for (int c = 0; c < 3; c++) v[c] = clip(light[c] * view->scale, LIGHT_MAX);
    if (view->curve == VIEW_AGX) agx(v);
    for (int c = 0; c < 3; c++)
        shown[c] = clip(view->curve == VIEW_FILMIC ? filmic(v[c]) : v[c], 1);
}
