/* Every loop goes over columns that know nothing of each other: all instruction sets compute the
 * same bits. */
#include "server/reconstruct/residual/residual_spread_kernels.h"

#include "server/reconstruct/simd/vector.h"

#define CHANNELS RESIDUAL_SPREAD_CHANNELS
#define VARIANCE RESIDUAL_SPREAD_VARIANCE

/* So many equal spikes and fewer say nothing: their light may be that of the whole picture. */
#define SPIKES_MIN 2.0f

/* How far the square of a difference between levels must be above its variance to be no chance. */
#define NO_CHANCE 4.0f

struct sums {
    simd_vector of[CHANNELS], total, squares;
};

static inline void store(simd_vector v, float *to)
{
    *(simd_stored *)to = v;
}

/* Squares of the ways between normals of pixels i and j. */
static inline simd_vector turn_of(const struct residual_features *f, size_t i, size_t j)
{
    const size_t n = f->shape.plane;
    const float *x = f->normal, *y = x + n, *z = y + n;
    const simd_vector a = simd_load_vector(x + i) - simd_load_vector(x + j);
    const simd_vector b = simd_load_vector(y + i) - simd_load_vector(y + j);
    const simd_vector c = simd_load_vector(z + i) - simd_load_vector(z + j);
    return a * a + b * b + c * c;
}

/* How far nearnesses are from where slopes lead, over what may be. */
static inline simd_vector off_of(const struct residual_spread_line *l, size_t i, size_t j,
                                 float way)
{
    const simd_vector here = simd_load_vector(l->f->nearness + i);
    const simd_vector along = simd_load_vector(l->slope + i) * way;
    const simd_vector may = RESIDUAL_NEARNESS_PART * here + simd_positive(along) + 1e-30f;
    return (simd_load_vector(l->f->nearness + j) - here - along) / may;
}

/* How much smooth lobes of pixels i and j differ in what they show, `way` pixels apart. */
static inline simd_vector apart(const struct residual_spread_line *l, size_t i, size_t j, float way,
                                simd_vector turn)
{
    const struct residual_features *f = l->f;
    const simd_vector gloss = simd_load_vector(f->gloss + i) * simd_load_vector(f->gloss + j);
    const simd_vector rough = simd_load_vector(f->alpha + i) * simd_load_vector(f->alpha + j);
    if (!(l->lobe_px2 > 0.0f)) return gloss * turn;
    return gloss * turn + way * way / (l->lobe_px2 * rough + 1.0f);
}

static inline simd_vector weigh(const struct residual_spread_line *l, size_t i, size_t j, float way)
{
    const struct residual_features *f = l->f;
    const simd_vector none = simd_same(0.0f), turn = turn_of(f, i, j), off = off_of(l, i, j, way);
    const simd_vector barred = simd_load_vector(f->barred + i) + simd_load_vector(f->barred + j);
    simd_vector same =
        simd_max(1.0f - turn * (1.0f / RESIDUAL_TURN_MAX) - off * off - barred, none);
    if (l->lobes) same = simd_max(same - apart(l, i, j, way, turn), none);
    return same * same;
}

static inline void add_tap(const struct residual_spread_line *l, size_t p, int32_t t,
                           float *const in[CHANNELS], struct sums *sums)
{
    const size_t q = (size_t)((ptrdiff_t)p + t * l->step);
    const simd_vector weight =
        l->level->weight[t < 0 ? -t : t] * weigh(l, p, q, (float)(t * l->level->step_px));
    sums->total += weight;
    sums->squares += weight * weight;
    for (size_t k = 0; k < CHANNELS; k++) sums->of[k] += weight * simd_load_vector(in[k] + q);
}

static inline void mean_vector(const struct residual_spread_line *l, size_t p,
                               float *const in[CHANNELS], float *const out[CHANNELS])
{
    const float own = l->level->weight[0], all = l->level->lower;
    const float lower = (1.0f - all) / (1.0f - l->level->squares);
    struct sums sums = {.total = simd_same(own), .squares = simd_same(own * own)};
    for (size_t k = 0; k < CHANNELS; k++) sums.of[k] = own * simd_load_vector(in[k] + p);
    for (int32_t t = l->first; t <= l->last; t++)
        if (t != 0) add_tap(l, p, t, in, &sums);
    const simd_vector part = 1.0f / sums.total;
    const simd_vector left = 1.0f - (1.0f - sums.squares * part * part) * lower;
    const simd_vector variance = sums.of[VARIANCE] * part;
    const simd_vector few = simd_select(variance > 0.0f, left, simd_same(all));
    for (size_t k = 0; k < VARIANCE; k++) store(sums.of[k] * part, out[k] + p);
    store(variance * left, out[VARIANCE] + p);
    store(simd_load_vector(l->few + p) * few, l->few + p);
}

static inline void clear_vector(const struct residual_spread_line *l, size_t p,
                                float *const out[CHANNELS])
{
    for (size_t k = 0; k < CHANNELS; k++) store(simd_same(0.0f), out[k] + p);
    store(simd_load_vector(l->few + p) * l->level->lower, l->few + p);
}

static inline bool any_near(const struct residual_spread_line *l, size_t p, const float *variance)
{
    simd_vector most = simd_same(0.0f);
    for (int32_t t = l->first; t <= l->last; t++)
        most = simd_max(simd_load_vector(variance + (ptrdiff_t)p + t * l->step), most);
    return simd_some(simd_below(simd_same(0.0f), most));
}

static void kernel_mean_row(const struct residual_spread_line *l, size_t p, size_t count,
                            float *const in[CHANNELS], float *const out[CHANNELS])
{
    for (size_t i = p; i < p + count; i += SIMD_PER_VECTOR)
        if (any_near(l, i, in[VARIANCE]))
            mean_vector(l, i, in, out);
        else
            clear_vector(l, i, out);
}

/* -- what is known -- */

static inline simd_vector sum_of(const simd_vector rgb[3])
{
    return simd_positive(rgb[0]) + simd_positive(rgb[1]) + simd_positive(rgb[2]);
}

/* How much of squares is more than `times` their variance. */
static inline simd_vector known_part(simd_vector square, simd_vector variance, float times)
{
    const simd_vector chance = times * variance;
    return simd_where(square > chance, 1.0f - chance / square);
}

static void kernel_know_row(const struct residual_spread_means *m, size_t p, size_t count)
{
    float *const *mean = m->of[RESIDUAL_SPREAD_LEVELS - 1];
    for (size_t i = p; i < p + count; i += SIMD_PER_VECTOR) {
        const simd_mask shown = simd_load_vector(m->shown + i) > 0.0f;
        const simd_vector weight = simd_where(shown, 1.0f / simd_load_vector(m->few + i));
        const simd_vector variance = simd_load_vector(mean[VARIANCE] + i);
        const simd_vector rgb[3] = {simd_load_vector(mean[0] + i), simd_load_vector(mean[1] + i),
                                    simd_load_vector(mean[2] + i)};
        const simd_vector sum = sum_of(rgb), part = known_part(sum * sum, variance, SPIKES_MIN);
        for (size_t c = 0; c < 3; c++)
            store(simd_where(shown, weight * part * rgb[c]), m->known[c] + i);
        store(weight, m->weight + i);
        store(simd_where(shown, weight * variance), m->variance + i);
    }
}

/* What the pixels around know, whatever they show. Returns its variance if they had as few pixels
 * to know it from as this one: an edge's have hardly any, and take it as it is. */
static inline simd_vector ask_around(const struct residual_spread_means *m, size_t i,
                                     simd_vector found[3])
{
    const simd_vector none = simd_same(0.0f);
    simd_vector sum = none, count = none, variance = none, light[3] = {none, none, none};
    for (ptrdiff_t y = -RESIDUAL_SPREAD_AROUND; y <= RESIDUAL_SPREAD_AROUND; y++)
        for (ptrdiff_t x = -RESIDUAL_SPREAD_AROUND; x <= RESIDUAL_SPREAD_AROUND; x++) {
            const ptrdiff_t k = (ptrdiff_t)i + y * (ptrdiff_t)m->stride + x;
            sum += simd_load_vector(m->weight + k);
            count += simd_load_vector(m->shown + k);
            variance += simd_load_vector(m->variance + k);
            for (size_t c = 0; c < 3; c++) light[c] += simd_load_vector(m->known[c] + k);
        }
    const simd_mask any = count > 0.0f;
    for (size_t c = 0; c < 3; c++) found[c] = simd_where(any, light[c] / sum);
    return simd_where(any, variance / count * simd_load_vector(m->few + i));
}

/* From the widest mean to the narrowest: each is believed as far as it differs by more than
 * chance. Where a narrow one has no spikes, the wider one tells how uncertain that is. */
static void kernel_decide_row(const struct residual_spread_means *m, size_t p, size_t count,
                              float *const out[3])
{
    for (size_t i = p; i < p + count; i += SIMD_PER_VECTOR) {
        simd_vector found[3], off[3], expected = ask_around(m, i, found);
        for (int k = RESIDUAL_SPREAD_LEVELS - 1; k >= 0; k--) {
            for (size_t c = 0; c < 3; c++) off[c] = simd_load_vector(m->of[k][c] + i) - found[c];
            const simd_vector way = sum_of(off);
            const simd_vector variance =
                simd_max(simd_load_vector(m->of[k][VARIANCE] + i), expected);
            const simd_vector to = known_part(way * way, variance, NO_CHANCE);
            for (size_t c = 0; c < 3; c++) found[c] += to * off[c];
            expected = variance / m->lower2[k];
        }
        for (size_t c = 0; c < 3; c++) store(found[c], out[c] + i);
    }
}

const struct residual_spread_kernels KERNELS(residual_spread_kernels) = {
    .mean_row = kernel_mean_row, .know_row = kernel_know_row, .decide_row = kernel_decide_row};
