#include "server/import/gltf/gltf_sampler.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_accessor.h"

enum curve { CURVE_LINEAR, CURVE_STEP, CURVE_CUBIC };

/* Beyond it a product of two keys might be no double, and a time no frame. */
#define VALUE_MAX 1e30

struct sampler {
    const json_t *json;
    const char *place;
    enum curve curve;
    uint32_t input, output; /* accessors */
    uint32_t width;         /* numbers of a value */
    float *keys;            /* owned; width numbers each, three times as many for a cubic curve */
};

static int read_curve(struct sampler *s, struct fault *fault)
{
    static const char *const names[] = {"LINEAR", "STEP", "CUBICSPLINE"};
    const char *name;
    gltf_place at;
    int rc = gltf_text(s->json, s->place, "interpolation", &name, fault);
    if (rc != 0 || name == NULL) return rc;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(name, names[i]) != 0) continue;
        s->curve = (enum curve)i;
        return 0;
    }
    gltf_place_set(at, "%s.interpolation", s->place);
    return fault_set(fault, ERR_RANGE, at, "\"%.40s\" is not LINEAR, STEP or CUBICSPLINE", name);
}

static int read_accessor(struct gltf *g, const struct sampler *s, const char *key, uint32_t *out,
                         struct fault *fault)
{
    gltf_place at;
    int rc = gltf_index(s->json, s->place, key, gltf_count(g->root, "accessors"), out, fault);
    if (rc != 0 || *out != SCENE_NONE) return rc;
    gltf_place_set(at, "%s.%s", s->place, key);
    return fault_set(fault, ERR_MISSING, at, "a sampler has its keys here");
}

/* Times may repeat, where a value jumps, and never go back. */
static int check_times(const float *list, uint32_t count, const char *place, struct fault *fault)
{
    for (uint32_t i = 0; i < count; i++) {
        gltf_place at;
        gltf_place_set(at, "%s.input[%" PRIu32 "]", place, i);
        if (!isfinite(list[i])) return fault_set(fault, ERR_NOT_FINITE, at, "a time is not finite");
        if (i > 0 && list[i] < list[i - 1])
            return fault_set(fault, ERR_RANGE, at, "the time goes back from %g to %g",
                             (double)list[i - 1], (double)list[i]);
    }
    return 0;
}

static int read_times(struct gltf *g, const struct sampler *s, struct gltf_key_times *times,
                      struct fault *fault)
{
    if (times->list != NULL && times->accessor == s->input) return 0;
    free(times->list);
    times->list = NULL;
    times->accessor = s->input;
    int rc = gltf_read_floats(g, s->input, 1, &times->count, &times->list, fault);
    if (rc == 0) rc = check_times(times->list, times->count, s->place, fault);
    if (rc == 0) return 0;
    free(times->list);
    times->list = NULL;
    return rc;
}

/* Reads the values of all keys, and finds how many numbers each has. */
static int read_values(struct gltf *g, struct sampler *s, uint32_t targets, uint32_t keys,
                       struct fault *fault)
{
    uint32_t components, count;
    gltf_place at;
    gltf_place_set(at, "%s.output", s->place);
    int rc = gltf_accessor_components(g, s->output, &components, fault);
    if (rc == 0 && (components > 4 || (targets > 0 && components != 1)))
        rc = fault_set(fault, ERR_TYPE, at, "it has %" PRIu32 " components an element", components);
    if (rc == 0) rc = gltf_read_floats(g, s->output, components, &count, &s->keys, fault);
    if (rc != 0) return rc;
    const uint32_t elements = targets > 0 ? targets : 1;
    const uint64_t needed = (uint64_t)keys * elements * (s->curve == CURVE_CUBIC ? 3 : 1);
    s->width = elements * components;
    if (needed == count) return 0;
    return fault_set(fault, ERR_MISMATCH, at,
                     "it has %" PRIu32 " elements, where %" PRIu32 " keys need %" PRIu64, count,
                     keys, needed);
}

/* Returns the last key that is not after the time; the first where all are. */
static uint32_t key_before(const struct gltf_key_times *times, double time_s)
{
    uint32_t low = 0, high = times->count;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if ((double)times->list[middle] <= time_s)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* The value of key k, or its tangent: part 0 is the one in, 1 the value, 2 the tangent out. */
static const float *part_of(const struct sampler *s, uint32_t k, uint32_t part)
{
    const size_t index = s->curve == CURVE_CUBIC ? 3 * (size_t)k + part : k;
    return s->keys + index * s->width;
}

static double dot4(const double a[4], const double b[4])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

static bool normalize4(double q[4])
{
    const double length = sqrt(dot4(q, q));
    if (!(length > 0) || !isfinite(length)) return false;
    for (int i = 0; i < 4; i++) q[i] /= length;
    return true;
}

/* Turns by the shorter way, with constant speed (Shoemake 1985); nearly equal turns are blended. */
static bool slerp(const float *from, const float *to, double u, double out[4])
{
    double a[4], b[4];
    for (int i = 0; i < 4; i++) a[i] = (double)from[i], b[i] = (double)to[i];
    if (!normalize4(a) || !normalize4(b)) return false;
    double cosine = dot4(a, b);
    const double sign = cosine < 0 ? -1 : 1;
    cosine = fmin(1, sign * cosine);
    const double angle = acos(cosine), sine = sin(angle);
    const double wa = sine > 1e-6 ? sin((1 - u) * angle) / sine : 1 - u;
    const double wb = sine > 1e-6 ? sin(u * angle) / sine : u;
    for (int i = 0; i < 4; i++) out[i] = wa * a[i] + sign * wb * b[i];
    return normalize4(out);
}

/* Blends the numbers of two keys, `span_s` apart (glTF 2.0, appendix C). */
static void blend(const struct sampler *s, uint32_t k, double u, double span_s, double *out)
{
    const float *a = part_of(s, k, 1), *b = part_of(s, k + 1, 1);
    if (s->curve == CURVE_LINEAR) {
        for (uint32_t i = 0; i < s->width; i++) out[i] = (1 - u) * (double)a[i] + u * (double)b[i];
        return;
    }
    const float *leave = part_of(s, k, 2), *arrive = part_of(s, k + 1, 0);
    const double u2 = u * u, u3 = u2 * u;
    for (uint32_t i = 0; i < s->width; i++)
        out[i] = (2 * u3 - 3 * u2 + 1) * (double)a[i] +
                 span_s * (u3 - 2 * u2 + u) * (double)leave[i] + (3 * u2 - 2 * u3) * (double)b[i] +
                 span_s * (u3 - u2) * (double)arrive[i];
}

/* Returns whether the value at the time is one: quaternions may vanish. */
static bool evaluate(const struct sampler *s, const struct gltf_key_times *times, double time_s,
                     enum gltf_sampler_kind kind, double *out)
{
    const uint32_t k = key_before(times, time_s);
    const bool inside = time_s > (double)times->list[k] && k + 1 < times->count;
    if (!inside || s->curve == CURVE_STEP) {
        for (uint32_t i = 0; i < s->width; i++) out[i] = (double)part_of(s, k, 1)[i];
        return kind != GLTF_SAMPLED_ROTATION || normalize4(out);
    }
    /* Inside, the next key is after the time, so the span is above 0. */
    const double span_s = (double)times->list[k + 1] - (double)times->list[k];
    const double u = (time_s - (double)times->list[k]) / span_s;
    if (kind == GLTF_SAMPLED_ROTATION && s->curve == CURVE_LINEAR)
        return slerp(part_of(s, k, 1), part_of(s, k + 1, 1), u, out);
    blend(s, k, u, span_s, out);
    return kind != GLTF_SAMPLED_ROTATION || normalize4(out);
}

static int read_at(const struct sampler *s, const struct gltf_key_times *times, double time_s,
                   enum gltf_sampler_kind kind, double **values, uint32_t *count,
                   struct fault *fault)
{
    gltf_place at;
    gltf_place_set(at, "%s.output", s->place);
    if (kind == GLTF_SAMPLED_ROTATION && s->width != 4)
        return fault_set(fault, ERR_TYPE, at, "a rotation has 4 components, not %" PRIu32,
                         s->width);
    *values = calloc(s->width, sizeof **values);
    *count = s->width;
    if (*values == NULL) return fault_set(fault, ERR_MEMORY, at, "no memory for its value");
    const bool exists = evaluate(s, times, time_s, kind, *values);
    for (uint32_t i = 0; i < s->width; i++)
        if (!(fabs((*values)[i]) <= VALUE_MAX))
            return fault_set(fault, ERR_NOT_FINITE, at, "at %g s its value is no number", time_s);
    if (exists) return 0;
    return fault_set(fault, ERR_RANGE, at, "at %g s it is a quaternion of length zero", time_s);
}

int gltf_sampler_read(struct gltf *g, const json_t *sampler, const char *place, double time_s,
                      enum gltf_sampler_kind kind, uint32_t targets, struct gltf_key_times *times,
                      double **values, uint32_t *count, struct fault *fault)
{
    struct sampler s = {.json = sampler, .place = place};
    *values = NULL;
    int rc = read_curve(&s, fault);
    if (rc == 0) rc = read_accessor(g, &s, "input", &s.input, fault);
    if (rc == 0) rc = read_accessor(g, &s, "output", &s.output, fault);
    if (rc == 0) rc = read_times(g, &s, times, fault);
    if (rc == 0) rc = read_values(g, &s, targets, times->count, fault);
    if (rc == 0) rc = read_at(&s, times, time_s, kind, values, count, fault);
    free(s.keys);
    if (rc == 0) return 0;
    free(*values);
    *values = NULL;
    return rc;
}
