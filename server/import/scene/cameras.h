#pragma once
/* Frames of cameras, and the default camera of files without one. */
#include "server/import/scene/builder.h"
#include "server/import/scene/transform.h"

/* Sets eye and the orthonormal frame of a camera that looks along -z of a node with y up. The
 * node's scale and mirroring are ignored, as glTF asks. False when the axes are degenerate. */
bool camera_set_frame(struct scene_camera *camera, const struct affine *to_world);

/* Appends the default camera. It is in front of the scene (+z), slightly above, 45 degrees high,
 * where the bounding sphere just fits. Geometry must be in place. */
int camera_append_default(struct builder *b, struct fault *fault);
