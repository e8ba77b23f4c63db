#pragma once
/* One model of the place that a sequence shows, of the depth of all its frames. */
#include "server/import/rgbd/rgbd_document.h"
#include "server/import/scene/mesh.h"
#include "server/import/scene/warnings.h"

struct rgbd_fused {
    struct mesh mesh;       /* owned; metres from origin */
    uint32_t first_shining; /* from this triangle on they shine themselves */
    double origin[3];       /* in the sequence's world */
    int32_t width, height;  /* of the frames' images */
};

/* Makes the model of at most LIMIT_FUSION_FRAMES frames, evenly chosen. Voxels are as large as half
 * a pixel of the first frame, or as its noise, at its median depth; or larger, so that the volume
 * has room for all. Faults name the frame's members as depth_map_read does, ERR_MISMATCH among them
 * for frames of other sizes; ERR_LIMIT at /rgbd/poses/file where cameras are too far apart for any
 * voxel, ERR_MISSING at /rgbd/frames where there is no surface. */
int rgbd_fuse(const struct rgbd_document *d, struct files *files, struct rgbd_fused *out,
              struct warnings *warnings, struct fault *fault);
