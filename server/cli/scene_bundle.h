#pragma once
/* Uploads the files that a job names on this machine's disk: its scene, with the files that the
 * scene refers to, its environment map, its backplate, and a sequence of colour and depth with the
 * files that it names.
 *
 * glTF: buffers[].uri and images[].uri; OBJ: mtllib, and map_* of those. References must stay
 * inside the main file's folder. */
#include <jansson.h>

#include "server/cli/client/client.h"

/* Turns the document's {"scene": {"file": "x.glb"}}, relative to the job file at `job_path`, into
 * {"scene": {"asset": sha256, "files": {...}}} by uploading all of it, and {"environment": {"file":
 * "x.hdr"}} into {"environment": {"asset": sha256}}. {"rgbd": {"file": "x.json"}} becomes {"rgbd":
 * {"document": "rgbd/x.json"}}, and its files are listed in scene.files. Members that already say
 * "asset" stay. */
int scene_bundle_upload(struct client *c, const char *job_path, json_t *document,
                        struct fault *fault);
