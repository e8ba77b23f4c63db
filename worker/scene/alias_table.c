#include "worker/scene/alias_table.h"

#include <stdlib.h>
#include <string.h>

/* Indexes of cells that are still to be paired: poor ones (less than a whole cell) grow from the
 * front, rich ones from the back. */
struct pairing {
    double *share; /* of what one cell holds */
    uint32_t *order;
    uint32_t poor, rich; /* how many */
};

static void sort_out(struct pairing *p, const double *weights, uint32_t count)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < count; i++) sum += weights[i];
    for (uint32_t i = 0; i < count; i++) {
        p->share[i] = weights[i] / sum * (double)count;
        p->order[p->share[i] < 1.0 ? p->poor++ : count - ++p->rich] = i;
    }
}

/* Fills up poor cells from rich ones, which may become poor by it. */
static void pair_up(struct pairing *p, uint32_t count, struct alias_cell *cells)
{
    while (p->poor > 0 && p->rich > 0) {
        uint32_t poor = p->order[--p->poor], rich = p->order[count - p->rich];
        cells[poor] = (struct alias_cell){(float)p->share[poor], rich};
        p->share[rich] -= 1.0 - p->share[poor];
        if (p->share[rich] >= 1.0) continue;
        p->rich--;
        p->order[p->poor++] = rich;
    }
}

int alias_build(const double *weights, uint32_t count, struct alias_cell *cells)
{
    struct pairing p = {.share = malloc(count * sizeof *p.share + 1),
                        .order = malloc(count * sizeof *p.order + 1)};
    int rc = p.share && p.order ? 0 : ERR_MEMORY;
    for (uint32_t i = 0; i < count && rc == 0; i++) cells[i] = (struct alias_cell){1.0f, i};
    if (rc == 0) {
        sort_out(&p, weights, count);
        pair_up(&p, count, cells); /* what is left over is whole but for rounding */
    }
    free(p.share);
    free(p.order);
    return rc;
}

double alias_refine(float x, const float u[2])
{
    uint64_t bits;
    memcpy(&bits, u, sizeof bits);
    bits *= 0x9e3779b97f4a7c15u; /* Fibonacci hashing: the upper bits depend on all */
    bits ^= bits >> 32;
    bits *= 0xd6e8feb86659fd93u;
    return (double)x + (double)(bits >> 40) * 0x1p-48;
}
