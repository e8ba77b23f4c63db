#include "server/import/sequence.h"

#include "server/import/gltf/gltf.h"
#include "server/import/scene/roles.h"
#include "server/import/sequence_files.h"
#include "server/import/shutter.h"

struct sequence {
    struct gltf g;
    struct sequence_files files;
};

static int write_whole(struct sequence *s, struct import_stats *stats, struct fault *fault)
{
    struct scene_choice choice = *s->files.choice;
    choice.time_s = choice.times[0];
    int rc = gltf_read_whole(&s->g, &choice, s->files.base, fault);
    if (rc == 0) rc = scene_finish(s->files.base, &choice, fault);
    if (rc == 0) rc = sequence_write_base(&s->files, fault);
    if (rc == 0) sequence_count(&s->files.map, stats);
    return rc;
}

/* Cameras of our making look at the scene as it begins, whichever frames are made. */
static void bound_first_pose(struct sequence *s)
{
    struct builder b;
    struct fault ignored; /* the frames tell of it */
    const struct job_moves *moves = s->g.moves.asked;
    s->g.moves.asked = NULL; /* it stands still while they do not */
    float lowest[3], highest[3];
    int rc = builder_begin_frame(&b, s->files.base, &s->files.digest, &ignored);
    if (rc == 0) rc = gltf_read_frame(&s->g, s->files.choice, -LIMIT_TIME_S, &b, &ignored);
    if (rc == 0 && builder_count(&b, SCENE_INSTANCES) > 0 &&
        builder_bounds(&b, lowest, highest, &ignored) == 0)
        builder_set_bounds(s->files.base, lowest, highest);
    s->g.moves.asked = moves;
    builder_fini(&b);
}

static int write_base(struct sequence *s, struct fault *fault)
{
    int rc = gltf_read_base(&s->g, s->files.base, fault);
    if (rc == 0) rc = roles_apply(s->files.base, s->files.choice, false, fault);
    if (rc == 0) rc = builder_finish_base(s->files.base, fault);
    if (rc == 0) bound_first_pose(s);
    return rc == 0 ? sequence_write_base(&s->files, fault) : rc;
}

static int read_frame(void *ctx, double time_s, struct builder *b, struct fault *fault)
{
    struct sequence *s = ctx;
    const struct shutter_frame shutter = {&s->g, s->files.choice, time_s, &s->files.digest, b};
    b->moves = s->g.moving.plays;
    int rc = gltf_read_frame(&s->g, s->files.choice, time_s, b, fault);
    if (rc == 0) rc = scene_finish(b, s->files.choice, fault);
    return rc == 0 ? shutter_add(&shutter, fault) : rc;
}

int sequence_import(struct files *files, const char *name, const struct scene_choice *choice,
                    const struct file_view *main, const char *out, struct builder *b,
                    struct import_stats *stats, struct fault *fault)
{
    static struct sequence s; /* large, and there is one */
    s = (struct sequence){
        .files = {.choice = choice, .out = out, .base = b, .read = read_frame, .ctx = &s}};
    int rc = gltf_open(&s.g, files, name, choice, main, b, fault);
    if (rc == 0 && !s.g.moving.any) {
        rc = write_whole(&s, stats, fault);
    } else {
        if (rc == 0) rc = write_base(&s, fault);
        if (rc == 0) rc = sequence_write_frames(&s.files, stats, fault);
    }
    gltf_close(&s.g);
    return sequence_close(&s.files, rc);
}
