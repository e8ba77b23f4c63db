#include "worker/trace/light/strata.h"

#include "worker/trace/light/light_kernels.h"

void strata_init(struct strata *s, const struct light_kernels *kernels, const struct pattern *p,
                 const struct pattern_lattice *lattice, const struct block *b, uint32_t dimension,
                 uint32_t l)
{
    _Alignas(LANES_ALIGN) float jitter0[LANES], jitter1[LANES];
    if (lattice)
        kernels->lattice_jitters(lattice, b, jitter0, jitter1);
    else
        pattern_jitters(p, b->x_px, b->y_px, LANES, dimension, jitter0, jitter1);
    kernels->place_strata(jitter0, jitter1, l, s);
}

void strata_init_per_pixel(struct strata *s, const struct pattern *p, const struct block *b,
                           uint32_t dimension, const uint32_t l[LANES])
{
    s->l = 0;
    _Alignas(LANES_ALIGN) float jitter0[LANES], jitter1[LANES];
    pattern_jitters(p, b->x_px, b->y_px, LANES, dimension, jitter0, jitter1);
    for (int i = 0; i < LANES; i++) {
        s->per_pixel[i] = l[i];
        for (uint32_t k = 0; k < l[i]; k++) {
            s->column[k][i] = pattern_axis(jitter0[i], l[i], k);
            s->row[k][i] = pattern_axis(jitter1[i], l[i], k);
        }
    }
}

void strata_at(const struct strata *s, uint32_t i, float u[LANES], float v[LANES])
{
    for (int k = 0; k < LANES; k++) {
        const uint32_t l = s->per_pixel[k];
        const uint32_t column = l ? i % l : 0, row = l ? i / l : 0;
        u[k] = row < l ? s->column[column][k] : 0.5f;
        v[k] = row < l ? s->row[row][k] : 0.5f;
    }
}
