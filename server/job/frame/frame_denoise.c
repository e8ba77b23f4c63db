/* Frames that Open Image Denoise filters. It needs all of a frame at once, so blocks are drawn with
 * plain means first, and what paths bring is kept beside. When the last block is drawn a thread of
 * the pool filters that, and the picture changes on the loop's thread. */
#include <string.h>

#include "proto/runtime/clock.h"
#include "server/job/frame/frame_work.h"

int frame_denoise_create(struct frame *f)
{
    struct frame_denoise *d = &f->denoise;
    if (f->plan.residual_filter != RESIDUAL_FILTER_OIDN) return 0;
    d->frame = f;
    d->library = oidn_library_get(&d->fault);
    if (!d->library) return d->fault.code;
    return oidn_picture_create(f->plan.width_px, f->plan.height_px, &d->left);
}

void frame_denoise_destroy(struct frame *f)
{
    oidn_picture_fini(&f->denoise.left);
}

void frame_denoise_keep(struct frame *f, const struct patch *patch, struct rect rect)
{
    if (frame_has_denoiser(f)) oidn_picture_put(patch, rect, &f->denoise.left);
}

static void find_beauty(const struct frame *f, const struct plane *rgb[3])
{
    static const char *const names[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; c++) rgb[c] = image_plane(f->image, names[c]);
}

/* From version 2.3 on the library works on a thread of its device, which is new and ours alone. It
 * calls this from there, at the end, too. */
static bool is_wanted(void *ctx, double share)
{
    struct frame *f = ctx;
    (void)share;
    if (!pthread_equal(pthread_self(), f->denoise.caller)) f->denoise.beside_us = thread_cpu_us();
    return !atomic_load(&f->dropped);
}

/* No block is out any more: the picture stays as it is until this is over. */
static void denoise_run(struct pool_task *task)
{
    struct frame_denoise *d = (struct frame_denoise *)task;
    const struct oidn_call call = {d->library, is_wanted, d->frame};
    const struct plane *rgb[3];
    if (atomic_load(&d->frame->dropped)) return;
    find_beauty(d->frame, rgb);
    d->caller = pthread_self();
    d->beside_us = 0;
    d->error = oidn_filter(&call, &d->left, rgb, &d->fault);
}

static void show(struct frame *f)
{
    const struct oidn_picture *p = &f->denoise.left;
    const size_t width = (size_t)p->width_px, area = width * (size_t)p->height_px;
    const struct plane *rgb[3];
    find_beauty(f, rgb);
    for (size_t c = 0; c < 3; c++)
        for (int32_t y = 0; y < p->height_px; y++)
            memcpy(plane_row(rgb[c], y), p->albedo + c * area + (size_t)y * width,
                   width * sizeof(float));
    f->options.metadata.denoiser = f->denoise.library->label;
    f->denoise.is_shown = true;
}

static void denoise_over(struct frame *f)
{
    struct frame_denoise *d = &f->denoise;
    f->statistics.oidn_cpu_us += d->task.cpu_us + d->beside_us;
    if (d->error) {
        frame_fail(f, d->error, d->fault.pointer, d->fault.detail);
        return;
    }
    show(f);
    oidn_picture_fini(&d->left);
    f->tasks++; /* held: the owner may drop the frame */
    frame_encode(f);
    const struct rect all = {0, 0, f->plan.width_px, f->plan.height_px};
    if (frame_task_over(f)) f->options.events.drawn(f->options.events.ctx, f, all);
}

static void denoise_done(struct pool_task *task)
{
    struct frame *f = ((struct frame_denoise *)task)->frame;
    if (frame_task_over(f)) denoise_over(f);
}

void frame_denoise_end(struct frame *f)
{
    if (!frame_has_denoiser(f)) {
        frame_encode(f);
        return;
    }
    f->denoise.task = (struct pool_task){.run = denoise_run, .done = denoise_done};
    frame_task_submit(f, &f->denoise.task);
}
