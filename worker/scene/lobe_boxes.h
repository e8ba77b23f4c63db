#pragma once
/* Boxes around the instances whose material has other lobes than a diffuse one. Pixels that show
 * none of them need no path beside light fields. */
#include "proto/scene/scene.h"

struct mesh_view;

enum { LOBE_BOXES_MAX = 256 };

struct lobe_box {
    float low[3], high[3]; /* of the world, or of a mesh's own coordinates */
};

struct lobe_boxes {
    uint32_t count;
    struct lobe_box box[LOBE_BOXES_MAX];
};

/* Finds the boxes. Where instances are too many, some that follow each other share one. `meshes`
 * are those of the blob, `of_base` the boxes of its base's; NULL: it has none. ERR_MEMORY. */
int lobe_boxes_create(const struct scene *blob, const struct mesh_view *meshes,
                      const struct lobe_box *of_base, struct lobe_boxes **out);

/* Finds the box that encloses a mesh. */
void lobe_box_of_mesh(const struct mesh_view *mesh, struct lobe_box *out);
void lobe_boxes_destroy(struct lobe_boxes **boxes);
