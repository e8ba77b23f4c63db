/* Choosing by weights: what every item's share of the table is, and the ends of the numbers. */
#include <math.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "worker/scene/alias_table.h"

#define CELLS_MAX 1000

static struct alias_cell cells[CELLS_MAX];

static double weight_at(const void *weights, uint32_t i)
{
    return ((const double *)weights)[i];
}

/* Builds the table and compares every item's share of it with its weight. */
static void check(const double *weights, uint32_t count)
{
    double shares[CELLS_MAX] = {0}, sum = 0.0;
    for (uint32_t i = 0; i < count; i++) sum += weights[i];
    alias_build(weight_at, weights, count, sum, cells);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(cells[i].keep >= 0.0f && cells[i].keep <= 1.0f && cells[i].other < count);
        shares[i] += (double)cells[i].keep / count;
        shares[cells[i].other] += (1.0 - (double)cells[i].keep) / count;
    }
    for (uint32_t i = 0; i < count; i++) {
        assert_true(fabs(shares[i] - weights[i] / sum) < 1e-7);
        assert_true(weights[i] > 0.0 || shares[i] == 0.0);
    }
}

TEST(shares_are_weights)
{
    double weights[CELLS_MAX];
    struct random r = {6};
    for (int i = 0; i < CELLS_MAX; i++)
        weights[i] = i % 7 == 0 ? 0.0 : pow((double)random_unit(&r), 8.0);
    check(weights, CELLS_MAX);
}

TEST(few_and_equal_items_have_tables)
{
    const double one[] = {1e-30}, equal[] = {0.1, 0.1, 0.1}, last[] = {0.0, 0.0, 0.0, 5.0};
    const double first[] = {1e30, 0.0, 1e10, 0.0};
    check(one, 1);
    check(equal, 3);
    check(last, 4);
    check(first, 4);
}

TEST(choices_end_inside)
{
    double weights[CELLS_MAX];
    for (int i = 0; i < CELLS_MAX; i++) weights[i] = 1.0 + i;
    check(weights, CELLS_MAX);
    assert_true(alias_choose(cells, CELLS_MAX, 0.0) < CELLS_MAX);
    assert_true(alias_choose(cells, CELLS_MAX, 0x1.fffffffffffffp-1) < CELLS_MAX);
}

TEST(refined_numbers_stay_below_the_next)
{
    const float low[2] = {0.0f, 0.0f}, high[2] = {0x1.fffffep-1f, 0x1.fffffep-1f};
    assert_true(alias_refine(0.25f, low) == 0.25);
    assert_true(alias_refine(0x1.fffffep-1f, high) == 1.0 - 0x1p-48);
}
