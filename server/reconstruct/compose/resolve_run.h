#pragma once
/* Resolves adjacent pixels at once in the plain case: all that a pixel's samples show is surely
 * its centre's surface, and no errors are wanted. Most pixels are plain; resolve_pixel serves
 * the rest. */
#include "server/reconstruct/compose/resolve.h"

#define RESOLVE_RUN 64

/* The results, as in `struct resolved`. direct and indirect are undefined unless parts are
 * wanted. */
struct resolved_run {
    int32_t plain[RESOLVE_RUN]; /* -1: the results are set; 0: they are undefined */
    float direct[3][RESOLVE_RUN], indirect[3][RESOLVE_RUN], total[3][RESOLVE_RUN];
    float albedo[3][RESOLVE_RUN], coverage[RESOLVE_RUN];
};

/* Resolves `count` pixels, at most RESOLVE_RUN, of one row of the patch from pixel i on. Plain ones
 * get the bits of resolve_pixel. */
void resolve_run(const struct resolver *r, size_t i, uint32_t count, struct resolved_run *out);

/* Sets result k. */
void resolved_run_set(struct resolved_run *run, uint32_t k, const struct resolved *pixel);
