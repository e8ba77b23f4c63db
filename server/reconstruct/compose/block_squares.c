#include "server/reconstruct/compose/block_squares.h"

#include <stdlib.h>

#include "proto/error.h"

int block_squares_create(struct rect rect, struct block_squares *out)
{
    const size_t area = (size_t)rect_area(rect);
    float *next = calloc(area * SOURCE_COUNT * 3, sizeof *next);
    *out = (struct block_squares){.rect = rect, .memory = next};
    if (!next) return ERR_MEMORY;
    for (int s = 0; s < SOURCE_COUNT; s++)
        for (int c = 0; c < 3; c++, next += area) out->square[s][c] = next;
    return 0;
}

void block_squares_fini(struct block_squares *squares)
{
    free(squares->memory);
    *squares = (struct block_squares){.memory = NULL};
}
