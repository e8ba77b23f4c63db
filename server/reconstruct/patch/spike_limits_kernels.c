#include "server/reconstruct/patch/spike_limits_kernels.h"

#include "server/reconstruct/simd/vector.h"

struct sums {
    simd_vector sum, count;
};

/* Adds `reach` pixels to one side of those from p on. */
static inline void add_side(const struct spike_limits_line *l, size_t p, bool backward,
                            int32_t reach, struct sums *s)
{
    simd_vector open = simd_same(1.0f);
    for (int32_t k = 1; k <= reach; k++) {
        const ptrdiff_t way = backward ? -k * l->step : k * l->step;
        const ptrdiff_t at = (ptrdiff_t)p + way, joint = backward ? at : at - l->step;
        open *= simd_load_vector(l->link + joint);
        s->sum += open * simd_load_vector(l->in + at);
        s->count += open * simd_load_vector(l->counts + at);
    }
}

static void kernel_sum_line(const struct spike_limits_line *l, size_t first, size_t width,
                            float *out, float *out_counts)
{
    for (size_t p = first; p < first + width; p += SIMD_PER_VECTOR) {
        struct sums s = {simd_load_vector(l->in + p), simd_load_vector(l->counts + p)};
        add_side(l, p, true, l->before, &s);
        add_side(l, p, false, l->after, &s);
        *(simd_stored *)(out + p) = s.sum;
        *(simd_stored *)(out_counts + p) = s.count;
    }
}

const struct spike_limits_kernels KERNELS(spike_limits_kernels) = {.sum_line = kernel_sum_line};
