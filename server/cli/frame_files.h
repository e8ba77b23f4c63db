#pragma once
/* The files of a job's frames under names that a user gave. */
#include <jansson.h>

#include "server/cli/client/client.h"

/* Writes the name of a frame's file: "shot.####.exr" -> "shot.0007.exr"; where there is no #,
 * "out.exr" -> "out.0007.exr" when there are several frames. */
void frame_files_path(const char *path, int32_t frame, bool several, char *out, size_t capacity);

/* Downloads all frames of a finished job {id, document}. exr, png: names as above; NULL: none. */
int frame_files_save(struct client *c, const json_t *job, const char *exr, const char *png,
                     struct fault *fault);
