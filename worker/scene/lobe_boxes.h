#pragma once
/* Boxes around some instances. Those whose material has other lobes than a diffuse one: pixels that
 * show none of them need no path beside light fields. And virtual ones: pixels that show none of
 * them are nothing in a photograph's view of objects. */
#include "proto/scene/scene.h"

struct mesh_view;

enum { LOBE_BOXES_MAX = 256 };
enum lobe_boxes_of { BOXES_OF_LOBES, BOXES_OF_VIRTUAL };

struct lobe_box {
    float low[3], high[3]; /* of the world, or of a mesh's own coordinates */
};

struct lobe_boxes {
    uint32_t count;
    struct lobe_box box[LOBE_BOXES_MAX];
};

/* Finds the boxes of a kind. Where instances are too many, some that follow each other share one.
 * `meshes` are those of the blob, `of_base` the boxes of its base's; NULL: it has none. *out is
 * NULL where all is virtual, and so not asked for. ERR_MEMORY. */
int lobe_boxes_create(enum lobe_boxes_of kind, const struct scene *blob,
                      const struct mesh_view *meshes, const struct lobe_box *of_base,
                      struct lobe_boxes **out);

/* Finds the box that encloses a mesh. */
void lobe_box_of_mesh(const struct mesh_view *mesh, struct lobe_box *out);
void lobe_boxes_destroy(struct lobe_boxes **boxes);
