/* Lobes as published (Tokuyoshi 2015): how alike filters find pairs of them, beside the paper's
 * equations in double precision, and beside integrals of their products over the sphere. */
#include "tests/unit/server/reconstruct/glossy/lobe_pairs.h"
#include "tests/unit/unit.h"

/* Sharpness of GGX facets' one Gaussian, and of the mixture, over 1 / alpha^2. */
#define ONE 2.26
static const double mixed_b[] = {1.994, 0.3835}, mixed_a[] = {0.764, 0.2052};

/* Sharpness of the mirrored lobe of facets that have lambda: it is as large as theirs, mirrored. */
static double mirrored(const struct lobe *l, double lambda)
{
    return lambda / (l->alpha * l->alpha * 4 * l->cosine);
}

/* 1 - cosine, without loss. */
static double versine(const double a[3], const double b[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum / 2;
}

static double equation_12(const struct lobe l[2])
{
    const double a = mirrored(&l[0], ONE), b = mirrored(&l[1], ONE);
    return 2 * sqrt(a * b) / (a + b) * exp(-a * b / (a + b) * versine(l[0].r, l[1].r));
}

/* alpha_ij of equation 11, over exp(-shift), which keeps it in range. */
static double alpha_11(const struct lobe *i, const struct lobe *j, double shift)
{
    double sum = 0;
    for (int l = 0; l < 2; l++)
        for (int m = 0; m < 2; m++) {
            const double a = mirrored(i, 2 * mixed_b[l]), b = mirrored(j, 2 * mixed_b[m]);
            const double cosine = 1 - versine(i->r, j->r);
            const double n = sqrt(fmax(a * a + b * b + 2 * a * b * cosine, 1e-300));
            const double x = a * b * 2 * versine(i->r, j->r) / (n + a + b);
            sum += mixed_a[l] * mixed_a[m] * exp(shift - x) * -expm1(-2 * n) / (2 * n);
        }
    return sum;
}

static double equation_11(const struct lobe l[2])
{
    const double a = mirrored(&l[0], 2 * mixed_b[1]), b = mirrored(&l[1], 2 * mixed_b[1]);
    const double shift = a * b / (a + b) * versine(l[0].r, l[1].r);
    const double own = alpha_11(&l[0], &l[0], 0) * alpha_11(&l[1], &l[1], 0);
    return alpha_11(&l[0], &l[1], shift) / sqrt(own) * exp(-shift);
}

/* The eigenvalues of a symmetric matrix, which is changed, from the least, by Jacobi's rotations.
 */
static void eigenvalues(double a[3][3], double out[3])
{
    for (int sweep = 0; sweep < 60; sweep++) {
        const int p = sweep % 3, q = (p + 1) % 3, r = (p + 2) % 3;
        if (a[p][q] == 0) continue;
        const double pp = a[p][p], qq = a[q][q], pq = a[p][q], sign = qq < pp ? -1 : 1;
        const double turn = 0.5 * atan2(2 * sign * pq, fabs(qq - pp)); /* to an eighth */
        const double c = cos(turn), s = sin(turn);
        const double pr = c * a[p][r] - s * a[q][r], qr = s * a[p][r] + c * a[q][r];
        a[p][p] = c * c * pp - 2 * s * c * pq + s * s * qq;
        a[q][q] = s * s * pp + 2 * s * c * pq + c * c * qq;
        a[p][q] = a[q][p] = 0;
        a[p][r] = a[r][p] = pr;
        a[q][r] = a[r][q] = qr;
    }
    for (int k = 0; k < 3; k++) out[k] = a[k][k];
    for (int k = 0; k < 3; k++)
        if (out[k % 2] > out[k % 2 + 1]) {
            const double more = out[k % 2];
            out[k % 2] = out[k % 2 + 1];
            out[k % 2 + 1] = more;
        }
}

/* Xu's product of two anisotropic Gaussians: lambda and mu are the greatest eigenvalues of the sum
 * of both forms, less nu, its least, and exp(-nu) is what is left of the product at its axis. Its
 * integral is pi over the root of both. */
static double equation_13(const struct lobe l[2])
{
    double a[3][3] = {{0}}, shape = 1, x[3];
    for (int j = 0; j < 2; j++) {
        const double wide = l[j].wide, thin = l[j].thin;
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                a[r][c] += l[j].along[r] * l[j].along[c] / (2 * wide * wide) +
                           l[j].across[r] * l[j].across[c] / (2 * thin * thin);
        shape *= pow(4 * wide * wide * thin * thin, -0.25);
    }
    eigenvalues(a, x);
    return 2 * shape / sqrt((x[2] - x[0]) * (x[1] - x[0])) * exp(-x[0]);
}

/* The lobes themselves, towards unit w. */
typedef double lobe_fn(const struct lobe *l, const double w[3]);

static double mixture(const struct lobe *l, const double w[3])
{
    double sum = 0;
    for (int k = 0; k < 2; k++)
        sum += mixed_a[k] * exp(-mirrored(l, 2 * mixed_b[k]) * versine(w, l->r));
    return sum;
}

/* An anisotropic spherical Gaussian: sharpness 1 / 2 sigma^2 for each axis. */
static double anisotropic(const struct lobe *l, const double w[3])
{
    const double x = lobe_dot(w, l->along) / l->wide, y = lobe_dot(w, l->across) / l->thin;
    return fmax(lobe_dot(w, l->r), 0) * exp(-(x * x + y * y) / 2);
}

/* The integral of two lobes' product over the sphere, on rings around the first one's axis, the
 * closer the nearer they are to it. */
static double product(const struct lobe *i, const struct lobe *j, lobe_fn *f)
{
    enum { RINGS = 200, STEPS = 120 };
    const double widest = fmin(acos(-1.0), 20 * fmax(i->alpha, j->alpha));
    double sum = 0;
    for (int k = 0; k < RINGS; k++) {
        const double u = (k + 0.5) / RINGS, angle = widest * u * u;
        for (int s = 0; s < STEPS; s++) {
            const double turn = 2 * acos(-1.0) * (s + 0.5) / STEPS;
            double w[3];
            for (int c = 0; c < 3; c++)
                w[c] = cos(angle) * i->r[c] +
                       sin(angle) * (cos(turn) * i->along[c] + sin(turn) * i->across[c]);
            sum += f(i, w) * f(j, w) * sin(angle) * 2 * u;
        }
    }
    return sum * widest / RINGS * 2 * acos(-1.0) / STEPS;
}

static double integrated(const struct lobe l[2], lobe_fn *f)
{
    return product(&l[0], &l[1], f) / sqrt(product(&l[0], &l[0], f) * product(&l[1], &l[1], f));
}

/* Of what is compared: weights at few rays and at many, where they are not as good as 0. */
struct beside {
    double power, off; /* what weights are of similarities; how far they may be off, relatively */
    uint32_t step;     /* of pairs, to leave some out */
};

static void compare(uint32_t filter, const struct lobe_range *range, const struct beside *b,
                    double equation(const struct lobe l[2]))
{
    static struct lobe_pairs pairs;
    uint32_t compared = 0;
    lobe_pairs_make(filter, range, 11, &pairs);
    for (uint32_t y = 0; y < PAIRS; y += b->step) {
        const struct lobe *l = pairs.lobe[y];
        if (fmin(l[0].cosine, l[1].cosine) < 0.05) continue;
        const double weight = pow(pairs.similarity[y], b->power);
        const double truth = pow(equation(l), b->power);
        if (truth < exp(-8.0)) continue;
        if (!(fabs(weight - truth) <= b->off * truth))
            fail_msg("filter %u: %g in place of %g; alpha %g, %g, n.v %g, %g, apart %g", filter,
                     weight, truth, l[0].alpha, l[1].alpha, l[0].cosine, l[1].cosine,
                     versine(l[0].r, l[1].r));
        compared++;
    }
    assert_true(compared * b->step >= PAIRS / 8);
}

/* Sharp and close, rough and apart, all of both, nearly the same, seen from anywhere. */
static const struct lobe_range ranges[] = {
    {1.2, 0.005, 0.002, 0.05, 1.5, 0}, {1.2, 0.1, 0.01, 0.3, 2, 0},
    {1.2, 0.3, 0.1, 1, 2, 0},          {1.5, 0.01, 0.002, 1, 3, 0},
    {1.5, 0.0001, 0.002, 1, 1.01, 0},  {3.1, 0.1, 0.1, 1, 1.5, 0}};

#define RANGES (sizeof ranges / sizeof *ranges)

/* Powers of 4, 16 and 256 rays. */
static const struct beside closely[] = {{4.9, 0.01, 1}, {11.3, 0.01, 1}, {60.0, 0.02, 1}};

TEST(one_gaussian_is_equation_12)
{
    for (size_t i = 0; i < RANGES; i++)
        for (int k = 0; k < 3; k++) compare(GLOSSY_FILTER_SG, &ranges[i], &closely[k], equation_12);
}

TEST(mixtures_are_equation_11)
{
    for (size_t i = 0; i < RANGES; i++)
        for (int k = 0; k < 3; k++)
            compare(GLOSSY_FILTER_SG_MIXTURE, &ranges[i], &closely[k], equation_11);
}

static double mixtures_integrated(const struct lobe l[2])
{
    return integrated(l, mixture);
}

static double anisotropic_integrated(const struct lobe l[2])
{
    return integrated(l, anisotropic);
}

/* Equation 8, of which 11 is the closed form. */
TEST(mixtures_are_products_over_the_sphere)
{
    for (size_t i = 0; i < RANGES; i++)
        compare(GLOSSY_FILTER_SG_MIXTURE, &ranges[i], &(struct beside){11.3, 0.02, 16},
                mixtures_integrated);
}

/* Xu's product is for lobes that are not wide, and the form that is built for neighbours whose
 * normals are not far apart. */
TEST(anisotropic_gaussians_are_equation_13)
{
    static const struct lobe_range narrow[] = {
        {1.2, 0.005, 0.002, 0.05, 1.5, 0},  {1.2, 0.1, 0.01, 0.4, 2, 0},
        {1.2, 0.1, 0.1, 0.4, 1.2, 0},       {1.5, 0.01, 0.002, 0.4, 3, 0},
        {1.5, 0.0001, 0.002, 0.4, 1.01, 0}, {3.1, 0.1, 0.1, 0.4, 1.5, 0}};
    for (size_t i = 0; i < sizeof narrow / sizeof *narrow; i++)
        for (int k = 0; k < 2; k++)
            compare(GLOSSY_FILTER_ASG, &narrow[i], &(struct beside){closely[k].power, 0.1, 1},
                    equation_13);
}

/* The same of lobes whose facets are spread more one way, however that lies to the view. */
TEST(stretched_ones_are_equation_13)
{
    static const struct lobe_range stretched[] = {{1.2, 0.005, 0.004, 0.05, 1.5, 0.1},
                                                  {1.2, 0.05, 0.02, 0.1, 2, 0.3},
                                                  {1.2, 0.05, 0.1, 0.15, 1.2, 0.5},
                                                  {1.5, 0.01, 0.004, 0.1, 3, 0.2},
                                                  {1.5, 0.0001, 0.004, 0.1, 1.01, 0.1}};
    for (size_t i = 0; i < sizeof stretched / sizeof *stretched; i++)
        for (int k = 0; k < 2; k++)
            compare(GLOSSY_FILTER_ASG, &stretched[i], &(struct beside){closely[k].power, 0.1, 1},
                    equation_13);
}

static double equation_13_of_roots(const struct lobe l[2])
{
    struct lobe root[2] = {l[0], l[1]};
    for (int j = 0; j < 2; j++) {
        root[j].stretch = sqrt(l[j].stretch);
        lobe_finish(&root[j]);
    }
    return equation_13(root);
}

/* Without parallax virtual hits differ in how much they believe of the stretch. */
TEST(virtual_hits_take_its_root)
{
    static const struct lobe_range stretched = {1.2, 0.02, 0.02, 0.1, 1.5, 0.1};
    compare(GLOSSY_FILTER_VIRTUAL_HIT, &stretched, &(struct beside){4.9, 0.1, 1},
            equation_13_of_roots);
}

/* The integral itself departs from both sooner. */
TEST(narrow_ones_are_products_over_the_sphere)
{
    static const struct lobe_range narrow[] = {{1.2, 0.005, 0.002, 0.05, 1.5, 0},
                                               {1.2, 0.1, 0.01, 0.2, 1.2, 0},
                                               {1.5, 0.01, 0.002, 0.1, 3, 0}};
    for (size_t i = 0; i < sizeof narrow / sizeof *narrow; i++)
        compare(GLOSSY_FILTER_ASG, &narrow[i], &(struct beside){11.3, 0.1, 16},
                anisotropic_integrated);
}

/* Whatever lobes there are: of no width, seen along the surface and from behind. */
TEST(similarities_are_shares)
{
    static const struct lobe_range wild[] = {{1.58, 3.1, 1e-6, 1, 1000, 0},
                                             {1.58, 0.001, 1e-6, 0.01, 2, 1e-4},
                                             {3.1, 3.1, 0.3, 1, 3, 0.01}};
    static const uint32_t filters[] = {GLOSSY_FILTER_SG, GLOSSY_FILTER_SG_MIXTURE,
                                       GLOSSY_FILTER_ASG, GLOSSY_FILTER_VIRTUAL_HIT};
    static struct lobe_pairs pairs;
    for (size_t f = 0; f < sizeof filters / sizeof *filters; f++)
        for (uint32_t seed = 0; seed < 30; seed++) {
            lobe_pairs_make(filters[f], &wild[seed % 3], 1 + 1000 * seed, &pairs);
            for (uint32_t y = 0; y < PAIRS; y++) {
                const struct lobe *l = pairs.lobe[y];
                const bool grazing = fmin(l[0].cosine, l[1].cosine) < 0.0499;
                assert_true(pairs.similarity[y] >= 0.0 && pairs.similarity[y] <= 1.0);
                if (grazing) assert_true(pairs.similarity[y] == 0.0);
            }
        }
}

/* A lobe is as alike as can be to itself, and less to any other. */
TEST(a_lobe_is_most_like_itself)
{
    static const struct lobe_range same = {1.4, 0.0, 0.002, 1, 1.0, 0},
                                   turned = {1.4, 0.0, 0.002, 1, 1.0, 0.05},
                                   other = {1.4, 0.0, 0.002, 1, 4, 0};
    static struct lobe_pairs pairs;
    for (uint32_t f = GLOSSY_FILTER_SG; f <= GLOSSY_FILTER_ASG; f++) {
        double alike = 0;
        lobe_pairs_make(f, &turned, 5, &pairs);
        for (uint32_t y = 0; y < PAIRS; y++) alike += pairs.similarity[y] / PAIRS;
        assert_true(f == GLOSSY_FILTER_ASG ? alike < 0.9 : alike > 0.9999); /* who knows axes */
        lobe_pairs_make(f, &same, 5, &pairs);
        for (uint32_t y = 0; y < PAIRS; y++) assert_true(pairs.similarity[y] > 0.9999);
        lobe_pairs_make(f, &other, 5, &pairs);
        for (uint32_t y = 0; y < PAIRS; y++) {
            const struct lobe *l = pairs.lobe[y];
            if (fabs(log(l[0].alpha / l[1].alpha)) > 0.1) assert_true(pairs.similarity[y] < 0.998);
        }
    }
}

/* Lobes as published do not know how far away is what they see; virtual hits do. */
TEST(only_virtual_hits_know_distances)
{
    enum { SIDE = 32, AREA = SIDE * SIDE };
    static const struct rect all = {240, 240, 240 + SIDE, 240 + SIDE};
    for (uint32_t f = GLOSSY_FILTER_VIRTUAL_HIT; f <= GLOSSY_FILTER_LAST; f++) {
        const bool knows = f == GLOSSY_FILTER_VIRTUAL_HIT || f == GLOSSY_FILTER_BANDLIMIT;
        struct plan plan;
        floor_plan(&plan, 512, f, 4);
        struct patch *patch = floor_patch(&plan, all, 0.05f, 0.05f, 16);
        struct floor_picture far = floor_filter(&plan, patch, all);
        for (size_t i = 0; i < AREA; i++) patch->glossy_nearness[i] = 50.0f;
        struct floor_picture near = floor_filter(&plan, patch, all);
        const size_t bytes = AREA * sizeof(float);
        assert_int_equal(memcmp(far.channel[0], near.channel[0], bytes) != 0, knows);
        floor_picture_fini(&far);
        floor_picture_fini(&near);
        patch_destroy(&patch);
    }
}
