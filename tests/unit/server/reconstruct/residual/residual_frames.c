#include "tests/unit/server/reconstruct/residual/residual_frames.h"

static struct residual_scene scene_at(const struct window *w, int32_t steps)
{
    struct residual_scene s = w->scene;
    s.frame += steps;
    return s;
}

static struct motion *motion_of(const struct residual_scene *s)
{
    struct motion *m;
    if (s->pan == 0) return NULL;
    assert_int_equal(motion_create(2, &m), 0);
    for (int side = 0; side < MOTION_SIDES; side++) {
        struct residual_scene other = *s;
        other.frame += side == MOTION_BACKWARD ? -1 : 1;
        m->camera[side] = residual_scene_plan(&other).camera;
    }
    return m;
}

/* Histories are taken in two parts. */
void window_open(struct window *w)
{
    for (int32_t k = -2; k <= 2; k++) {
        const struct residual_scene s = scene_at(w, k);
        const int32_t half = s.width / 2 + 3;
        const struct rect parts[2] = {{0, 0, half, s.height}, {half, 0, s.width, s.height}};
        w->plans[k + 2] = residual_scene_plan(&s);
        w->motions[k + 2] = motion_of(&s);
        assert_int_equal(
            residual_history_create(&w->plans[k + 2], w->motions[k + 2], &w->histories[k + 2]), 0);
        for (int i = 0; i < 2; i++) {
            struct patch *patch = residual_scene_patch(&s, parts[i]);
            assert_int_equal(residual_history_take(w->histories[k + 2], 0, patch), 0);
            patch_destroy(&patch);
        }
    }
    w->read = (struct residual_window){.plan = &w->plans[2], .motion = w->motions[2]};
    for (int side = 0; side < MOTION_SIDES; side++)
        for (int32_t k = 1; k <= (int32_t)w->scene.temporal; k++) {
            const int32_t steps = side == MOTION_BACKWARD ? -k : k, at = w->scene.frame + steps;
            if (at < w->first || at > w->last) break;
            w->read.frames[side][w->read.count[side]++] = w->histories[steps + 2];
        }
}

void window_close(struct window *w)
{
    for (int k = 0; k < 5; k++) {
        residual_history_drop(&w->histories[k]);
        motion_drop(&w->motions[k]);
    }
}

/* Filters a block; `variance` as in residual_filter. */
struct residual_picture window_filter(const struct window *w, struct rect block,
                                      const struct residual_variance *variance)
{
    struct residual_picture picture;
    struct residual_statistics statistics = {0};
    const struct rect all = {0, 0, w->scene.width, w->scene.height};
    struct patch *patch = residual_scene_patch(
        &w->scene, rect_intersect(rect_grow(block, residual_halo_px(&w->plans[2])), all));
    patch->window = &w->read;
    assert_int_equal(residual_filter(patch, block, variance, &picture, &statistics), 0);
    patch_destroy(&patch);
    return picture;
}

struct window window_of(void (*show)(const struct residual_scene *, int32_t, int32_t, uint32_t,
                                     struct residual_sample *))
{
    return (struct window){.scene = {.width = WINDOW_WIDTH,
                                     .height = WINDOW_HEIGHT,
                                     .spp = 4,
                                     .show = show,
                                     .temporal = 2},
                           .first = -2,
                           .last = 2};
}

float window_noise(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                   uint32_t what)
{
    return residual_noise(x, y, sample, what + 100u * (uint32_t)(s->frame + 10));
}

void window_show_flat(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    residual_grey(window_noise(s, x, y, sample, 1), out->direct);
    residual_grey(0.5f * window_noise(s, x, y, sample, 2), out->indirect);
    residual_grey(0.1f * window_noise(s, x, y, sample, 3), out->rest);
    out->alpha = 0.3f;
}
