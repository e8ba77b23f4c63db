#pragma once
/* Light of points that lens samples show and the middle of the lens does not: behind the edges of
 * what is near. Each such sample has the light that its own path has found, which is noise. Samples
 * of the same surface that lie near each other, as the middle of the lens would see them, share
 * theirs: means over a few pixels, over fewer the more samples a pixel has, down to one pixel, the
 * resolution of lighting that fields lend (lens_light.h). */
#include "server/reconstruct/lens_light_kernels.h"
#include "server/reconstruct/scratch.h"

/* How far apart, in pixels, samples at most are that share. What lens filters read around a block
 * is that much more than what their pixels look at. */
#define LENS_HIDDEN_REACH_PX 3

struct lens_hidden {
    struct scratch *scratch;
    size_t width, height;          /* in cells, which are pixels: columns and rows of samples */
    float radius;                  /* px; samples farther apart do not share */
    float *number;                 /* of samples in each cell */
    struct lens_hidden_cell *cell; /* set where there are some */
    struct lens_hidden_sample *list;
    size_t count, room; /* samples in the list, and for how many it has room */
    void *memory;
};

struct lens_hidden_sample {
    size_t at;   /* whatever finds the sample */
    size_t cell; /* whose light it takes */
};

/* Of l x l samples a pixel that are placed in columns up to width - 2 and rows up to height - 2.
 * ERR_MEMORY; fini is to be called either way. */
int lens_hidden_create(struct scratch *scratch, size_t width, size_t height, uint32_t l,
                       struct lens_hidden *out);
void lens_hidden_fini(struct lens_hidden *h);

/* Adds sample i of the row, of that light. 1: it will share, and is in the list as `at`; 0: another
 * surface lies in its cell, and it keeps its light. ERR_MEMORY. */
int lens_hidden_add(struct lens_hidden *h, const struct lens_light_row *row, uint32_t i,
                    const float light[3], size_t at);

/* After all have been added: the light of those in a cell of the list. */
void lens_hidden_share(const struct lens_hidden *h, size_t cell, float light[3]);
