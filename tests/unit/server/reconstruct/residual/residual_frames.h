#pragma once
/* Frames of a scene that are filtered together. */
#include "server/reconstruct/residual/residual_window.h"
#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#define WINDOW_WIDTH  96
#define WINDOW_HEIGHT 48
#define WINDOW_AREA   (WINDOW_WIDTH * WINDOW_HEIGHT)

/* A frame of a scene, filtered with those beside it as far as they lie in [first, last]. */
struct window {
    struct residual_scene scene;
    int32_t first, last;
    struct plan plans[5];
    struct motion *motions[5];
    struct residual_history *histories[5];
    struct residual_window read;
};

static const struct rect window_rect = {0, 0, WINDOW_WIDTH, WINDOW_HEIGHT};

/* Frame 0 of a scene of this size, four samples and two frames on each side. */
struct window window_of(void (*show)(const struct residual_scene *, int32_t, int32_t, uint32_t,
                                     struct residual_sample *));

/* As residual_noise, but other noise in each frame. */
float window_noise(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                   uint32_t what);

/* Shows noise of one mean in all components: .85 in the picture. */
void window_show_flat(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out);

/* Takes the histories of the frames around, and closes them. */
void window_open(struct window *w);
void window_close(struct window *w);

/* Filters a block of an open window; `variance` as in residual_filter. Owned by the caller. */
struct residual_picture window_filter(const struct window *w, struct rect block,
                                      const struct residual_variance *variance);
