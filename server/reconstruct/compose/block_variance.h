#pragma once
/* Variances of a block's means of R, G and B (squared standard errors), by source. */
#include <stddef.h>

#include "proto/tile.h"

/* What lowers the error. */
enum error_source {
    ERROR_SOURCE_PATHS,   /* more paths */
    ERROR_SOURCE_BOUNCES, /* more bounce rays */
    ERROR_SOURCE_LOBES,   /* more rays of glossy lobes, which come with bounce rays */
    ERROR_SOURCE_CENTRES, /* nothing: they stem from a pixel's few surface samples */
    ERROR_SOURCE_COUNT
};

/* Arrays of the block's pixels, row by row. One allocation. */
struct block_variance {
    struct rect rect;
    float *by_source[ERROR_SOURCE_COUNT][3];
    void *memory; /* owned */
};

/* Creates variances of 0. ERR_MEMORY. */
int block_variance_create(struct rect rect, struct block_variance *out);
void block_variance_fini(struct block_variance *variance);

static inline size_t block_variance_index(const struct block_variance *s, int32_t x, int32_t y)
{
    return (size_t)(y - s->rect.y0) * (size_t)rect_width(s->rect) + (size_t)(x - s->rect.x0);
}
