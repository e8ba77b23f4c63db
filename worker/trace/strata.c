#include "worker/trace/strata.h"

void strata_init(struct strata *s, const struct pattern *p, const struct block *b,
                 uint32_t dimension, uint32_t l)
{
    s->l = l;
    for (int i = 0; i < LANES; i++) {
        float jitter[2], at[2];
        pattern_jitter(p, b->x_px[i], b->y_px[i], dimension, jitter);
        for (uint32_t k = 0; k < l; k++) {
            pattern_stratum(jitter, l, k * l + k, at); /* the diagonal meets every row and column */
            s->column[k][i] = at[0];
            s->row[k][i] = at[1];
        }
    }
}
