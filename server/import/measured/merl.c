#include "server/import/measured/merl.h"

#include <math.h>
#include <string.h>

#define HEADER_BYTES 12u
#define HALF_PI      1.57079632679489662
#define VALUE_MAX    1e9 /* of a BRDF: a mirror's peak in a bin of the smallest size is below */

static const double scale[3] = {1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0};

/* Files are little-endian, as the machines that Shearwater runs on. */
static double number_at(const struct merl *m, uint64_t i)
{
    double v;
    memcpy(&v, m->data + HEADER_BYTES + i * sizeof v, sizeof v);
    return v;
}

static void find_directions(const double angle[3], struct merl_bin *out)
{
    const double sine = sin(angle[0]), cosine = cos(angle[0]);
    const double x = sin(angle[1]) * cos(angle[2]), y = sin(angle[1]) * sin(angle[2]);
    const double z = cos(angle[1]);
    const double h[3] = {sine, 0.0, cosine};
    const double wi[3] = {cosine * x + sine * z, y, cosine * z - sine * x};
    memcpy(out->h, h, sizeof h);
    memcpy(out->wi, wi, sizeof wi);
    for (int k = 0; k < 3; k++) out->wo[k] = 2.0 * z * h[k] - wi[k];
    out->cosine = z;
    /* dwi dwo = 4 cos(theta_d) dh dd, where h's rings are as wide as sqrt(theta_h) */
    out->measure = sine * sqrt(angle[0]) * sin(angle[1]) * z * wi[2] * out->wo[2];
}

bool merl_read(const struct merl *m, uint32_t theta_h, uint32_t theta_d, uint32_t phi_d,
               struct merl_bin *out)
{
    const double root = (theta_h + 0.5) / m->bins[0];
    const double angle[3] = {HALF_PI * root * root, HALF_PI * (theta_d + 0.5) / m->bins[1],
                             2.0 * HALF_PI * (phi_d + 0.5) / m->bins[2]};
    const uint64_t all = (uint64_t)m->bins[0] * m->bins[1] * m->bins[2];
    const uint64_t i = ((uint64_t)theta_h * m->bins[1] + theta_d) * m->bins[2] + phi_d;
    find_directions(angle, out);
    if (out->wi[2] < MERL_COSINE_MIN || out->wo[2] < MERL_COSINE_MIN) return false;
    for (uint32_t c = 0; c < 3; c++) out->value[c] = scale[c] * number_at(m, c * all + i);
    return true;
}

static int read_header(const struct file_view *file, const char *place, struct merl *m,
                       struct fault *fault)
{
    uint64_t all = 1;
    if (file->size_bytes < HEADER_BYTES)
        return fault_set(fault, ERR_TRUNCATED, place, "the measurement ends within its header");
    memcpy(m->bins, file->data, sizeof m->bins);
    for (int k = 0; k < 3; k++) {
        if (m->bins[k] < 2 || m->bins[k] > MERL_BINS_MAX)
            return fault_set(fault, ERR_RANGE, place, "%u bins of an angle are not from 2 to %d",
                             m->bins[k], MERL_BINS_MAX);
        all *= m->bins[k];
    }
    const uint64_t wanted = HEADER_BYTES + 3 * all * sizeof(double);
    if (file->size_bytes < wanted)
        return fault_set(fault, ERR_TRUNCATED, place,
                         "of the measurement's %llu bytes only %zu are there",
                         (unsigned long long)wanted, file->size_bytes);
    if (file->size_bytes > wanted)
        return fault_set(fault, ERR_SYNTAX, place, "the measurement has %llu bytes too many",
                         (unsigned long long)(file->size_bytes - wanted));
    return 0;
}

static int check_bin(const struct merl *m, const uint32_t at[3], const char *place,
                     struct fault *fault)
{
    static const char *const colors[3] = {"red", "green", "blue"};
    struct merl_bin bin;
    if (!merl_read(m, at[0], at[1], at[2], &bin)) return 0;
    for (int c = 0; c < 3; c++) {
        if (bin.value[c] >= 0.0 && bin.value[c] <= VALUE_MAX) continue;
        const bool number = isfinite(bin.value[c]);
        return fault_set(fault, number ? ERR_RANGE : ERR_NOT_FINITE, place,
                         "%s is %g at theta_h %u, theta_d %u, phi_d %u", colors[c], bin.value[c],
                         at[0], at[1], at[2]);
    }
    return 0;
}

int merl_open(const struct file_view *file, const char *place, struct merl *out,
              struct fault *fault)
{
    uint32_t at[3];
    *out = (struct merl){.data = file->data};
    int rc = read_header(file, place, out, fault);
    for (at[0] = 0; rc == 0 && at[0] < out->bins[0]; at[0]++)
        for (at[1] = 0; rc == 0 && at[1] < out->bins[1]; at[1]++)
            for (at[2] = 0; rc == 0 && at[2] < out->bins[2]; at[2]++)
                rc = check_bin(out, at, place, fault);
    return rc;
}
