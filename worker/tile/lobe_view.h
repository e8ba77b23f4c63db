#pragma once
/* Finds which pixels of a tile may show surfaces with other lobes than a diffuse one, by where the
 * boxes around these (worker/scene/lobe_boxes.h) lie on the screen. A pixel that shows such a
 * surface is always found, others may be. */
#include "proto/plan.h"
#include "proto/tile.h"
#include "worker/scene/lobe_boxes.h"

struct lobe_view {
    uint32_t count;
    struct rect rect[LOBE_BOXES_MAX]; /* those that meet the tile */
};

void lobe_view_init(const struct lobe_boxes *boxes, const struct plan *plan, struct rect tile,
                    struct lobe_view *out);

/* Returns whether pixels of the rectangle may show one. */
bool lobe_view_meets(const struct lobe_view *view, struct rect pixels);
