#pragma once
/* The light of white in a frame: an estimate of the light that knows its colour, not where it
 * falls. It makes albedo of colours, and tells what shines itself. */
#include <stdbool.h>

#include "server/import/rgbd/depth_map.h"

/* Finds what few pixels of a frame are brighter than, by colour; or takes the document's, which is
 * what reflects 0.8 of the light. Colours are not negative. */
void white_find(const struct depth_map *map, const struct rgbd_document *d, float white[3]);

/* Returns the albedo of a surface of that colour, by one of its channels. */
float white_albedo(float color, float white);

/* Returns whether a pixel is so bright that it must shine itself. */
bool white_is_outshone(const float white[3], const float color[3]);
