/* An image becomes files: EXR and PNG, from the top as rows become final, stored by their digests.
 */
#include "proto/job/job.h"
#include "server/job/frame/frame_work.h"

/* Returns the layer that people look at: the composite, beauty, or the first that was asked for. */
static const char *shown_layer(const struct frame *f)
{
    uint32_t layers = f->options.layers;
    if (layers & LAYER_COMPOSITE) return layer_name(LAYER_COMPOSITE);
    return layer_name((enum layer)(layers & (~layers + 1u)));
}

void frame_files_init(struct frame *f)
{
    for (int k = 0; k < PICTURE_FILE_COUNT; k++) {
        struct frame_file *file = &f->files.of[k];
        const char *layer = shown_layer(f);
        file->frame = f;
        file->picture =
            (struct picture_file){.kind = (enum picture_file_kind)k,
                                  .image = f->image,
                                  .metadata = &f->options.metadata,
                                  .layer = layer,
                                  .png_options = png_options_of_layer(&f->options.png, layer),
                                  .objects = f->options.objects};
    }
}

void frame_files_drop(struct frame *f)
{
    for (int k = 0; k < PICTURE_FILE_COUNT; k++) {
        struct frame_file *file = &f->files.of[k];
        picture_file_drop(&file->picture);
        if (file->is_held) objects_release(f->options.objects, &file->digest);
        file->is_held = false;
    }
}

static void file_run(struct pool_task *task)
{
    struct frame_file *file = (struct frame_file *)task;
    if (atomic_load(&file->frame->dropped)) return;
    file->fault = (struct fault){0};
    file->error = file->is_last ? picture_file_finish(&file->picture, &file->digest, &file->fault)
                                : picture_file_write(&file->picture, file->end, &file->fault);
    file->is_held = file->is_last && !file->error;
}

/* Reports a file that could not be stored. A drawn picture is not given up for a disk that is full
 * for now. */
static void unstored(struct frame *f, const struct frame_file *file)
{
    const int error = file->error;
    const bool passes = error == ERR_NO_SPACE || error == ERR_IO || error == ERR_MEMORY;
    struct fault fault;
    if (!passes || !f->options.events.unstored) {
        frame_fail(f, error, file->fault.pointer, file->fault.detail);
        return;
    }
    fault_set(&fault, error, "", "frame %d: %s", f->options.number, file->fault.detail);
    f->options.events.unstored(f->options.events.ctx, f, &fault);
}

/* Counts the wall time of a frame's files. Those of a frame that is kept wait for a request and not
 * for tiles. */
static void count_wall(struct frame *f)
{
    const uint64_t now_us = frame_clock_us();
    if (f->options.kept) return;
    f->statistics.frames_wall_us += now_us - f->begun_us;
    f->statistics.drawn_late_us += f->drawn_us - f->arrived_us;
    f->statistics.stored_late_us += now_us - f->arrived_us;
}

/* Both are stored, or the first one that is not; while one is out, neither. */
static void conclude(struct frame *f)
{
    const struct frame_file *failed = NULL;
    for (int k = PICTURE_FILE_COUNT - 1; k >= 0; k--) {
        const struct frame_file *file = &f->files.of[k];
        if (file->is_out) return;
        if (file->error) failed = file;
    }
    f->files.closing = false;
    if (failed) {
        unstored(f, failed);
        return;
    }
    count_wall(f);
    frame_state_go(&f->state, FRAME_FINISHED);
    for (int k = 0; k < PICTURE_FILE_COUNT; k++) f->files.of[k].is_held = false;
    f->options.events.encoded(f->options.events.ctx, f, &f->files.of[PICTURE_FILE_EXR].digest,
                              &f->files.of[PICTURE_FILE_PNG].digest);
}

/* Ends a task of a file. A file that failed before the end is tried again there, from the top. */
static void file_over(struct frame *f, struct frame_file *file)
{
    f->statistics.encode_cpu_us += file->task.cpu_us;
    file->is_stored = file->is_last && !file->error;
    if (file->error && !file->is_last) file->waits = true;
    if (f->files.closing && file->is_last)
        conclude(f);
    else
        frame_files_feed(f);
}

static void file_done(struct pool_task *task)
{
    struct frame_file *file = (struct frame_file *)task;
    file->is_out = false;
    if (frame_task_over(file->frame)) file_over(file->frame, file);
}

static void submit(struct frame *f, struct frame_file *file, int32_t end)
{
    file->end = end;
    file->is_last = f->files.closing;
    file->error = 0;
    file->is_out = true;
    file->task = (struct pool_task){.run = file_run, .done = file_done};
    frame_task_submit(f, &file->task);
}

void frame_files_feed(struct frame *f)
{
    const bool closing = f->files.closing;
    const int32_t end = closing ? f->plan.height_px : frame_rows_done(f);
    if (!closing && (f->options.kept || frame_has_rounds(f) || frame_has_denoiser(f))) return;
    for (int k = 0; k < PICTURE_FILE_COUNT; k++) {
        struct frame_file *file = &f->files.of[k];
        if (file->is_out || file->is_stored) continue;
        if (closing ? !file->is_last || file->error : !file->waits && end > file->end)
            submit(f, file, end);
    }
}

bool frame_is_complete(const struct frame *f)
{
    return f->complete;
}

void frame_encode(struct frame *f)
{
    f->drawn_us = frame_clock_us();
    if (!f->options.kept) {
        frame_store(f);
        return;
    }
    f->complete = true;
    f->options.events.completed(f->options.events.ctx, f);
}

void frame_store(struct frame *f)
{
    if (f->state != FRAME_ENCODING) frame_state_go(&f->state, FRAME_ENCODING);
    f->files.closing = true;
    frame_files_feed(f);
}
