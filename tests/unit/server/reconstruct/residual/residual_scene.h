#pragma once
/* Patches of paths that are made of formulas, for the residual filter: what a sample of a pixel
 * sees is a function of both, whichever part of the picture a patch shows. */
#include <stdbool.h>

#include "server/reconstruct/residual/residual.h"
#include "tests/unit/unit.h"

/* What a sample sees; light of the diffuse lobe is before albedo. */
struct residual_sample {
    bool hits;
    uint32_t id; /* of the surface; of sample 0 it is the centre's, as distance and normal are */
    float normal[3], distance, albedo[3];
    float tint[3], alpha; /* of all lobes but the diffuse one */
    float emission[3], direct[3], indirect[3], rest[3];
    float slope; /* through a lens */
};

struct residual_scene {
    int32_t width, height;
    uint32_t spp;
    /* Samples of a pixel, where pixels differ; NULL: all have spp. */
    uint32_t (*spp_of)(int32_t x, int32_t y);
    /* Changes what a sample sees: a grey wall ahead, five units away, that nothing lights. */
    void (*show)(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                 struct residual_sample *out);
    float level;          /* as `show` likes */
    bool no_indirect;     /* the plan has no indirect light of the diffuse lobe */
    uint32_t temporal;    /* frames on each side that lend samples; the wall stands */
    int32_t frame;        /* as `show` likes */
    int32_t pan;          /* pixels that the camera has gone to the right after a frame */
    uint32_t lens_strata; /* samples are those of a lens: spp is the square of this; 0: a pinhole */
};

/* In [0, 1), by pixel, sample and a number for what is asked. */
float residual_random(int32_t x, int32_t y, uint32_t sample, uint32_t what);

/* The same, exponential of mean and deviation 1. */
float residual_noise(int32_t x, int32_t y, uint32_t sample, uint32_t what);

/* A colour in all its channels. */
static inline void residual_grey(float value, float out[3])
{
    out[0] = out[1] = out[2] = value;
}

struct plan residual_scene_plan(const struct residual_scene *s);

/* The part `rect` of the picture. Owned by the caller. */
struct patch *residual_scene_patch(const struct residual_scene *s, struct rect rect);

/* Filters a block with as much around it as the filter asks for. Owned by the caller. */
struct residual_picture residual_scene_filter(const struct residual_scene *s, struct rect block);

/* The same of the whole picture. */
struct residual_picture residual_scene_filter_all(const struct residual_scene *s);

/* The plain mean of a pixel. */
float residual_scene_mean(const struct patch *patch, int channel, int32_t x, int32_t y);

/* A picture, and variances of its channels. */
struct residual_told {
    struct residual_picture picture;
    float *variance[3];
};

/* The plain variance of a pixel. */
typedef float residual_plain(const struct residual_scene *s, int32_t x, int32_t y);

/* Filters `block`, with plain variances; residual_told_fini frees. */
struct residual_told residual_scene_tell(const struct residual_scene *s, struct rect block,
                                         residual_plain *plain);

/* The same of a picture of `lit`, in which `block` has variances. */
struct residual_told residual_scene_tell_within(const struct residual_scene *s, struct rect lit,
                                                struct rect block, residual_plain *plain);
void residual_told_fini(struct residual_told *told);
