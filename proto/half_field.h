#pragma once
/* Light fields at half resolution: which pixels trace rays, and which others these stand for. The
 * worker decides by it which pixels have rays of their own all the same, and reconstruction weighs
 * by it what pixels without rays take (docs/reconstruction.md, Half resolution).
 *
 * Pixels of odd x and odd y, the nodes, trace, and stand for pixels beside them that lie between
 * nodes of one surface. */
#include "proto/surface_match.h"

/* Returns the bounce rays, and rays of glossy lobes, that filters count on for each pixel. */
static inline float half_field_rays(const struct plan *plan)
{
    const float l = (float)plan->indirect_strata_per_axis;
    return plan->field_halved ? 0.25f * l * l : l * l;
}

static inline bool half_field_is_node(int32_t x, int32_t y)
{
    return (x & 1) && (y & 1);
}

/* Returns whether a node lies beside a pixel, so that it may stand for it. Around a pixel that is
 * no node lie two or four, some of which the image may lack. */
static inline bool half_field_is_beside(int32_t x, int32_t y, int32_t node_x, int32_t node_y)
{
    return x - node_x <= 1 && node_x - x <= 1 && y - node_y <= 1 && node_y - y <= 1;
}

/* Returns which half of its samples tells of a pixel's error: halves alternate over nodes as on a
 * chessboard. */
static inline uint32_t half_field_part(int32_t x, int32_t y)
{
    return (uint32_t)((x >> 1) + (y >> 1)) & 1u;
}

/* The least surface_match of a node that stands for a pixel. */
#define HALF_FIELD_MATCH 0.5f

/* Returns how near, in pixels at its distance, a node's bounce rays may meet something before
 * pixels beside it need their own: light changes over a pixel by the square of pixel over distance,
 * which must vanish beside the noise of l x l rays. */
static inline float half_field_near_px(uint32_t l)
{
    return 0.25f * (float)l;
}

/* A glossy lobe, of alpha above 0, at a surface. */
struct half_field_lobe {
    struct shown_surface surface;
    float alpha, stretch; /* the smaller alpha over the larger; 0: round */
    float nearness;       /* of a node: the mean of 1 / distance of its hits */
};

/* Returns how far the views of a pixel's lobe and a node's are apart at what the node sees,
 * squared, over the square of the lobe's smaller width (docs/reconstruction.md, Glossy lobes). It
 * is infinite for lobes of other roughness and for such as are seen at grazing angles. */
float half_field_apart2(const struct surface_view *view, const struct half_field_lobe *pixel,
                        const struct half_field_lobe *node);

/* Returns the largest of these of a node that stands for a pixel. It falls as rays grow. */
static inline float half_field_apart2_most(uint32_t l)
{
    return 4.0f / ((float)l * (float)l);
}
