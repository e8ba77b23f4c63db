#include "server/import/measured/lobe_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI       3.14159265358979324
#define WIDTHS   20 /* alphas that are tried at a time */
#define SEARCHES 3
#define LEAST    0.003
#define SAMPLES  60000 /* bins that are looked at, about */
#define COLUMNS  (1 + 2 * WIDTHS)
#define PARTS    5    /* diffuse, then what two lobes reflect at normal incidence and at grazing */
#define DARK     0.02 /* of the mean: what is darker weighs no more */
#define STEPS    1e4

/* A bin, weighed. */
struct spot {
    struct merl_bin bin;
    double weight;
};

struct fit {
    struct spot *spots; /* owned */
    size_t count;
    double width[WIDTHS];
    double gram[COLUMNS][COLUMNS]; /* of lobes over all spots */
    double right[COLUMNS][4];      /* of lobes with rgb and their mean */
    double square;                 /* of the mean */
};

static double grazing_of(double cosine)
{
    const double m = cosine < 1.0 ? 1.0 - cosine : 0.0;
    return m * m * m * m * m;
}

static double diffuse_of(const struct merl_bin *b)
{
    return 1.05 / PI * (1.0 - grazing_of(b->wo[2])) * (1.0 - grazing_of(b->wi[2]));
}

static double span(const double w[3], double alpha)
{
    return sqrt(alpha * alpha * (w[0] * w[0] + w[1] * w[1]) + w[2] * w[2]);
}

/* A lobe of GGX facets that reflect all (worker/shade/ggx.h). */
static double facets_of(const struct merl_bin *b, double alpha)
{
    const double *h = b->h, squared = alpha * alpha;
    const double q = (h[0] * h[0] + h[1] * h[1]) / squared + h[2] * h[2];
    const double seen = span(b->wo, alpha) * b->wi[2] + span(b->wi, alpha) * b->wo[2];
    return 0.5 / (PI * squared * q * q * seen);
}

static double mean_of(const double v[3])
{
    return (v[0] + v[1] + v[2]) / 3.0;
}

/* Takes every so many of the bins; theta_h, where peaks are, has all. */
static int take_spots(const struct merl *m, struct fit *f)
{
    const uint64_t all = (uint64_t)m->bins[0] * m->bins[1] * m->bins[2];
    uint32_t step = 1;
    while (all / ((uint64_t)step * step) > SAMPLES) step++;
    const uint32_t step_d = step < m->bins[1] ? step : m->bins[1];
    const uint32_t step_p = step < m->bins[2] ? step : m->bins[2];
    const size_t room = (size_t)m->bins[0] * (m->bins[1] / step_d + 1) * (m->bins[2] / step_p + 1);
    f->spots = malloc(room * sizeof *f->spots);
    if (!f->spots) return ERR_MEMORY;
    double sum = 0.0, measure = 0.0;
    for (uint32_t h = 0; h < m->bins[0]; h++)
        for (uint32_t d = (step_d - 1) / 2; d < m->bins[1]; d += step_d)
            for (uint32_t p = (step_p - 1) / 2; p < m->bins[2]; p += step_p) {
                struct merl_bin *b = &f->spots[f->count].bin;
                if (!merl_read(m, h, d, p, b)) continue;
                sum += b->measure * mean_of(b->value);
                measure += b->measure;
                f->count++;
            }
    const double dark = measure > 0.0 ? DARK * sum / measure + 1e-9 : 1.0;
    for (size_t i = 0; i < f->count; i++) {
        const double v = cbrt(mean_of(f->spots[i].bin.value) + dark);
        f->spots[i].weight = f->spots[i].bin.measure / (v * v * v * v);
    }
    return 0;
}

/* Sums up products of all lobes of the widths. */
static void sum_up(struct fit *f)
{
    memset(f->gram, 0, sizeof f->gram);
    memset(f->right, 0, sizeof f->right);
    f->square = 0.0;
    for (size_t i = 0; i < f->count; i++) {
        const struct merl_bin *b = &f->spots[i].bin;
        const double g = grazing_of(b->cosine), w = f->spots[i].weight, mean = mean_of(b->value);
        double column[COLUMNS];
        column[0] = diffuse_of(b);
        for (int k = 0; k < WIDTHS; k++) {
            const double lobe = facets_of(b, f->width[k]);
            column[1 + 2 * k] = lobe * (1.0 - g);
            column[2 + 2 * k] = lobe * g;
        }
        for (int r = 0; r < COLUMNS; r++) {
            for (int c = 0; c <= r; c++) f->gram[r][c] += w * column[r] * column[c];
            for (int c = 0; c < 3; c++) f->right[r][c] += w * column[r] * b->value[c];
            f->right[r][3] += w * column[r] * mean;
        }
        f->square += w * mean * mean;
    }
}

/* Least squares of some parts by Gauss and Jordan. Returns false where they depend on each other or
 * one comes out negative. */
static bool solve_some(double a[PARTS][PARTS], const double b[PARTS], uint32_t some,
                       double x[PARTS])
{
    int part[PARTS] = {0}, n = 0;
    double m[PARTS][PARTS + 1];
    for (int k = 0; k < PARTS; k++) {
        x[k] = 0.0;
        if (some >> k & 1) part[n++] = k;
    }
    for (int r = 0; r < n; r++) {
        for (int c = 0; c < n; c++) m[r][c] = a[part[r]][part[c]];
        m[r][n] = b[part[r]];
    }
    for (int k = 0; k < n; k++) {
        if (!(m[k][k] > 1e-12 * a[part[k]][part[k]])) return false;
        for (int r = 0; r < n; r++) {
            const double times = r == k ? 0.0 : m[r][k] / m[k][k];
            for (int c = k; c <= n && r != k; c++) m[r][c] -= times * m[k][c];
        }
    }
    for (int k = 0; k < n; k++) {
        x[part[k]] = m[k][n] / m[k][k];
        if (!(x[part[k]] >= 0.0)) return false;
    }
    return true;
}

/* Least squares of what is not negative: the best of all choices of parts out of `of`. Returns by
 * how much it lowers the square. */
static double solve(double a[PARTS][PARTS], const double b[PARTS], uint32_t of, double x[PARTS])
{
    double best = 0.0, trial[PARTS];
    memset(x, 0, PARTS * sizeof *x);
    for (uint32_t some = 1; some < 1u << PARTS; some++) {
        double gain = 0.0;
        if (some & ~of || !solve_some(a, b, some, trial)) continue;
        for (int k = 0; k < PARTS; k++) gain += trial[k] * b[k];
        if (gain <= best) continue;
        best = gain;
        memcpy(x, trial, sizeof trial);
    }
    return best;
}

/* The equations of two of the widths. */
static void equations(const struct fit *f, const int pair[2], double a[PARTS][PARTS],
                      double b[PARTS][4])
{
    const int at[PARTS] = {0, 1 + 2 * pair[0], 2 + 2 * pair[0], 1 + 2 * pair[1], 2 + 2 * pair[1]};
    for (int r = 0; r < PARTS; r++) {
        for (int c = 0; c < PARTS; c++)
            a[r][c] = at[r] >= at[c] ? f->gram[at[r]][at[c]] : f->gram[at[c]][at[r]];
        memcpy(b[r], f->right[at[r]], sizeof b[r]);
    }
}

static void column_of(double b[PARTS][4], int c, double out[PARTS])
{
    for (int k = 0; k < PARTS; k++) out[k] = b[k][c];
}

/* Finds the best pair of widths. */
static void find_pair(const struct fit *f, int best[2])
{
    double most = -1.0, a[PARTS][PARTS], b[PARTS][4], mean[PARTS], x[PARTS];
    for (int i = 0; i < WIDTHS; i++)
        for (int k = i + 1; k < WIDTHS; k++) {
            equations(f, (const int[2]){i, k}, a, b);
            column_of(b, 3, mean);
            const double gain = solve(a, mean, (1u << PARTS) - 1, x);
            if (gain <= most) continue;
            most = gain;
            best[0] = i;
            best[1] = k;
        }
}

/* Sets half of the widths about each of two, evenly in the logarithm, `step` to each side. */
static void set_widths(struct fit *f, const double about[2], double step)
{
    const int half = WIDTHS / 2;
    for (int k = 0; k < WIDTHS; k++) {
        const double way = (double)(k % half) / (half - 1) - 0.5;
        const double width = about[k < half ? 0 : 1] * exp(2.0 * step * way);
        f->width[k] = width < LEAST ? LEAST : width > 1.0 ? 1.0 : width;
    }
}

static void search(struct fit *f, int best[2])
{
    const int each = WIDTHS / 2; /* about one of two */
    double step = -log(LEAST) / (WIDTHS - 1);
    for (int k = 0; k < WIDTHS; k++) f->width[k] = LEAST * exp(step * k);
    sum_up(f);
    find_pair(f, best);
    for (int i = 1; i < SEARCHES; i++) {
        const double about[2] = {f->width[best[0]], f->width[best[1]]};
        set_widths(f, about, step);
        sum_up(f);
        find_pair(f, best);
        step *= 2.0 / (each - 1);
    }
}

static double rounded(double v)
{
    return floor(v * STEPS + 0.5) / STEPS;
}

/* Colours of the pair. What lobes reflect at grazing angles is the same of all of them. */
static void settle(const struct fit *f, const int best[2], struct lobe_fit *out)
{
    double a[PARTS][PARTS], b[PARTS][4], right[PARTS], mean[PARTS], x[PARTS];
    equations(f, best, a, b);
    column_of(b, 3, right);
    solve(a, right, (1u << PARTS) - 1, mean);
    const double most = mean[2] + mean[4] > 1.0 ? mean[2] + mean[4] : 1.0;
    for (int lobe = 0; lobe < 2; lobe++) {
        out->alpha[lobe] = (float)rounded(f->width[best[lobe]]);
        out->grazing[lobe] = (float)rounded(mean[2 + 2 * lobe] / most);
    }
    for (int c = 0; c < 3; c++) {
        column_of(b, c, right);
        for (int k = 0; k < PARTS; k++)
            right[k] -= a[k][2] * (double)out->grazing[0] + a[k][4] * (double)out->grazing[1];
        solve(a, right, 1u | 2u | 8u, x);
        const double sum = x[0] + x[1] + x[3] > 1.0 ? x[0] + x[1] + x[3] : 1.0;
        out->diffuse[c] = (float)rounded(x[0] / sum);
        out->specular[0][c] = (float)rounded(x[1] / sum);
        out->specular[1][c] = (float)rounded(x[3] / sum);
    }
}

static double peak(const struct lobe_fit *f, int lobe)
{
    const float *s = f->specular[lobe];
    return (double)(s[0] + s[1] + s[2]) / (double)(f->alpha[lobe] * f->alpha[lobe]);
}

static void swap_lobes(struct lobe_fit *f)
{
    const struct lobe_fit was = *f;
    for (int lobe = 0; lobe < 2; lobe++) {
        memcpy(f->specular[lobe], was.specular[1 - lobe], sizeof was.specular[0]);
        f->grazing[lobe] = was.grazing[1 - lobe];
        f->alpha[lobe] = was.alpha[1 - lobe];
    }
}

static double off_by(const struct fit *f, const struct lobe_fit *l)
{
    double sum = 0.0, all = 0.0;
    for (size_t i = 0; i < f->count; i++) {
        const struct merl_bin *b = &f->spots[i].bin;
        const double g = grazing_of(b->cosine), diffuse = diffuse_of(b);
        const double lobe[2] = {facets_of(b, (double)l->alpha[0]),
                                facets_of(b, (double)l->alpha[1])};
        for (int c = 0; c < 3; c++) {
            double v = (double)l->diffuse[c] * diffuse;
            for (int k = 0; k < 2; k++)
                v += lobe[k] * ((double)l->specular[k][c] * (1.0 - g) + (double)l->grazing[k] * g);
            sum += b->measure * fabs(v - b->value[c]);
            all += b->measure * b->value[c];
        }
    }
    return all > 0.0 ? sum / all : 0.0;
}

int lobe_fit_make(const struct merl *m, struct lobe_fit *out)
{
    struct fit *f = calloc(1, sizeof *f);
    int best[2] = {0, 1};
    *out = (struct lobe_fit){0};
    int error = f ? take_spots(m, f) : ERR_MEMORY;
    if (!error) {
        search(f, best);
        settle(f, best, out);
        if (peak(out, 1) > peak(out, 0)) swap_lobes(out);
        out->off = off_by(f, out);
    }
    if (f) free(f->spots);
    free(f);
    return error;
}
