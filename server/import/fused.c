#include "server/import/fused.h"

#include "server/import/rgbd/rgbd_model.h"
#include "server/import/sequence.h"
#include "server/import/sequence_files.h"

struct fused {
    struct files *files;
    const char *name;
    const struct scene_choice *choice;
    const struct file_view *main;
    struct rgbd_model model;
};

/* The objects may move. */
static int read_frame(void *ctx, double time_s, struct builder *b, struct fault *fault)
{
    const struct fused *f = ctx;
    struct scene_choice at = *f->choice;
    at.time_s = time_s;
    int rc = scene_read(f->files, f->name, &at, f->main, b, fault);
    if (rc == 0) rc = rgbd_model_add_frame(&f->model, &at, time_s, b, fault);
    return rc == 0 ? scene_finish(b, &at, fault) : rc;
}

int fused_import(struct files *files, const char *name, const struct scene_choice *choice,
                 const struct file_view *main, const char *out, struct builder *b,
                 struct import_stats *stats, struct fault *fault)
{
    struct fused f = {.files = files, .name = name, .choice = choice, .main = main};
    struct sequence_files all = {
        .choice = choice, .out = out, .base = b, .read = read_frame, .ctx = &f};
    int rc = rgbd_model_open(&f.model, files, choice, b, fault);
    if (rc == 0) rc = builder_finish_base(b, fault);
    if (rc == 0) rc = sequence_write_base(&all, fault);
    if (rc == 0) rc = sequence_write_frames(&all, stats, fault);
    rgbd_model_close(&f.model);
    return sequence_close(&all, rc);
}
