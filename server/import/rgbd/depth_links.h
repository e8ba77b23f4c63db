#pragma once
/* Which pixels beside each other show one surface, and how it slopes there. */
#include "server/import/rgbd/depth_map.h"

/* What a pixel shares: DEPTH_LINK_RIGHT, the one to the right shows the same surface. */
enum { DEPTH_LINK_RIGHT = 1, DEPTH_LINK_DOWN = 2 };

struct depth_links {
    const struct depth_map *map; /* borrowed */
    uint8_t *of;                 /* owned; a pixel */
};

/* Two pixels show one surface if they are about as far, or if one of them is where the other's
 * slope leads. ERR_MEMORY. */
int depth_links_find(const struct depth_map *map, struct depth_links *out);
void depth_links_fini(struct depth_links *links);

/* Returns whether a pixel has a link; false outside. */
bool depth_links_has(const struct depth_links *links, int32_t x, int32_t y, uint8_t link);

/* Returns 1/z of a pixel; 0 outside and where there is none. */
float depth_links_inverse(const struct depth_links *links, int32_t x, int32_t y);

/* Returns the slope of 1/z a pixel along an axis, by up to reach_px linked pixels on each side, and
 * least squares; 0 without any. */
float depth_links_slope(const struct depth_links *links, int32_t x, int32_t y, uint8_t axis,
                        int32_t reach_px);
