#pragma once
/* Composes virtual objects with a photograph, from the three views of a picture (enum plan_view).
 * All functions of bits that are the same give the same bits, so that where no ray of a pixel, and
 * of those that its filters read, came upon an object, the factor is exactly 1 and the photograph
 * keeps its bits. docs/mixed-reality.md, What is computed. */
#include "proto/tile.h"
#include "server/image/image.h"

struct catcher_views {
    const struct image *with,
        *without;              /* R, G, B of catchers and A, how much of a pixel they are */
    const struct image *plate; /* R, G, B; NULL: none */
    bool adds;                 /* differences are added; else ratios multiply */
};

/* Fills the channels of composite, catcher, overlay and backplate that `picture` has, in a
 * rectangle of pixels, from its R, G, B, A of the objects and from the views.
 *
 * - ratio: with / without; 1 where both are the same and where there is nothing to compare
 * - catcher: 1 + share (ratio - 1), or with - without where differences are added; the share is the
 *   catcher's of the pixel, or less where the plate is so bright that something else must be
 * - composite: objects + (1 - alpha) plate catcher, or objects + (1 - alpha) (plate + catcher)
 * - R, G, B: nothing where alpha is 0, whatever filters have let spill there
 * - overlay: the objects, and as alpha 1 - (1 - alpha) m: m is the mean over channels of the
 *   catcher's factor, at most 1
 * - backplate: the plate */
void catcher_compose(const struct catcher_views *views, struct rect rect, struct image *picture);
