#include "worker/shade/lambert.h"

void lambert_sample(const float u[LANES], const float v[LANES], struct lanes3 *local)
{
    for (int i = 0; i < LANES; i++)
        lambert_direction(u[i], v[i], &local->x[i], &local->y[i], &local->z[i]);
}
