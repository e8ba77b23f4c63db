/* Samples of other frames: what finds them, what refuses them, and what they are worth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_frames.h"

/* RMS of what differs from a number, in the red of what is filtered. */
static double rms_from(const struct residual_picture *p, double truth)
{
    double sum = 0;
    const size_t area = (size_t)rect_area(p->block);
    for (size_t i = 0; i < area; i++) sum += pow((double)p->radiance[0][i] - truth, 2);
    return sqrt(sum / (double)area);
}

static double error_of(struct window *w, double truth)
{
    window_open(w);
    struct residual_picture p = window_filter(w, window_rect, NULL);
    const double error = rms_from(&p, truth);
    residual_picture_fini(&p);
    window_close(w);
    return error;
}

/* Five times the samples of noise that knows nothing of itself leave 1 / root 5 of the error; the
 * test of means refuses some of it. */
TEST(more_frames_have_less_noise)
{
    struct window w = window_of(window_show_flat);
    const double five = error_of(&w, 0.85);
    w.first = w.last = 0;
    const double one = error_of(&w, 0.85);
    w.first = -1, w.last = 1;
    const double three = error_of(&w, 0.85);
    w.first = 0, w.last = 2; /* the window of a first frame */
    const double ahead = error_of(&w, 0.85);
    printf("# %.4f, three frames %.4f, ahead %.4f, five %.4f\n", one, three, ahead, five);
    assert_true(five < 0.6 * one && three < 0.75 * one && ahead < 0.75 * one);
    assert_true(five < three);
}

/* Whatever the blocks, and whatever they are in a picture's middle. */
TEST(pixels_do_not_depend_on_blocks)
{
    struct window w = window_of(window_show_flat);
    w.scene.width = 220, w.scene.pan = 3;
    window_open(&w);
    struct residual_picture all = window_filter(&w, (struct rect){0, 0, 220, WINDOW_HEIGHT}, NULL);
    struct residual_picture part = window_filter(&w, (struct rect){97, 5, 131, 40}, NULL);
    for (int32_t y = 5; y < 40; y++)
        for (int c = 0; c < 3; c++)
            assert_memory_equal(part.radiance[c] + residual_picture_at(&part, 97, y),
                                all.radiance[c] + residual_picture_at(&all, 97, y),
                                34 * sizeof(float));
    residual_picture_fini(&part);
    residual_picture_fini(&all);
    window_close(&w);
}

/* Without frames beside it a frame is what it is without a window, to the last bit. */
TEST(a_window_of_none_changes_nothing)
{
    struct window w = window_of(window_show_flat);
    w.first = w.last = 0;
    window_open(&w);
    struct residual_picture p = window_filter(&w, window_rect, NULL);
    w.scene.temporal = 0;
    struct residual_picture alone = residual_scene_filter_all(&w.scene);
    const size_t bytes = WINDOW_AREA * sizeof(float);
    for (int c = 0; c < 3; c++) assert_memory_equal(p.radiance[c], alone.radiance[c], bytes);
    residual_picture_fini(&alone);
    residual_picture_fini(&p);
    window_close(&w);
}

/* -- joining, pixel by pixel -- */

struct joined {
    struct patch *patch;
    struct residual_field field;
};

static struct joined join(const struct window *w)
{
    struct joined j = {.patch = residual_scene_patch(&w->scene, window_rect)};
    j.patch->window = &w->read;
    assert_int_equal(residual_field_create(j.patch, &j.field), 0);
    return j;
}

static void joined_fini(struct joined *j)
{
    residual_field_fini(&j->field);
    patch_destroy(&j->patch);
}

static float own_at(const struct joined *j, int32_t x, int32_t y)
{
    return j->field.own[residual_at(&j->field.features.shape, x, y)];
}

/* Light that tells in which place of the world it is, without noise but for its halves. */
static void show_ramp(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                      struct residual_sample *out)
{
    const float place = (float)(x + s->pan * s->frame);
    residual_grey(4.0f + 0.25f * place + (sample % 4 < 2 ? 8.0f : -8.0f), out->direct);
    out->id = y < WINDOW_HEIGHT / 2 ? 1 : 2;
}

TEST(samples_are_fetched_where_things_have_gone)
{
    struct window w = window_of(show_ramp);
    w.scene.pan = 3;
    window_open(&w);
    struct joined j = join(&w);
    for (int32_t x = 0; x < WINDOW_WIDTH; x++) {
        const size_t at = residual_at(&j.field.features.shape, x, 10);
        /* Frames behind saw what is left of here, those ahead what is right, by 3 pixels each. */
        const int lack = (x >= WINDOW_WIDTH - 3) + (x >= WINDOW_WIDTH - 6) + (x < 3) + (x < 6);
        const float a = j.field.light[RESIDUAL_DIRECT].half[0][at];
        const float b = j.field.light[RESIDUAL_DIRECT].half[1][at];
        if (fabsf(a - (12.0f + 0.25f * (float)x)) > 1e-3f || fabsf(b - (a - 16.0f)) > 1e-3f ||
            fabsf(own_at(&j, x, 10) - 1.0f / (float)(5 - lack)) > 1e-3f)
            fail_msg("column %d: halves %g and %g, own %g", x, (double)a, (double)b,
                     (double)own_at(&j, x, 10));
    }
    joined_fini(&j);
    window_close(&w);
}

/* What differs in one of these from frame to frame is no history: another instance, and under a
 * camera that moves another normal, another depth, another mixture of depths in the pixel; or there
 * is nothing at all. */
static int differing;
static void show_other(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                       struct residual_sample *out)
{
    window_show_flat(s, x, y, sample, out);
    if (s->frame == 0) return;
    switch (differing) {
    case 0:
        out->id = 2;
        break;
    case 1:
        out->normal[0] = 0.5f, out->normal[2] = 0.8660254f;
        break;
    case 2:
        out->distance = 9.0f;
        break;
    case 3:
        out->distance = sample == 0 ? 5.0f : 7.0f;
        break;
    default:
        out->hits = false;
    }
}

TEST(other_surfaces_are_refused)
{
    for (differing = 0; differing < 5; differing++) {
        struct window w = window_of(show_other);
        w.scene.pan = differing > 0 && differing < 4 ? 1 : 0;
        window_open(&w);
        struct joined j = join(&w);
        for (int32_t y = 0; y < WINDOW_HEIGHT; y++)
            for (int32_t x = 0; x < WINDOW_WIDTH; x++)
                if (own_at(&j, x, y) != 1.0f)
                    fail_msg("case %d: pixel %d, %d has samples of others", differing, x, y);
        joined_fini(&j);
        window_close(&w);
    }
}

/* Reflections of smooth surfaces go where the eye goes. */
TEST(smooth_lobes_are_refused_when_the_eye_moves)
{
    struct window w = window_of(window_show_flat);
    window_open(&w);
    w.histories[1]->plan.camera.forward[0] = 0.2f; /* as an eye far away that went round */
    w.read.count[MOTION_FORWARD] = 0, w.read.count[MOTION_BACKWARD] = 1;
    struct joined j = join(&w);
    for (int k = 0; k < 2; k++) {
        const float alpha = k ? 0.05f : 0.5f;
        for (size_t i = 0; i < WINDOW_AREA; i++) {
            w.histories[1]->pixels[i].alpha = alpha;
            j.patch->path_alpha[i] = 4 * alpha;
        }
        residual_field_fini(&j.field);
        assert_int_equal(residual_field_create(j.patch, &j.field), 0);
        struct patch *alone = residual_scene_patch(&w.scene, window_rect);
        struct residual_field field;
        assert_int_equal(residual_field_create(alone, &field), 0);
        size_t changed = 0;
        for (int32_t y = 0; y < WINDOW_HEIGHT; y++)
            for (int32_t x = 0; x < WINDOW_WIDTH; x++) {
                const size_t at = residual_at(&field.features.shape, x, y);
                changed += j.field.light[RESIDUAL_REST].half[0][at] !=
                           field.light[RESIDUAL_REST].half[0][at];
            }
        if (k) assert_int_equal(changed, 0);
        if (!k) assert_true(changed > WINDOW_AREA / 2);
        residual_field_fini(&field);
        patch_destroy(&alone);
    }
    joined_fini(&j);
    window_close(&w);
}
