#pragma once
/* The perceptual metrics of `shearwater compare`: how alike two pictures look on a screen. */
#include <jansson.h>

#include "server/compare/flip.h"
#include "server/compare/ssim.h"

struct perceptual_metrics {
    bool ssim, flip;                            /* which ones are wanted */
    const char *exposure, *gamma, *curve, *ppd; /* from the command line; NULL: defaults */
    struct display_transform view;
    double pixels_per_degree;
    double ssim_mean;
    struct flip flip_figures;
    int64_t pixels;
};

/* Parses the options. ERR_SYNTAX or ERR_RANGE with *fault naming the option. */
int perceptual_metrics_parse(struct perceptual_metrics *l, struct fault *fault);

/* Computes the wanted metrics. Fails as display_pair_create does. */
int perceptual_metrics_find(struct perceptual_metrics *l, const struct image *reference,
                            const struct image *test, const char *layer, struct fault *fault);

/* Adds the figures to a line of JSON. */
void perceptual_metrics_tell(const struct perceptual_metrics *l, json_t *line);
