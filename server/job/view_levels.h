#pragma once
/* The pictures that a live job makes of one view: first small ones of few samples, so that there is
 * something to see at once, at last the one that its document asks for. Pure functions. */
#include "proto/job/job.h"

#define VIEW_LEVELS_MOST 3

/* Pixels that the first picture has at most: what two cores trace within some 50 ms. */
#define VIEW_FIRST_PIXELS 16384
/* Samples a pixel of every picture but the last. */
#define VIEW_COARSE_SPP 4
/* Sides of their tiles: a small picture must have work for every thread. */
#define VIEW_COARSE_TILE_PX 32

/* How many pictures: 1 for an image that is small itself. */
unsigned view_levels(const struct job *job);

/* Pixels of the full picture that one of this level's covers, along each axis: a power of two; 1 at
 * the last level, and nowhere else. */
int32_t view_level_scale(const struct job *job, unsigned level);

/* The document of a level: at the last the job's own. What it points to stays the job's. Its
 * picture shows all that the full one does, stretched to whole pixels: it takes the full plan's
 * camera. */
void view_level_document(const struct job *job, unsigned level, struct job *out);
