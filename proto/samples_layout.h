#pragma once
/* What samples.c, samples_pack.c and samples_check.c know of layouts; others use samples.h. */
#include "proto/samples.h"

enum samples_group { SAMPLES_GROUP_4, SAMPLES_GROUP_2, SAMPLES_GROUP_1, SAMPLES_GROUP_COUNT };

static inline enum samples_group samples_group(enum samples_type type)
{
    return type <= SAMPLES_U32   ? SAMPLES_GROUP_4
           : type <= SAMPLES_U16 ? SAMPLES_GROUP_2
                                 : SAMPLES_GROUP_1;
}
uint32_t samples_element_bytes(enum samples_group group);

/* Returns the bytes that a plane takes, present or not. */
uint64_t samples_slot_bytes(const struct samples_layout *layout, uint32_t slot);

/* Takes a plane out of the masks. */
void samples_layout_drop(struct samples_layout *layout, uint32_t slot);

/* Returns the bits of a light's last visibility byte that stand for a stratum. */
uint32_t samples_visibility_mask(const struct samples_layout *layout, uint32_t light);

/* Fills offsets and sizes from the masks and counts. ERR_LIMIT when a result would not fit a
 * frame. */
int samples_layout_place(struct samples_layout *layout);

/* Does samples_create without zeroing the data, for callers that write all of it. */
int samples_create_unset(const struct samples_layout *layout, struct samples **out);

/* Checks that every number of s is finite and in its range. ERR_NOT_FINITE or ERR_RANGE; *fault
 * names the plane and the pixel. */
int samples_check(const struct samples *s, struct fault *fault);
