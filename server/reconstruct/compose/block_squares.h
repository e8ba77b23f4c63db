#pragma once
/* Squared standard errors of a block's R, G and B, by what would lower them. */
#include <stddef.h>

#include "proto/tile.h"

enum block_source {
    SOURCE_PATHS,   /* more paths */
    SOURCE_BOUNCES, /* more bounce rays */
    SOURCE_LOBES,   /* more rays of glossy lobes, which come with bounce rays */
    SOURCE_CENTRES, /* nothing: the few surface samples of a pixel that light fields are spread over
                     */
    SOURCE_COUNT
};

/* Arrays of the block's pixels, row by row. One allocation. */
struct block_squares {
    struct rect rect;
    float *square[SOURCE_COUNT][3];
    void *memory; /* owned */
};

/* All zero. ERR_MEMORY. */
int block_squares_create(struct rect rect, struct block_squares *out);
void block_squares_fini(struct block_squares *squares);

static inline size_t block_squares_index(const struct block_squares *s, int32_t x, int32_t y)
{
    return (size_t)(y - s->rect.y0) * (size_t)rect_width(s->rect) + (size_t)(x - s->rect.x0);
}
