#pragma once
/* Sizes of what was imported, for the report. */
#include <stdint.h>

struct import_stats {
    uint64_t triangles;           /* stored */
    uint64_t placed_triangles;    /* after instancing */
    uint32_t frames;              /* blobs beside the base; 0: the scene is one blob */
    uint32_t width_px, height_px; /* of an environment map; 0: it is a scene */
};
