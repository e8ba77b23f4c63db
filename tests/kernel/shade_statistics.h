#pragma once
/* The tails of the distributions that tests compare with. */
#include <math.h>

/* The upper regularised incomplete gamma function Q(a, x): by its series below a + 1, by its
 * continued fraction (Lentz's method) above. */
static inline double gamma_tail(double a, double x)
{
    if (x <= 0.0) return 1.0;
    const double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; term > sum * 1e-15; n += 1.0) sum += term *= x / n;
        return 1.0 - front * sum;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for (int i = 1; i < 100000; i++) {
        const double numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        h *= c * d;
        if (fabs(c * d - 1.0) < 1e-14) break;
    }
    return front * h;
}

/* The probability of a chi-square this large by chance. */
static inline double chi_square_tail(double chi_square, int degrees)
{
    return degrees > 0 ? gamma_tail(0.5 * degrees, 0.5 * chi_square) : 1.0;
}

/* The threshold for each of `count` tests that makes any of them fail by chance with probability
 * `all` (Sidak). */
static inline double sidak(double all, int count)
{
    return -expm1(log1p(-all) / count);
}
