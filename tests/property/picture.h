#pragma once
/* Pictures of cases, made in this process by the product's own code: the job document is read, the
 * frame planned, its tiles leased, traced, packed, sent, landed and reconstructed block by block,
 * and where the plan has rounds further samples are dealt, traced and mixed in. */
#include "server/image/image.h"
#include "tests/property/case.h"

/* What is done to a case before it is rendered; all zero: nothing. */
struct change {
    double scale;    /* of all lengths; intensities of points follow, so that light stays; 0: 1 */
    double shift[3]; /* after scaling */
    bool mirrored;   /* x turns its sign, of the scene and of the camera's place */
    int turns;       /* by 90 degrees about the vertical */
    double gain;     /* of lights, environment and what emits; 0: 1 */
    unsigned lights; /* bits of lights that are left out */
    bool no_environment, no_emitters;
    bool unfiltered; /* the same samples, averaged */
    bool one_round;  /* what the schedule has, of no filter: no second sets, paths alone in place of
                        a target, averages in place of adaptive sampling */
    bool backwards;  /* results come last tile first */
    unsigned seed;   /* in place of the case's; 0: the case's */
    int spp;         /* the same */
    const char *layer; /* of the output, besides those of the case; NULL: none */
};

/* Layers of pictures that have more than beauty, the first; occlusion besides, where the case asks
 * for it. */
#define PICTURE_LAYERS "beauty", "direct", "indirect", "albedo", "normal", "depth"

/* The picture, for image_destroy; NULL when the job or the scene is refused, with the reason in
 * `refused`. Ends the program when what was planned cannot be done. */
struct image *picture_render(const struct property_case *c, const struct change *change,
                             char *refused, size_t refused_bytes);

/* Of the last one that was rendered. */
struct picture_facts {
    int integrator;                   /* enum plan_integrator */
    bool has_rounds;                  /* plan_has_rounds */
    uint32_t most_rays, strata_maps;  /* of adaptive sampling: a pixel's; plan_strata_maps */
    uint32_t rounds;                  /* of a target, that have ended */
    uint64_t paths, bounces;          /* the same: samples of all pixels */
    uint64_t first_rays, second_rays; /* of adaptive sampling, of all pixels */
    uint64_t lens_paths;              /* of second sets through the lens */
};
const struct picture_facts *picture_facts(void);
