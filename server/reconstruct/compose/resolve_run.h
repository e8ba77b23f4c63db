#pragma once
/* Pixels side by side, resolved at once where that is plain: all that a pixel's samples show is
 * surely its centre's surface, and nobody asks for errors. Most are, and what is left is for
 * resolve_pixel. */
#include "server/reconstruct/compose/resolve.h"

#define RESOLVE_RUN 64

/* As `struct resolved` has them; direct and indirect hold anything where nobody wants parts. */
struct resolved_run {
    int32_t plain[RESOLVE_RUN]; /* -1: the rest is there; 0: it holds anything */
    float direct[3][RESOLVE_RUN], indirect[3][RESOLVE_RUN], total[3][RESOLVE_RUN];
    float albedo[3][RESOLVE_RUN], coverage[RESOLVE_RUN];
};

/* `count` pixels, at most RESOLVE_RUN, of one row of the patch, the first of them pixel i: the bits
 * that resolve_pixel gives for those that are plain. */
void resolve_run(const struct resolver *r, size_t i, uint32_t count, struct resolved_run *out);

/* Number k of them by itself. */
void resolved_run_set(struct resolved_run *run, uint32_t k, const struct resolved *pixel);
