/* A finished image becomes files: EXR and PNG, stored by their digests. */
#include <stdio.h>
#include <stdlib.h>

#include "proto/job.h"
#include "server/image/png.h"
#include "server/job/frame_work.h"

struct encode_task {
    struct team_task task;
    struct frame *frame;
    struct digest exr, png;
    struct fault fault;
    int error;
};

static int store_exr(struct encode_task *t)
{
    const struct frame *f = t->frame;
    char dir[OBJECTS_PATH_BYTES], path[OBJECTS_PATH_BYTES + 16];
    int error = objects_make_dir(f->options.objects, dir);
    if (error) return fault_set(&t->fault, error, "", "no folder to write the picture in");
    snprintf(path, sizeof path, "%s/image.exr", dir);
    error = exr_write(path, f->image, &f->options.metadata, &t->fault);
    if (!error && (error = objects_adopt(f->options.objects, path, &t->exr)) != 0)
        fault_set(&t->fault, error, "", "the EXR file could not be stored");
    objects_remove_dir(dir);
    return error;
}

/* The layer that people look at: beauty, or the first that was asked for. */
static const char *shown_layer(const struct frame *f)
{
    uint32_t layers = f->options.layers;
    return layer_name((enum layer)(layers & (~layers + 1u)));
}

static int store_png(struct encode_task *t)
{
    const struct frame *f = t->frame;
    struct object_writer *writer = NULL;
    uint8_t *bytes = NULL;
    size_t size_bytes = 0;
    bool existed;
    int error = png_encode(f->image, shown_layer(f), 0, &bytes, &size_bytes);
    if (!error) error = object_writer_begin(f->options.objects, &writer);
    if (!error) error = object_writer_append(writer, bytes, size_bytes);
    if (!error) error = object_writer_finish(&writer, NULL, &t->png, &existed);
    if (error) fault_set(&t->fault, error, "", "the PNG file could not be stored");
    if (writer) object_writer_abort(&writer);
    free(bytes);
    return error;
}

static void encode_run(struct team_task *task)
{
    struct encode_task *t = (struct encode_task *)task;
    if (atomic_load(&t->frame->dropped)) return;
    t->error = store_exr(t);
    if (!t->error) t->error = store_png(t);
}

/* A picture that is drawn is not given up for a disk that is full today. */
static void unstored(struct frame *f, struct encode_task *t)
{
    const bool passes = t->error == ERR_NO_SPACE || t->error == ERR_IO || t->error == ERR_MEMORY;
    struct fault fault;
    if (!passes || !f->options.events.unstored) {
        frame_fail(f, t->error, t->fault.pointer, t->fault.detail);
        return;
    }
    fault_set(&fault, t->error, "", "frame %d: %s", f->options.number, t->fault.detail);
    f->options.events.unstored(f->options.events.ctx, f, &fault);
}

static void encode_done(struct team_task *task)
{
    struct encode_task *t = (struct encode_task *)task;
    struct frame *f = t->frame;
    if (frame_task_over(f)) {
        f->statistics.encode_cpu_us += t->task.cpu_us;
        if (t->error) {
            unstored(f, t);
        } else {
            frame_state_go(&f->state, FRAME_FINISHED);
            f->options.events.encoded(f->options.events.ctx, f, &t->exr, &t->png);
        }
    }
    free(t);
}

bool frame_is_complete(const struct frame *f)
{
    return f->complete;
}

void frame_encode(struct frame *f)
{
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
    struct encode_task *t = calloc(1, sizeof *t);
    if (!t) {
        struct encode_task none = {.error = ERR_MEMORY};
        fault_set(&none.fault, ERR_MEMORY, "", "no memory to encode the picture");
        unstored(f, &none);
        return;
    }
    t->task = (struct team_task){.run = encode_run, .done = encode_done};
    t->frame = f;
    frame_task_submit(f, &t->task);
}
