#pragma once
/* The levels of a live job's view: first small pictures with few samples, so that something is seen
 * at once, last the one that its document asks for. Pure functions. */
#include "proto/job/job.h"

#define VIEW_LEVELS_MAX 3

/* The most pixels of the first picture, which two cores trace within some 50 ms. */
#define VIEW_FIRST_PIXELS 16384
/* Samples a pixel of all pictures but the last. */
#define VIEW_COARSE_SPP 4
/* Tile side of these pictures, so that a small one has work for every thread. */
#define VIEW_COARSE_TILE_PX 32

/* Returns the number of levels: 1 for an image that is small itself. */
unsigned view_levels(const struct job *job);

/* Returns how many pixels of the full picture one pixel of this level covers along each axis: a
 * power of two, 1 at the last level only. */
int32_t view_level_scale(const struct job *job, unsigned level);

/* Writes the document of a level; the last is the job's own. What it points to stays the job's.
 * Each level shows all that the full picture does, stretched to whole pixels, since it takes the
 * full plan's camera. */
void view_level_document(const struct job *job, unsigned level, struct job *out);
