#pragma once
/* The files of a scene at several times: a base, and a blob for each time. */
#include "proto/digest.h"
#include "server/import/import.h"
#include "server/import/scene/builder.h"

struct sequence_files {
    const struct scene_choice *choice;
    const char *out;      /* path of the base; a frame's is that and its number */
    struct builder *base; /* borrowed */
    /* Reads what a frame has at a time into a builder that stands on the base, and finishes it. */
    int (*read)(void *ctx, double time_s, struct builder *b, struct fault *fault);
    void *ctx;
    struct scene map; /* of the base's blob, once it is written */
    struct digest digest;
    struct warnings warnings; /* of the first frame, for the report */
};

/* Writes the finished base, checks that workers would accept it, and maps it. */
int sequence_write_base(struct sequence_files *s, struct fault *fault);

/* Writes the frames of the choice's times, as many as do not keep the first waiting; the base gets
 * the first one's warnings. What is wrong with a later frame is told when it comes first. */
int sequence_write_frames(struct sequence_files *s, struct import_stats *stats,
                          struct fault *fault);

/* Counts a scene's triangles. */
void sequence_count(const struct scene *scene, struct import_stats *stats);

/* Unmaps the base, and removes it where there was an error. Returns rc. */
int sequence_close(struct sequence_files *s, int rc);
