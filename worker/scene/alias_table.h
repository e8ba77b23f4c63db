#pragma once
/* Choosing one of many by given weights with one number and one comparison: Walker's alias method,
 * built by Vose's algorithm (1991, "A linear algorithm for generating random numbers with a given
 * distribution"). The table depends on the weights alone. */
#include <stdint.h>

#include "proto/error.h"

struct alias_cell {
    float keep;     /* share of the cell that is its own */
    uint32_t other; /* whose the rest is */
};

/* Fills cells[count] from weights that are finite, not negative and not all 0. ERR_MEMORY. */
int alias_build(const double *weights, uint32_t count, struct alias_cell *cells);

/* The index that x in [0, 1) chooses. Where x comes as a float it has 24 bits, of which the cell
 * takes as many as count has: alias_refine appends more. */
static inline uint32_t alias_choose(const struct alias_cell *cells, uint32_t count, double x)
{
    double scaled = x * (double)count;
    uint32_t i = (uint32_t)scaled;
    if (i >= count) i = count - 1;
    return scaled - (double)i < (double)cells[i].keep ? i : cells[i].other;
}

/* A number between x and the next multiple of 2^-24, its further bits hashed from two other
 * uniform numbers: large tables need more bits than a float has. */
double alias_refine(float x, const float u[2]);
