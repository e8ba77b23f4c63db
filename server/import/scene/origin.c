#include "server/import/scene/origin.h"

#include <math.h>
#include <string.h>

/* What lies further away than so many of its own radii is moved: its floats have lost six bits. */
#define FAR_RADII 64.0

/* Vertices are warned of when a step of their floats is more than a 1/8192 of their radius. */
#define COARSE_STEP 0x1p-13

static double measure(const double lowest[3], const double highest[3], double centre[3])
{
    double half[3];
    for (int i = 0; i < 3; i++) {
        centre[i] = (lowest[i] + highest[i]) / 2;
        half[i] = (highest[i] - lowest[i]) / 2;
    }
    return sqrt(dot3(half, half));
}

static double farthest(const double v[3])
{
    return fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
}

bool origin_choose(const double lowest[3], const double highest[3], double origin[3])
{
    double centre[3];
    const double radius = measure(lowest, highest, centre), away = farthest(centre);
    memset(origin, 0, 3 * sizeof origin[0]);
    if (!(radius > 0) || !(away > FAR_RADII * radius) || !(away <= (double)LIMIT_COORDINATE))
        return false;
    const double step = exp2(ceil(log2(radius)));
    for (int i = 0; i < 3; i++) origin[i] = step * round(centre[i] / step);
    return true;
}

static void include(const float *positions, uint64_t count, double lowest[3], double highest[3])
{
    for (int c = 0; c < 3; c++) lowest[c] = INFINITY, highest[c] = -INFINITY;
    for (uint64_t v = 0; v < count; v++) {
        for (uint64_t c = 0; c < 3; c++) {
            lowest[c] = fmin(lowest[c], (double)positions[3 * v + c]);
            highest[c] = fmax(highest[c], (double)positions[3 * v + c]);
        }
    }
}

/* Moves vertices to the middle of their own box. */
static void move(float *positions, uint64_t count, const char *place, struct warnings *warnings,
                 double origin[3])
{
    double lowest[3], highest[3], centre[3];
    include(positions, count, lowest, highest);
    if (!origin_choose(lowest, highest, origin)) return;
    const double step = exp2(floor(log2(farthest(origin))) - 23);
    if (step > COARSE_STEP * measure(lowest, highest, centre))
        warnings_add(
            warnings, place,
            "its vertices are written so far from their origin that they are exact to %.1g "
            "units only",
            step);
    for (uint64_t v = 0; v < count; v++)
        for (uint64_t c = 0; c < 3; c++)
            positions[3 * v + c] = (float)((double)positions[3 * v + c] - origin[c]);
}

void origin_move_mesh(struct mesh *mesh, const char *place, struct warnings *warnings,
                      double origin[3])
{
    move(mesh->positions, mesh->vertex_count, place, warnings, origin);
}

void origin_move_scene(struct builder *b, const char *place)
{
    move(builder_positions(b), builder_count(b, SCENE_POSITIONS), place, &b->warnings, b->origin);
}
