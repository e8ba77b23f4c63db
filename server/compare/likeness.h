#pragma once
/* Of `shearwater compare`: how alike two pictures look, as a screen shows them. */
#include <jansson.h>

#include "server/compare/flip.h"
#include "server/compare/ssim.h"

struct likeness {
    bool ssim, flip;                            /* what is asked for */
    const char *exposure, *gamma, *curve, *ppd; /* the command line's words; NULL: defaults */
    struct shown_view view;
    double pixels_per_degree;
    double ssim_mean;
    struct flip flip_figures;
    int64_t pixels;
};

/* Checks the words. ERR_SYNTAX or ERR_RANGE with *fault naming the option. */
int likeness_parse(struct likeness *l, struct fault *fault);

/* Finds what is asked for. As shown_create. */
int likeness_find(struct likeness *l, const struct image *reference, const struct image *test,
                  const char *layer, struct fault *fault);

/* Adds the figures to a line of JSON. */
void likeness_tell(const struct likeness *l, json_t *line);
