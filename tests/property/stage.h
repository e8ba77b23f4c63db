#pragma once
/* What a case is made of, for the product: a scene without a file, and the text of a job. */
#include "proto/scene/environment.h"
#include "tests/property/picture.h"
#include "tests/unit/worker/scene_fixture.h"

struct stage {
    struct scene_fixture *fixture; /* owned */
    const struct scene *scene;     /* a view of it */
    struct scene_camera camera;    /* of orthographic cases */
    struct environment_blob map;   /* blob owned; NULL: none */
};

/* The scene looks into *out. Ends the program without memory. */
void stage_build(const struct property_case *c, const struct change *change, struct stage *out);
void stage_free(struct stage *stage);

/* The job document; owned by the caller. */
char *stage_job(const struct property_case *c, const struct change *change);

/* Where a point or a direction of the case lies under the change. */
void stage_place(const struct change *change, const double in[3], double out[3]);
void stage_turn(const struct change *change, const double in[3], double out[3]);
double stage_scale(const struct change *change);
double stage_gain(const struct change *change);

/* Unit vectors u, v of a thing that faces `facing` (axis, + 3 for its other side): u x v points
 * there. */
void stage_frame(int facing, double u[3], double v[3]);
