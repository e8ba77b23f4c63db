#include "server/reconstruct/residual/residual_probe.h"

#include <math.h>
#include <string.h>

#include "proto/error.h"

/* Squares of what is larger would not be finite, nor would their sums. */
#define NOISE_MAX 1e15f

/* Of a component: probes of both halves, before and after a pass. */
enum { PLANES_PROBES = 4 * RESIDUAL_PROBES };

float residual_probe_sign(int32_t x, int32_t y, uint32_t probe)
{
    uint32_t h = (uint32_t)x * 0x9e3779b1u ^ (uint32_t)y * 0x85ebca77u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 13) * 0xc2b2ae3du;
    return (h ^ h >> 16) >> probe & 1u ? 1.0f : -1.0f;
}

float residual_factor(const struct residual_features *f, enum residual_component component,
                      size_t at)
{
    const float *of = component == RESIDUAL_REST ? f->tint : f->albedo;
    const size_t plane = f->shape.plane;
    return (of[at] + of[plane + at] + of[2 * plane + at]) / 3.0f;
}

static void hand_out(struct residual_field *f, struct residual_probes *p)
{
    const size_t planes = RESIDUAL_PROBES * f->features.shape.plane;
    float *next = p->memory;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
        for (int h = 0; h < 2; h++, next += 2 * planes) {
            f->light[c].probe[h] = next;
            f->light[c].probed[h] = next + planes;
        }
    p->noise = next;
}

static float bounded(float v)
{
    return v < NOISE_MAX ? (v > -NOISE_MAX ? v : -NOISE_MAX) : NOISE_MAX;
}

/* Of a pixel's component: the RMS over R, G and B of how far the mean of the halves is off, with
 * the sign of their sum. *half becomes the half that is off: rare light makes the half too bright
 * that has met it. */
static float noise_of(const struct residual_field *f, int component, size_t at, int *half)
{
    const struct residual_light *l = &f->light[component];
    const float share = f->features.share[at];
    float squares = 0.0f, sum = 0.0f, a = 0.0f, b = 0.0f;
    for (size_t c = 0; c < 3; c++) {
        const size_t k = c * f->features.shape.plane + at;
        const float apart = bounded(l->half[0][k] - l->half[1][k]);
        squares += apart * apart;
        sum += apart;
        a += l->half[0][k];
        b += l->half[1][k];
    }
    *half = fabsf(b) > fabsf(a);
    return copysignf(sqrtf(share * (1.0f - share) * squares / 3.0f), sum);
}

static void begin_pixel(struct residual_field *f, int component, size_t at, int32_t x, int32_t y,
                        float *noise)
{
    int half;
    const float spread = f->spread ? f->spread[at] : 1.0f;
    const float size = spread * noise_of(f, component, at, &half);
    float *to = f->light[component].probe[half] + at;
    for (uint32_t k = 0; k < RESIDUAL_SIGNED; k++)
        to[k * f->features.shape.plane] = size * residual_probe_sign(x, y, k);
    *noise = bounded(*noise + size * residual_factor(&f->features, component, at));
}

int residual_probes_create(const struct patch *patch, struct residual_field *field,
                           struct residual_probes *out)
{
    const struct residual_shape *s = &field->features.shape;
    const size_t bytes = (RESIDUAL_COMPONENTS * PLANES_PROBES + 1) * s->plane * sizeof(float);
    out->scratch = patch->scratch;
    out->memory = scratch_take(out->scratch, bytes);
    if (!out->memory) return ERR_MEMORY;
    memset(out->memory, 0, bytes);
    hand_out(field, out);
    for (int32_t y = 0; y < s->height; y++)
        for (int32_t x = 0; x < s->width; x++)
            for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
                begin_pixel(field, c, residual_at(s, x, y), patch->rect.x0 + x, patch->rect.y0 + y,
                            &out->noise[residual_at(s, x, y)]);
    return 0;
}

void residual_probes_fini(struct residual_probes *probes)
{
    scratch_give(probes->scratch, probes->memory);
    probes->memory = NULL;
}

void residual_probes_take_halves(struct residual_field *field)
{
    const size_t plane = field->features.shape.plane;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        const float *a = field->light[c].half[0], *b = field->light[c].half[1];
        float *to = field->light[c].probe[0] + RESIDUAL_SIGNED * plane;
        for (size_t i = 0; i < plane; i++) {
            const float share = field->features.share[i];
            const float apart =
                a[i] - b[i] + (a[plane + i] - b[plane + i]) + (a[2 * plane + i] - b[2 * plane + i]);
            to[i] = sqrtf(share * (1.0f - share)) * bounded(apart / 3.0f);
        }
    }
}

static float picture_of(const struct residual_field *f, const float *direct, const float *indirect,
                        const float *rest, size_t at)
{
    return bounded(residual_factor(&f->features, RESIDUAL_DIRECT, at) * (*direct + *indirect) +
                   residual_factor(&f->features, RESIDUAL_REST, at) * *rest);
}

float residual_probe_after(const struct residual_field *field, uint32_t k, size_t at)
{
    const struct residual_light *l = field->light;
    const size_t i = k * field->features.shape.plane + at;
    return picture_of(field, l[RESIDUAL_DIRECT].probe[0] + i, l[RESIDUAL_INDIRECT].probe[0] + i,
                      l[RESIDUAL_REST].probe[0] + i, at);
}

float residual_probe_before(const struct residual_field *field, uint32_t k, size_t at)
{
    const struct residual_light *l = field->light;
    const size_t i = k * field->features.shape.plane + at;
    return picture_of(field, l[RESIDUAL_DIRECT].probed[0] + i, l[RESIDUAL_INDIRECT].probed[0] + i,
                      l[RESIDUAL_REST].probed[0] + i, at);
}
