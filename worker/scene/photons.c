#include "worker/scene/photons.h"

#include <math.h>
#include <stdlib.h>

/* A place belongs to a leaf up to this part of the leaf's diagonal beyond its photons. */
#define MARGIN 0.5f

/* Discs around the last points reach so many times as far as the second nearest of these. */
#define OVERLAP 1.5f

/* Fits of how last points move are drawn to rest by this part of how far the places spread. */
#define RIDGE 0.01f

struct photon_split {
    uint32_t axis;
    float at;
};

/* ---- the tree ---- */

static void swap(struct photon *p, int64_t i, int64_t j)
{
    const struct photon kept = p[i];
    p[i] = p[j];
    p[j] = kept;
}

/* Puts the photons in order as far as the middle one is in its place (Hoare 1961, "Find"). */
static void part(struct photon *p, int64_t count, int64_t middle, uint32_t axis)
{
    int64_t first = 0, last = count - 1;
    while (first < last) {
        const float pivot = p[middle].place[axis];
        int64_t i = first, j = last;
        while (i <= j) {
            while (p[i].place[axis] < pivot) i++;
            while (p[j].place[axis] > pivot) j--;
            if (i <= j) swap(p, i++, j--);
        }
        if (j < middle) first = i;
        if (i > middle) last = j;
    }
}

static void bound(const struct photon *p, uint32_t count, float low[3], float high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
        for (uint32_t i = 0; i < count; i++) {
            low[k] = fminf(low[k], p[i].place[k]);
            high[k] = fmaxf(high[k], p[i].place[k]);
        }
    }
}

static uint32_t longest_axis(const float low[3], const float high[3])
{
    uint32_t axis = 0;
    for (uint32_t k = 1; k < 3; k++)
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    return axis;
}

/* Returns the area that a box of few photons stands for: of its largest side. */
static float area_of(const float low[3], const float high[3])
{
    float area = 0.0f;
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        area = fmaxf(area, (high[a] - low[a]) * (high[b] - low[b]));
    }
    return area;
}

static float squared_between(const float a[3], const float b[3])
{
    float sum = 0.0f;
    for (int k = 0; k < 3; k++) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum;
}

/* ---- leaves ---- */

struct matrix {
    float at[3][3];
};

/* Inverts a symmetric matrix; 0 if it has no inverse. */
static struct matrix invert(const struct matrix *m)
{
    struct matrix out = {{{0}}};
    float det = 0.0f;
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            out.at[k][r] = m->at[r1][k1] * m->at[r2][k2] - m->at[r1][k2] * m->at[r2][k1];
        }
    for (int k = 0; k < 3; k++) det += m->at[0][k] * out.at[k][0];
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++) {
            const float inverse = out.at[r][k] / det;
            out.at[r][k] = isfinite(inverse) ? inverse : 0.0f;
        }
    return out;
}

static void find_middles(const struct photon *p, uint32_t count, float place[3], float from[3])
{
    for (int k = 0; k < 3; k++) {
        place[k] = from[k] = 0.0f;
        for (uint32_t i = 0; i < count; i++) {
            place[k] += p[i].place[k] / (float)count;
            from[k] += p[i].from[k] / (float)count;
        }
    }
}

/* Fits how far the last points move with the places: least squares, drawn a little towards 0. */
static void find_turn(const struct photon *p, uint32_t count, struct photon_leaf *leaf)
{
    struct matrix a = {{{0}}}, b = {{{0}}};
    const float *from = leaf->middle;
    float place[3];
    find_middles(p, count, place, leaf->middle);
    for (uint32_t i = 0; i < count; i++)
        for (int r = 0; r < 3; r++)
            for (int k = 0; k < 3; k++) {
                const float along = p[i].place[k] - place[k];
                a.at[r][k] += (p[i].place[r] - place[r]) * along;
                b.at[r][k] += (p[i].from[r] - from[r]) * along;
            }
    const float ridge = RIDGE * (a.at[0][0] + a.at[1][1] + a.at[2][2]);
    for (int k = 0; k < 3; k++) a.at[k][k] += ridge;
    const struct matrix inverse = invert(&a);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++) {
            float sum = 0.0f;
            for (int j = 0; j < 3; j++) sum += b.at[r][j] * inverse.at[j][k];
            leaf->turn[r][k] = isfinite(sum) ? sum : 0.0f;
        }
}

/* Returns the square of how far the last points of two photons would be apart at one place. */
static float squared_apart(const struct photon_leaf *leaf, const struct photon *a,
                           const struct photon *b)
{
    float sum = 0.0f;
    for (int r = 0; r < 3; r++) {
        float way = a->from[r] - b->from[r];
        for (int k = 0; k < 3; k++) way -= leaf->turn[r][k] * (a->place[k] - b->place[k]);
        sum += way * way;
    }
    return sum;
}

/* Returns how far the second nearest of the others' last points is from that of photon i. */
static float second_apart(const struct photon *p, uint32_t count, uint32_t i,
                          const struct photon_leaf *leaf)
{
    float nearest = INFINITY, second = INFINITY;
    for (uint32_t j = 0; j < count; j++) {
        if (j == i) continue;
        const float d = squared_apart(leaf, &p[i], &p[j]);
        second = fminf(second, fmaxf(nearest, d));
        nearest = fminf(nearest, d);
    }
    return sqrtf(second);
}

static void set_leaf(const struct photons *p, uint32_t first, uint32_t count,
                     struct photon_leaf *leaf)
{
    struct photon *of = p->photons + first;
    bool finite = true;
    *leaf = (struct photon_leaf){.first = first, .count = count};
    bound(of, count, leaf->low, leaf->high);
    find_turn(of, count, leaf);
    for (uint32_t i = 0; i < count; i++) {
        leaf->flux += of[i].power;
        of[i].reach = OVERLAP * second_apart(of, count, i, leaf);
        finite &= isfinite(of[i].reach) != 0;
    }
    const float area = area_of(leaf->low, leaf->high);
    leaf->flux = area > 0.0f && finite ? leaf->flux / area : 0.0f;
}

/* Splits the photons below a node, the first `inner` of which have children. */
static void split(struct photons *p, uint32_t node, uint32_t first, uint32_t count)
{
    const uint32_t inner = p->leaf_count - 1, middle = count / 2;
    float low[3], high[3];
    if (node >= inner) {
        set_leaf(p, first, count, &p->leaves[node - inner]);
        return;
    }
    bound(p->photons + first, count, low, high);
    const uint32_t axis = longest_axis(low, high);
    part(p->photons + first, count, middle, axis);
    p->splits[node] = (struct photon_split){axis, p->photons[first + middle].place[axis]};
    split(p, 2 * node + 1, first, middle);
    split(p, 2 * node + 2, first + middle, count - middle);
}

struct photons *photons_create(struct photon *photons, uint32_t count)
{
    struct photons *p = calloc(1, sizeof *p);
    uint32_t leaves = 1;
    while (leaves * PHOTONS_IN_LEAF < count) leaves *= 2;
    if (p && count >= PHOTONS_IN_LEAF) {
        *p = (struct photons){.photons = photons, .count = count, .leaf_count = leaves};
        p->leaves = calloc(leaves, sizeof *p->leaves);
        p->splits = calloc(leaves, sizeof *p->splits);
    }
    if (!p || !p->leaves || !p->splits) {
        if (!p || !p->photons) free(photons);
        photons_destroy(&p);
        return NULL;
    }
    split(p, 0, 0, count);
    return p;
}

void photons_destroy(struct photons **photons)
{
    struct photons *p = *photons;
    *photons = NULL;
    if (!p) return;
    free(p->photons);
    free(p->leaves);
    free(p->splits);
    free(p);
}

const struct photon_leaf *photons_find(const struct photons *p, const float place[3],
                                       const float normal[3])
{
    const uint32_t inner = p->leaf_count - 1;
    uint32_t node = 0;
    float beyond2 = 0.0f, above = 0.0f;
    while (node < inner)
        node = 2 * node + (place[p->splits[node].axis] < p->splits[node].at ? 1 : 2);
    const struct photon_leaf *leaf = &p->leaves[node - inner];
    for (int k = 0; k < 3; k++) {
        const float out = fmaxf(fmaxf(leaf->low[k] - place[k], place[k] - leaf->high[k]), 0.0f);
        beyond2 += out * out;
        above += (leaf->middle[k] - place[k]) * normal[k];
    }
    const float margin2 = MARGIN * MARGIN * squared_between(leaf->low, leaf->high);
    return beyond2 <= margin2 && above > 0.0f && leaf->share > 0.0f ? leaf : NULL;
}
