#pragma once
/* Light of lone sub-samples (proto/lone.h) of a patch. Each has its own, because no pixel around it
 * shows its surface. */
#include "proto/lone.h"

struct lone_entry {
    uint32_t place; /* pixel of the patch * sub_samples + sub-sample */
    float light[LONE_PART_COUNT][3];
};

struct lone_share {
    uint32_t parts;             /* bits of enum lone_part: the others are 0 */
    uint32_t count;             /* entries, by ascending place once they are all there */
    struct lone_entry *entries; /* the patch's; NULL: none */
};

/* Puts the entries in order. */
void lone_share_sort(struct lone_share *share);

/* Returns the entry of a place; NULL: its sub-sample is not lone. */
const struct lone_entry *lone_share_find(const struct lone_share *share, size_t place);

/* Returns the standard error of the mean of a part's channel, estimated from half its samples; 0
 * where it is not known. */
float lone_entry_error(const struct lone_share *share, const struct lone_entry *e,
                       enum lone_part part, enum lone_part half, int channel);
