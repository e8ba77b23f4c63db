#pragma once
/* One sample of a light field of pixel centres once more, with a record of all that it did. */
#include "proto/samples.h"
#include "worker/replay/field_choice.h"
#include "worker/scene/environment.h"
#include "worker/scene/render_scene.h"

/* What the tile's planes hold of the pixel, all of its samples taken together; of halves, as
 * numbers of scene units. */
struct field_held {
    uint32_t planes;     /* of a light: bits of enum light_plane_id */
    float irradiance;    /* mean over strata */
    float slope[2];      /* least and most */
    uint32_t mean_count; /* 3 of bounce rays, 4 of glossy lobes' (their weight last); 0: none */
    bool is_half;        /* the mean over the sample's half alone */
    float mean[4];
    bool has_slot; /* the sample's own in PLANE_INDIRECT_STRATA: radiance, distance */
    float slot[4];
};

/* Traces sample `sample` of the field in pixel (x, y) by the code that traces tiles, on a tile of
 * that pixel: what *record says to be stored is, bit by bit, what the tile's sums add up. A pixel
 * whose surface asks for no such light, or that has none, has record->field.drawn off.
 *
 * ERR_UNSUPPORTED for a field that the plan does without, ERR_RANGE for a pixel outside the image,
 * a sample or a pass that the plan cannot have, ERR_MISSING for a pass without choice->side or a
 * plan with a map but no environment, ERR_MEMORY; *fault says more, and what to ask instead. */
int field_replay(const struct render_scene *scene, const struct environment *environment,
                 const struct plan *plan, const struct field_choice *choice, int32_t x, int32_t y,
                 uint32_t sample, struct path_record *record, struct field_held *held,
                 struct fault *fault);
