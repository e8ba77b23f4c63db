#include "server/job/prepare/studio_light.h"

#include <math.h>
#include <stdlib.h>

#include "server/job/prepare/made_map.h"

/* A soft box: its middle and half sides in the map, as shares of its width and height. */
struct soft_box {
    double u, v, half_u, half_v, soft; /* soft: width of the edge, as a share of the height */
    double radiance;
};

/* Azimuths count from the default camera, which stands at u = 2/3: the key 45 degrees to its left,
 * the fill 60 to its right, the rim behind; and a box above. */
static const struct soft_box boxes[] = {
    {0.792, 0.26, 0.085, 0.11, 0.06, 3.2},
    {0.500, 0.32, 0.070, 0.14, 0.08, 1.3},
    {0.083, 0.28, 0.030, 0.16, 0.05, 3.0},
    {0.667, 0.03, 0.500, 0.05, 0.06, 0.3},
};

/* The room: dark below, brighter to the top. */
#define FLOOR   0.22
#define HORIZON 0.42
#define CEILING 0.55

static double smooth_step(double x)
{
    const double t = x < 0 ? 0 : x > 1 ? 1 : x;
    return t * t * (3 - 2 * t);
}

/* Returns 1 within a box, 0 outside; across the map's left edge, too. */
static double cover(const struct soft_box *b, double u, double v)
{
    double across = fabs(u - b->u);
    if (across > 0.5) across = 1 - across;
    const double du = 2 * (across - b->half_u), dv = fabs(v - b->v) - b->half_v;
    return smooth_step(0.5 - du / b->soft) * smooth_step(0.5 - dv / b->soft);
}

static double radiance(double u, double v)
{
    double sum = FLOOR + (HORIZON - FLOOR) * smooth_step((0.62 - v) / 0.24) +
                 (CEILING - HORIZON) * smooth_step((0.5 - v) / 0.5);
    for (size_t i = 0; i < sizeof boxes / sizeof boxes[0]; i++)
        sum += boxes[i].radiance * cover(&boxes[i], u, v);
    return sum;
}

void studio_light_draw(float *texels)
{
    for (uint32_t y = 0; y < STUDIO_HEIGHT_PX; y++)
        for (uint32_t x = 0; x < STUDIO_WIDTH_PX; x++) {
            const double u = (x + 0.5) / STUDIO_WIDTH_PX, v = (y + 0.5) / STUDIO_HEIGHT_PX;
            float *texel = texels + 3 * ((size_t)y * STUDIO_WIDTH_PX + x);
            texel[0] = texel[1] = texel[2] = (float)radiance(u, v);
        }
}

int studio_light_place(const struct objects *objects, struct environment_header *header,
                       struct digest *blob, struct fault *fault)
{
    const size_t texel_bytes = 3 * sizeof(float) * STUDIO_WIDTH_PX * STUDIO_HEIGHT_PX;
    float *texels = malloc(texel_bytes);
    if (!texels) return fault_set(fault, ERR_MEMORY, "", "no memory for the studio light");
    studio_light_draw(texels);
    const int error =
        made_map_place(objects, STUDIO_WIDTH_PX, STUDIO_HEIGHT_PX, texels, header, blob, fault);
    free(texels);
    return error;
}
