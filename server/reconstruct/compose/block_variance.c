#include "server/reconstruct/compose/block_variance.h"

#include <stdlib.h>

#include "proto/error.h"

int block_variance_create(struct rect rect, struct block_variance *out)
{
    const size_t area = (size_t)rect_area(rect);
    float *next = calloc(area * ERROR_SOURCE_COUNT * 3, sizeof *next);
    *out = (struct block_variance){.rect = rect, .memory = next};
    if (!next) return ERR_MEMORY;
    for (int s = 0; s < ERROR_SOURCE_COUNT; s++)
        for (int c = 0; c < 3; c++, next += area) out->by_source[s][c] = next;
    return 0;
}

void block_variance_fini(struct block_variance *variance)
{
    free(variance->memory);
    *variance = (struct block_variance){.memory = NULL};
}
