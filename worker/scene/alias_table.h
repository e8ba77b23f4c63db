#pragma once
/* Walker's alias method (1977, "An Efficient Method for Generating Discrete Random Variables with
 * General Distributions") chooses one of many items by their weights, with one number and one
 * comparison. The table depends on the weights alone. */
#include <stdint.h>

struct alias_cell {
    float keep;     /* share of the cell that is its own */
    uint32_t other; /* whose the rest is */
};

/* Returns the weight of item i. It is finite, not negative, and the same at every call. */
typedef double alias_weight(const void *items, uint32_t i);

/* Fills cells[count]. `total` > 0 is the sum of the weights. It asks for every weight twice, each
 * time in order, and needs no memory beside the cells. */
void alias_build(alias_weight *weight, const void *items, uint32_t count, double total,
                 struct alias_cell *cells);

/* The place in the cells where x in [0, 1) falls. */
struct alias_place {
    uint32_t cell;
    double within; /* [0, 1) of it */
};

static inline struct alias_place alias_place_of(uint32_t count, double x)
{
    const double scaled = x * (double)count;
    const uint32_t i = (uint32_t)scaled < count ? (uint32_t)scaled : count - 1;
    return (struct alias_place){i, scaled - (double)i};
}

/* Returns the index that x in [0, 1) chooses. A float has 24 binary digits, of which the choice of
 * a cell takes as many as count has. alias_refine appends more. */
static inline uint32_t alias_choose(const struct alias_cell *cells, uint32_t count, double x)
{
    const struct alias_place place = alias_place_of(count, x);
    const struct alias_cell *cell = &cells[place.cell];
    return place.within < (double)cell->keep ? place.cell : cell->other;
}

/* Returns x with 24 more digits: the last twelve of each of two other uniform numbers. Large tables
 * need more digits than a float has, and the place within an item, which these two choose, hardly
 * changes. */
static inline double alias_refine(float x, const float u[2])
{
    const uint32_t low0 = (uint32_t)(u[0] * 0x1p24f) & 0xfffu;
    const uint32_t low1 = (uint32_t)(u[1] * 0x1p24f) & 0xfffu;
    return (double)x + (double)(low0 << 12 | low1) * 0x1p-48;
}
