#pragma once
/* Spikes of indirect light (patch/spike_limits.h), such as of a path that met a bright strip behind
 * a lamp. So few of them lie within the filter's width that each would become a blot of the
 * filter's shape. What a spike has beyond its limit is taken out before the filter, and spread over
 * a wider window after it, so that no light is lost. Narrow filters of many samples have no spikes
 * (docs/reconstruction.md, Indirect spikes). */
#include "server/reconstruct/indirect/indirect_width.h"
#include "server/reconstruct/patch/spike_limits.h"

#define INDIRECT_SPIKES_MAX 6 /* channels: light, and half of the samples' */

struct indirect_spikes {
    const struct indirect_kernels *kernels;
    struct indirect_neighbourhood *around;
    struct rect rect;                    /* whose pixels get what is spread */
    float *channel[INDIRECT_SPIKES_MAX]; /* arrays of the neighbourhood */
    uint32_t count;                      /* of them */
    uint32_t first;                      /* the first of indirect_spikes_spares that are free */
    bool any;                            /* there are spikes near `rect` */
};

/* Returns how many pixels around `rect` are read; 0: the rule's filter has no spikes. */
int32_t indirect_spikes_reach(const struct indirect_rule *rule);

/* Returns the number of spares, all zeros, that are needed for `count` channels. */
uint32_t indirect_spikes_spares(uint32_t count);

/* Takes what spikes have too much out of the channels, wherever filters of `rect` read them. The
 * first three channels say what is a spike. */
void indirect_spikes_split(const struct indirect_rule *rule, struct indirect_spikes *s);

/* Spreads what was taken out, and adds it to the channels over `rect`. Sets the field's widths
 * anew. */
void indirect_spikes_spread(const struct indirect_rule *rule, const struct indirect_spikes *s);
