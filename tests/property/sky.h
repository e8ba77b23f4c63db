#pragma once
/* A case's environment map: some texels, one of which is a sun, drawn from a seed. */
#include "proto/scene/environment.h"
#include "tests/property/picture.h"

/* Has the case a map under the change? */
bool sky_has_map(const struct property_case *c, const struct change *change);
/* The map; its blob is for free(). Ends the program without memory. */
void sky_build(const struct property_case *c, const struct change *change,
               struct environment_blob *out);
/* How far the job turns it, in degrees. */
double sky_rotation_deg(const struct change *change);
