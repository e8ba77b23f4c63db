#pragma once
/* What samples.c, samples_pack.c and samples_check.c know about each plane; others use samples.h.
 */
#include "proto/samples.h"

enum samples_group { SAMPLES_GROUP_4, SAMPLES_GROUP_2, SAMPLES_GROUP_1, SAMPLES_GROUP_COUNT };

/* What values a plane may hold. */
enum samples_values {
    SAMPLES_ANY,             /* every bit pattern means something */
    SAMPLES_POSITIVE,        /* f32: finite, not negative */
    SAMPLES_ID,              /* u32: at most LIMIT_INSTANCES */
    SAMPLES_HALF_POSITIVE,   /* f16: finite, not negative */
    SAMPLES_HALF_ABOVE_MISS, /* f16: finite, at least SUB_DEPTH_MISS */
    SAMPLES_HALF_FINITE,     /* f16: finite */
    SAMPLES_SLOPES,          /* f16 pairs: finite, 0 <= first <= second */
    SAMPLES_BITS,            /* no bit past the last stratum */
    SAMPLES_SHARED_9,        /* u32 of shared exponent, 9 bits: every bit pattern is a number */
    SAMPLES_SHARED_8, /* u32 of shared exponent, 8 bits: exponents up to shared_exponent_most */
};

struct samples_plane_kind {
    const char *name;
    enum samples_group group;
    uint32_t components; /* per pixel, sub-sample or stratum */
    enum samples_values values;
};

const struct samples_plane_kind *samples_plane_kind(enum plane_id plane);
const struct samples_plane_kind *samples_light_plane_kind(enum light_plane_id plane);
uint32_t samples_element_bytes(enum samples_group group);

/* Components of a plane under this layout, present or not. */
uint32_t samples_plane_components(const struct samples_layout *layout, enum plane_id plane);
uint32_t samples_light_plane_components(const struct samples_layout *layout, uint32_t light,
                                        enum light_plane_id plane);

/* The bits of a light's last visibility byte that stand for a stratum. */
uint32_t samples_visibility_mask(const struct samples_layout *layout, uint32_t light);

/* Fills offsets and sizes from the masks and counts. ERR_LIMIT when a result would not fit a
 * frame. */
int samples_layout_place(struct samples_layout *layout);

/* samples_create, but data holds anything: for who writes all of it. */
int samples_create_unset(const struct samples_layout *layout, struct samples **out);

/* 0 when every number of s is finite and in its range; else ERR_NOT_FINITE or ERR_RANGE, and
 * *fault names the plane and the pixel. */
int samples_check(const struct samples *s, struct fault *fault);
