#pragma once
/* What a scene file is imported as, where it holds more than one picture. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/job/job_composite.h"
#include "proto/job/job_moves.h"

struct scene_choice {
    const char *variant;   /* of the materials; NULL: as they are */
    const char *animation; /* name of the one that plays; NULL: all play */
    double time_s;         /* at which the scene stands; animations hold their ends outside */
    /* With times a scene that moves becomes a base and a blob for each of them. */
    const double *times;
    uint32_t time_count;
    double shutter_s; /* how long it is open around each of them; 0: a frame is one moment */
    const struct job_moves *moves; /* of its nodes; NULL: none */
    /* Of a scene that is composed with a photograph (roles.h): JSON arrays of names. */
    const char *catchers; /* NULL: it is none */
    const char *holdouts; /* NULL: none */
    bool has_ground;
    double ground_height; /* y in the file's coordinates */
    const char *rgbd;     /* document of a sequence of colour and depth that it is put into; NULL */
    bool is_fused;        /* all its frames show one model */
    enum rgbd_estimate estimate; /* of the light, from its frames */
};
