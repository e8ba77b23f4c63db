#pragma once
/* A frame's samples as the residual filter of other frames reads them: unfiltered halves of its
 * light, demodulated, and what identifies the surfaces that pixels show. */
#include "server/reconstruct/motion/motion.h"
#include "server/reconstruct/residual/residual_field.h"

enum { RESIDUAL_HISTORY_LIGHT = 3 * RESIDUAL_COMPONENTS };

/* What other frames know of a pixel. */
struct residual_past {
    float half[2][RESIDUAL_HISTORY_LIGHT]; /* R, G, B of each component, as in residual_light, but
                                              that the rest is all that is scattered */
    float at[3];                           /* where the pixel's centre looks, in the world */
    float normal[3];                       /* there */
    float mixture; /* distance of what the samples meet, in the mean, over that of the centre */
    float seen;    /* share of the samples that meet a surface */
    float mean_normal[3], albedo[3], tint[3], nearness, alpha; /* as in residual_features */
    uint32_t id; /* 1 + the instance; 0: there is nothing to use */
};

struct residual_history {
    struct plan plan;             /* of the frame */
    struct motion *motion;        /* held: how it moves; NULL: nothing does */
    struct residual_past *pixels; /* owned; of the whole picture, row by row, view by view */
    uint32_t holders;
};

/* Creates the history of a frame that shows nothing yet, with one holder. ERR_MEMORY. */
int residual_history_create(const struct plan *plan, struct motion *motion,
                            struct residual_history **out);

/* Returns the bytes that a pixel takes. */
static inline uint64_t residual_history_pixel_bytes(void)
{
    return sizeof(struct residual_past);
}

/* Holders are counted by one thread. The last that drops a history frees it. */
struct residual_history *residual_history_hold(struct residual_history *history);
void residual_history_drop(struct residual_history **history);

/* Returns what a view (enum plan_view) of the frame has of a pixel of the picture. */
static inline struct residual_past *residual_history_at(const struct residual_history *history,
                                                        uint32_t view, int32_t x, int32_t y)
{
    const size_t width = (size_t)history->plan.width_px, height = (size_t)history->plan.height_px;
    return &history->pixels[(view * height + (size_t)y) * width + (size_t)x];
}

/* Sets the pixels of the patch of a view, which has depth, normal, id and the planes of the
 * residual filter. Any thread may do this, for pixels of its own. ERR_MEMORY. */
int residual_history_take(struct residual_history *history, uint32_t view,
                          const struct patch *patch);
