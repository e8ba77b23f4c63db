#pragma once
/* Which parts of a scene stand for what a photograph shows (proto/job/job_composite.h). */
#include "server/import/scene/builder.h"
#include "server/import/scene/scene_choice.h"

/* Makes the instances whose own name or whose material's is listed catchers or holdouts, and marks
 * the builder as one of a composite; without such a choice it does nothing. `whole`: every name
 * must be there, ERR_NOT_FOUND with its place in the job document. ERR_EXISTS for an instance that
 * is both. */
int roles_apply(struct builder *b, const struct scene_choice *choice, bool whole,
                struct fault *fault);

/* Adds the ground to a finished scene, whose bounds stay: a grey Lambertian square so large that a
 * shadow that leaves it is fainter than a thousandth. */
int roles_add_ground(struct builder *b, const struct scene_choice *choice, struct fault *fault);
