#pragma once
/* Traces one path of a tile again and records every step. */
#include "proto/plan.h"
#include "worker/scene/environment.h"
#include "worker/scene/render_scene.h"
#include "worker/trace/path/path_record.h"

/* Traces path `sample` of pixel (x, y) as tiles of the plan do: record->stored is, bit by bit, what
 * it adds to the tile's sums, or what the tile holds of that lens sample. Samples are the plan's
 * paths, or where it has none its lens samples. Those of second sets have numbers from
 * LENS_SECOND_SET_FIRST on, whichever pixels get one. `environment` is the plan's map, NULL when it
 * has none. Sums of pixels at edges are scaled to as many paths as others have, and beside lamps by
 * their coverage, too (path_sums.h).
 *
 * ERR_UNSUPPORTED for a plan without either, ERR_RANGE for a pixel outside the image or a sample
 * that the plan cannot have, ERR_MISSING for a plan with a map but no environment, ERR_MEMORY;
 * *fault says more. */
int sample_replay(const struct render_scene *scene, const struct environment *environment,
                  const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                  struct path_record *record, struct fault *fault);
