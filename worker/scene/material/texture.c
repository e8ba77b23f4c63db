#include "worker/scene/material/texture.h"

#include <math.h>
#include <string.h>

void texture_decoding_init(struct texture_decoding *d)
{
    for (int i = 0; i < 256; i++) {
        double v = i / 255.0;
        d->linear[i] = (float)v;
        /* IEC 61966-2-1 */
        d->srgb[i] = (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
}

void texture_init(struct texture *out, const struct scene *blob,
                  const struct scene_texture_ref *ref, const struct texture_decoding *decoding)
{
    memset(out, 0, sizeof *out);
    if (ref->texture == SCENE_NONE) return;
    const struct scene_texture *texture = &blob->textures[ref->texture];
    const struct scene_image *image = &blob->images[texture->image];
    out->texels = scene_image_home(blob, image)->pixels + image->first_byte;
    out->decode = image->flags & IMAGE_IS_SRGB ? decoding->srgb : decoding->linear;
    out->decode_alpha = decoding->linear;
    out->width_px = (int32_t)image->width_px;
    out->height_px = (int32_t)image->height_px;
    out->wrap_u = texture->wrap_u;
    out->wrap_v = texture->wrap_v;
    out->nearest = texture->filter == FILTER_NEAREST;
    out->uv_set = ref->uv_set;
    memcpy(out->transform, ref->transform, sizeof out->transform);
}

/* Maps a coordinate into [0, 1] by a wrap mode. */
static float wrap(float c, uint32_t mode)
{
    if (!(fabsf(c) < TEXTURE_COORDINATE_MAX)) return 0.0f; /* NaN too */
    if (mode == WRAP_CLAMP) return c < 0.0f ? 0.0f : c > 1.0f ? 1.0f : c;
    if (mode == WRAP_MIRROR) {
        float half = c * 0.5f;
        float phase = 2.0f * (half - floorf(half));
        return phase > 1.0f ? 2.0f - phase : phase;
    }
    return c - floorf(c);
}

/* Brings a texel index from [-1, size] inside. Repetition goes around the edge; the other modes
 * take the edge texel, which is also what a mirror shows there. */
static int32_t inside(int32_t i, int32_t size, uint32_t mode)
{
    if (i < 0) return mode == WRAP_REPEAT ? size - 1 : 0;
    if (i >= size) return mode == WRAP_REPEAT ? 0 : size - 1;
    return i;
}

static size_t texel(const struct texture *t, int32_t x, int32_t y)
{
    return (size_t)y * (size_t)t->width_px + (size_t)x;
}

static void sample_nearest(const struct texture *t, float u, float v, float out[4])
{
    int32_t x = inside((int32_t)(u * (float)t->width_px), t->width_px, t->wrap_u);
    int32_t y = inside((int32_t)(v * (float)t->height_px), t->height_px, t->wrap_v);
    texture_decode(t, texel(t, x, y), out);
}

static void sample_bilinear(const struct texture *t, float u, float v, float out[4])
{
    float x = u * (float)t->width_px - 0.5f, y = v * (float)t->height_px - 0.5f;
    int32_t left = (int32_t)(x + 1.0f) - 1, top = (int32_t)(y + 1.0f) - 1; /* x, y > -1: floor */
    float fx = x - (float)left, fy = y - (float)top;
    int32_t x0 = inside(left, t->width_px, t->wrap_u);
    int32_t x1 = inside(left + 1, t->width_px, t->wrap_u);
    int32_t y0 = inside(top, t->height_px, t->wrap_v);
    int32_t y1 = inside(top + 1, t->height_px, t->wrap_v);
    const size_t at[4] = {texel(t, x0, y0), texel(t, x1, y0), texel(t, x0, y1), texel(t, x1, y1)};
    texture_blend(t, at, fx, fy, out);
}

void texture_sample(const struct texture *t, float u, float v, float out[4])
{
    const float *m = t->transform;
    float wrapped_u = wrap(m[0] * u + m[1] * v + m[2], t->wrap_u);
    float wrapped_v = wrap(m[3] * u + m[4] * v + m[5], t->wrap_v);
    if (t->nearest)
        sample_nearest(t, wrapped_u, wrapped_v, out);
    else
        sample_bilinear(t, wrapped_u, wrapped_v, out);
}

float texture_min_alpha(const struct texture *t)
{
    size_t count = (size_t)t->width_px * (size_t)t->height_px;
    uint8_t least = 255;
    for (size_t i = 0; i < count; i++)
        if (t->texels[4 * i + 3] < least) least = t->texels[4 * i + 3];
    return t->decode_alpha[least];
}

void texture_mean(const struct texture *t, float out[3])
{
    size_t count = (size_t)t->width_px * (size_t)t->height_px;
    double sum[3] = {0, 0, 0};
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++) sum[c] += (double)t->decode[t->texels[4 * i + c]];
    for (int c = 0; c < 3; c++) out[c] = (float)(sum[c] / (double)count);
}
