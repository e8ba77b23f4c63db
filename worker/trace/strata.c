#include "worker/trace/strata.h"

void strata_init(struct strata *s, const struct pattern *p, const struct block *b,
                 uint32_t dimension, uint32_t l)
{
    s->l = l;
    _Alignas(LANES_ALIGN) float jitter0[LANES], jitter1[LANES];
    pattern_jitters(p, b->x_px, b->y_px, LANES, dimension, jitter0, jitter1);
    for (uint32_t k = 0; k < l; k++)
        for (int i = 0; i < LANES; i++) {
            s->column[k][i] = pattern_axis(jitter0[i], l, k);
            s->row[k][i] = pattern_axis(jitter1[i], l, k);
        }
}
