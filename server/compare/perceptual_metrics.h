#pragma once
/* Of `shearwater compare`: how alike two pictures look, as a screen shows them. */
#include <jansson.h>

#include "server/compare/flip.h"
#include "server/compare/ssim.h"

struct perceptual_metrics {
    bool ssim, flip;                            /* what is asked for */
    const char *exposure, *gamma, *curve, *ppd; /* the command line's words; NULL: defaults */
    struct display_transform view;
    double pixels_per_degree;
    double ssim_mean;
    struct flip flip_figures;
    int64_t pixels;
};

/* Checks the words. ERR_SYNTAX or ERR_RANGE with *fault naming the option. */
int perceptual_metrics_parse(struct perceptual_metrics *l, struct fault *fault);

/* Finds what is asked for. As display_pair_create. */
int perceptual_metrics_find(struct perceptual_metrics *l, const struct image *reference,
                            const struct image *test, const char *layer, struct fault *fault);

/* Adds the figures to a line of JSON. */
void perceptual_metrics_tell(const struct perceptual_metrics *l, json_t *line);
