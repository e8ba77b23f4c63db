#pragma once
/* Tables tell how often each bin of an environment map is sampled, for each of 26 normals and for
 * what a place sees of the sky. A bin's weight is what it sends, times the mean cosine with which
 * surfaces of about such a normal receive it, times how open the scene is towards it. No bin that
 * sends light is left out, so tables change noise, never the mean. */
#include "worker/scene/environment.h"
#include "worker/scene/openness.h"

#define SKY_TABLE_NORMALS 27u /* by the sign of each component; the middle one is never met */

/* Probabilities are whole multiples of 1 / SKY_TABLE_UNITS. */
#define SKY_TABLE_UNITS 32768u

/* A table holds how many units the bins before each one have, in ascending order. A choice reads
 * one cache line of `heads` and one of `before`. */
#define SKY_TABLE_STRIDE 32u
#define SKY_TABLE_HEADS  (ENVIRONMENT_BINS / SKY_TABLE_STRIDE)

struct sky_table {
    _Alignas(64) uint16_t heads[SKY_TABLE_HEADS]; /* every SKY_TABLE_STRIDE-th of the others */
    _Alignas(64) uint16_t before[ENVIRONMENT_BINS];
};

struct sky_tables;

/* Creates the tables of a map that the plan turns by `rotation_rad`. NULL: out of memory. */
struct sky_tables *sky_tables_create(const struct environment *map, float rotation_rad);
void sky_tables_destroy(struct sky_tables **tables);

/* Fills SKY_TABLE_NORMALS tables. `open` is what openness_of returns; NULL: all is open. */
void sky_tables_fill(const struct sky_tables *t, const float *open, struct sky_table *out);

/* Returns the table for a normal in the map's frame. */
static inline uint32_t sky_table_of(const float normal[3])
{
    uint32_t facing = 0;
    for (int k = 0; k < 3; k++)
        facing = 3 * facing + (normal[k] > 0.35f ? 2u : normal[k] < -0.35f ? 0u : 1u);
    return facing;
}

/* Returns where a bin's units end. */
static inline uint32_t sky_table_end(const struct sky_table *t, uint32_t bin)
{
    return bin + 1 < ENVIRONMENT_BINS ? t->before[bin + 1] : SKY_TABLE_UNITS;
}

/* Returns the probability of a bin. */
static inline float sky_table_probability(const struct sky_table *t, uint32_t bin)
{
    return (float)(sky_table_end(t, bin) - t->before[bin]) * (1.0f / (float)SKY_TABLE_UNITS);
}

/* Returns how many of `count` ascending numbers are at most `whole`. */
static inline uint32_t sky_table_count(const uint16_t *ascending, uint32_t count, uint16_t whole)
{
    uint16_t sum = 0;
    for (uint32_t i = 0; i < count; i++) sum = (uint16_t)(sum + (ascending[i] <= whole));
    return sum;
}

/* Returns the bin that `choice` in [0, 1) takes. *choice becomes the place within the bin. */
static inline uint32_t sky_table_choose(const struct sky_table *t, float *choice)
{
    const float units = *choice * (float)SKY_TABLE_UNITS;
    const uint16_t whole = (uint16_t)units;
    const uint32_t first =
        (sky_table_count(t->heads, SKY_TABLE_HEADS, whole) - 1) * SKY_TABLE_STRIDE;
    const uint32_t bin = first + sky_table_count(t->before + first, SKY_TABLE_STRIDE, whole) - 1;
    const float before = t->before[bin];
    *choice = (units - before) / ((float)sky_table_end(t, bin) - before);
    return bin;
}
