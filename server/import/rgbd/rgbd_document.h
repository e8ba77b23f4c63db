#pragma once
/* The document of a sequence of colour and depth images:
 *
 *   camera    {fx, fy, cx, cy}: pixels, the centre of the first one being 0, 0
 *   depth     {scale, near, far}: numbers of a metre, 1000 by default; metres, 0.1 and 30 by
 * default frames    [{color, depth, time_s}]: names of files beside the document; time_s is
 * optional poses     {file, format}: "tum" or "matrices"; cameras to the sequence's world fps
 * frames a second, 24 by default: the scene's time tells the frame fuse      frames on each side
 * whose depth a frame uses, 2 by default white     [r, g, b], linear: what reflects 0.8 of the
 * light; by default each colour's value that a twentieth of the frame is brighter than. What is
 * twice as bright shines itself place     {frame, pixel, turn_deg, scale}: the scene's origin is
 * what the pixel shows, y away from the surface and z towards the camera, turned about y; scale
 * units are a metre to_scene  instead of place: 16 numbers by rows, from the sequence's world to
 * the scene's
 *
 * Cameras look along z, with x to the right and y down, as OpenCV's. Faults have pointers that
 * begin with /rgbd. */
#include "proto/json.h"
#include "server/import/fence/files.h"
#include "server/import/scene/transform.h"

struct rgbd_frame {
    const char *color, *depth; /* borrowed from the JSON */
    double time_s;
    bool has_time;
    struct affine pose; /* camera to world */
};

struct rgbd_place {
    uint32_t frame; /* from 1; 0: there is none */
    double pixel[2];
    double turn_deg, scale;
};

struct rgbd_document {
    json_t *json; /* owned */
    const char *name;
    double fx, fy, cx, cy;
    double scale, near_m, far_m;
    const char *poses; /* borrowed from the JSON */
    uint32_t pose_format;
    struct rgbd_frame *frames; /* owned */
    uint32_t frame_count;
    double fps;
    float white[3]; /* 0: to be found */
    uint32_t fuse;
    struct rgbd_place place;
    struct affine to_scene;
    bool has_to_scene;
};

enum rgbd_pose_format { RGBD_POSES_TUM, RGBD_POSES_MATRICES };

/* Reads and checks the document `name` and its poses. rgbd_document_close frees it, in both cases.
 */
int rgbd_document_open(struct rgbd_document *d, struct files *files, const char *name,
                       struct fault *fault);
void rgbd_document_close(struct rgbd_document *d);

/* Opens a file that the document names at `place`. */
int rgbd_file_map(const struct rgbd_document *d, struct files *files, const char *name,
                  const char *place, struct file_view *out, struct fault *fault);

/* Reads poses, one for each frame: by their order, or where frames have times, by those.
 * ERR_TRUNCATED for a list that ends early, ERR_RANGE for what is no rotation. */
int rgbd_poses_read(const struct file_view *file, struct rgbd_document *d, struct fault *fault);

/* Reads 16 numbers by rows. False: the upper left part is no rotation, times one scale, or the last
 * row is not 0 0 0 1. */
bool rgbd_similarity_read(const double rows[16], struct affine *out, double *scale);
