#include "worker/scene/photograph.h"

#include <math.h>

#include "worker/shade/elementary.h"

void photograph_init(struct photograph *p, const struct plan *plan,
                     const struct environment_blob *blob)
{
    const struct environment_header *h = blob->header;
    *p = (struct photograph){.plan = plan,
                             .texels = blob,
                             .across = (float)h->width_px / (float)plan->width_px,
                             .down = (float)h->height_px / (float)plan->height_px};
    if (plan->photograph.fit == PHOTOGRAPH_COVERS)
        p->across = p->down = p->across < p->down ? p->across : p->down;
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool photograph_find(const struct photograph *p, const float point[3], float to[3], float *distance,
                     float *px, float *py)
{
    const struct plan_camera *c = &p->plan->camera;
    const float width = (float)p->plan->width_px, height = (float)p->plan->height_px;
    const float way[3] = {point[0] - c->eye[0], point[1] - c->eye[1], point[2] - c->eye[2]};
    const float ahead = dot(way, c->forward);
    if (!(ahead > 0.0f)) return false;
    const bool flat = c->type == CAMERA_ORTHOGRAPHIC;
    const float a = dot(way, c->right) / (flat ? 1.0f : ahead);
    const float b = dot(way, c->up) / (flat ? 1.0f : ahead);
    *px = 0.5f * width * (a / c->half_width + c->centre_x + 1.0f);
    *py = 0.5f * height * (1.0f - c->centre_y - b / c->half_height);
    *distance = flat ? ahead : sqrtf(dot(way, way));
    for (int k = 0; k < 3; k++) to[k] = flat ? -c->forward[k] : -way[k] / *distance;
    return *px >= 0.0f && *px <= width && *py >= 0.0f && *py <= height;
}

/* The two texels of one axis around a place, and the share of the second. */
static void find_texels(float at, uint32_t count, uint32_t out[2], float *share)
{
    const float last = (float)(count - 1);
    at = at > 0.0f ? (at < last ? at : last) : 0.0f;
    out[0] = (uint32_t)at;
    out[1] = out[0] + 1 < count ? out[0] + 1 : out[0];
    *share = at - (float)out[0];
}

/* IEC 61966-2-1, to the same bits on every CPU. */
static float encode(float linear)
{
    if (linear >= 1.0f) return 1.0f;
    if (linear <= 0.0031308f) return 12.92f * linear;
    return 1.055f * elementary_exp(elementary_log(linear) / 2.4f) - 0.055f;
}

void photograph_read(const struct photograph *p, float px, float py, float out[3])
{
    const uint32_t width = p->texels->header->width_px, height = p->texels->header->height_px;
    uint32_t x[2], y[2];
    float s, t;
    /* The middles of both lie on each other. */
    px -= 0.5f * (float)p->plan->width_px;
    py -= 0.5f * (float)p->plan->height_px;
    find_texels(0.5f * (float)width + px * p->across - 0.5f, width, x, &s);
    find_texels(0.5f * (float)height + py * p->down - 0.5f, height, y, &t);
    out[0] = out[1] = out[2] = 0.0f;
    for (int k = 0; k < 4; k++) {
        const float *texel = p->texels->texels + 3 * ((size_t)y[k / 2] * width + x[k % 2]);
        const float weight = (k % 2 ? s : 1.0f - s) * (k / 2 ? t : 1.0f - t);
        for (int c = 0; c < 3; c++)
            out[c] += weight * (p->plan->photograph.is_linear ? encode(texel[c]) : texel[c]);
    }
}
