#pragma once
/* What a sequence's frame puts into a scene: surfaces, a camera and the name of a backplate. */
#include "server/import/rgbd/rgbd_document.h"
#include "server/import/scene/mesh.h"

/* Appends what does not shine and what does, each as a mesh of its own if there is any, of a
 * material of their own. They are not placed. */
int rgbd_append_mesh(const struct mesh *mesh, uint32_t first_shining, struct builder *b,
                     struct fault *fault);

/* Appends that material; *name is the material's and the meshes'. */
int rgbd_append_material(struct builder *b, uint32_t *name, struct fault *fault);

/* Places the meshes first .. end - 1 that rgbd_append_mesh has left, moved by `by`. What does not
 * shine is a catcher; what shines in the photograph itself is a holdout. */
int rgbd_place_parts(struct builder *b, uint64_t first, uint64_t end, bool all_shine,
                     const double by[3], struct fault *fault);

/* Finds where a frame's camera stands in the scene, where `place` puts the sequence's world. */
struct affine rgbd_camera_in(const struct rgbd_document *d, uint32_t frame,
                             const struct affine *place, const double origin[3]);

/* Makes the scene's camera of one of the document's that `to_scene` puts into it; the size is of
 * its images. */
int rgbd_append_camera(const struct rgbd_document *d, int32_t width, int32_t height,
                       const struct affine *to_scene, struct builder *b, struct fault *fault);

/* Names a frame's colour image as the backplate. */
int rgbd_set_plate(const struct rgbd_document *d, uint32_t frame, struct builder *b,
                   struct fault *fault);

/* Finds the frame at a time of the scene. ERR_NOT_FOUND after the last. */
int rgbd_find_frame(const struct rgbd_document *d, double time_s, uint32_t *frame,
                    struct fault *fault);
