#pragma once
/* Pixels in the coordinates of a rectangle light (docs/reconstruction.md, Receiver coordinates).
 *
 * Each axis i of a light has a half-side L_i of its own and with it its own sigma_y,i and widths.
 * Slopes, and therefore eta, belong to the pixel, whatever the axis. Points are relative to the
 * eye, along the world's axes, so that large coordinates cost no precision. */
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/patch/surface.h"
#include "server/reconstruct/shadow/coverage.h"
#include "server/reconstruct/shadow/shadow_kernels.h"

struct receiver_light {
    const struct plan *plan; /* borrowed */
    uint32_t index;
    uint32_t strata; /* l */
    struct shadow_rectangle rectangle;
    float sigma_y[2]; /* standard deviation of the profile: L/sqrt 3 uniform, L/2 Gaussian */
    struct surface_view view;
};

/* Takes light `index` of the plan, which must be a rectangle. The plan is borrowed. */
void receiver_light_init(struct receiver_light *light, const struct plan *plan, uint32_t index);

/* Computes points and normals of `count` pixels of the patch from image pixel (x, y) on, which lie
 * in one row of it. The normal is 0 where there is no surface. */
void receiver_row(const struct receiver_light *light, const struct patch *patch, int32_t x,
                  int32_t y, uint32_t count, float *const point[3], float *const normal[3]);

/* Computes how much of the light's height lies below the horizons of `count` receivers: 0 none, 1
 * all. Strata there have no rays and count as seen. */
void receiver_sunk(const struct receiver_light *light, const float *const point[3],
                   const float *const normal[3], uint32_t count, float *sunk);

/* All pixels of `rect`, which may pass the patch: beyond it there are no surfaces. */
struct receivers {
    struct rect rect;
    struct shadow_pixels pixels; /* without wedges, walks and slots at first */
    struct scratch *scratch;     /* the patch's */
    void *memory;                /* owned; from there */
};

/* Places the receivers of a rect. ERR_MEMORY. */
int receivers_create(const struct receiver_light *light, const struct patch *patch,
                     const struct shadow_kernels *kernels, struct rect rect, struct receivers *out);
void receivers_fini(struct receivers *receivers);

/* Returns the index of image pixel (x, y), which lies in the rect. */
static inline size_t receivers_pixel(const struct receivers *r, int32_t x, int32_t y)
{
    return (size_t)(y - r->rect.y0) * (size_t)rect_width(r->rect) + (size_t)(x - r->rect.x0);
}

/* Computes e_i of docs/reconstruction.md, Receiver coordinates: how many pixels along x and y lit
 * pixel i moves on the screen for each scene unit of Delta_i. The results are finite. */
void receiver_steps(const struct receiver_light *light, const struct shadow_pixels *pixels,
                    size_t i, float steps[2][2]);

/* Returns the world size of a pixel at a receiver. */
static inline float receiver_size(float plane_min)
{
    return 0.5f * plane_min;
}

static inline float receiver_pixel(const struct shadow_pixels *pixels, size_t i)
{
    return receiver_size(pixels->plane_min[i]);
}

static inline bool receiver_is_lit(const struct shadow_pixels *pixels, size_t i)
{
    const float x = pixels->normal[0][i], y = pixels->normal[1][i], z = pixels->normal[2][i];
    return x * x + y * y + z * z > 0.0f;
}
