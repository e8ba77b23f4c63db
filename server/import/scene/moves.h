#pragma once
/* Where a job moves parts of its scene to (proto/job/job_moves.h). */
#include "proto/job/job_moves.h"
#include "server/import/scene/builder.h"
#include "server/import/scene/transform.h"

/* Returns whether a part of the file (NULL: without a name) is called as the job says. */
bool moves_name_matches(const char *own, const char *name);

/* Refuses a name that no part has. Returns ERR_NOT_FOUND. */
int moves_refuse_name(uint32_t move, const char *name, struct fault *fault);

/* Returns what a move does to a part whose middle is there. */
struct affine moves_transform(const struct job_move *move, const double middle[3]);

/* Moves the instances of a scene without nodes by their names. ERR_NOT_FOUND as above. */
int moves_apply(struct builder *b, const struct job_moves *moves, struct fault *fault);
