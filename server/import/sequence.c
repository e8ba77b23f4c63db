#include "server/import/sequence.h"

#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "server/import/gltf/gltf.h"
#include "server/import/scene/blob_writer.h"
#include "server/import/scene/roles.h"
#include "server/import/shutter.h"

/* CPU time after which no further frame is begun: the job waits for its first. */
#define FRAMES_CPU_S 2.0

struct sequence {
    struct gltf g;
    const struct scene_choice *choice;
    const char *out;
    struct builder *base;
    struct scene map; /* of the base's blob */
    struct digest digest;
    struct warnings warnings; /* of the first frame, for the report */
};

static void frame_path(const struct sequence *s, uint32_t index, char out[4096])
{
    snprintf(out, 4096, "%s.%u", s->out, index);
}

/* Checks that workers would accept a blob, and removes it if they would not. */
static int verify(const char *path, const struct scene *base, struct scene *out,
                  struct fault *fault)
{
    int rc = scene_map_on(path, base, out, fault);
    if (rc != 0) unlink(path);
    return rc;
}

static void count(const struct scene *scene, struct import_stats *stats)
{
    stats->triangles = scene->count[SCENE_TRIANGLES];
    stats->placed_triangles = scene->info->placed_triangles;
}

static int write_whole(struct sequence *s, struct import_stats *stats, struct fault *fault)
{
    struct scene_choice choice = *s->choice;
    choice.time_s = choice.times[0];
    int rc = gltf_read_whole(&s->g, &choice, s->base, fault);
    if (rc == 0) rc = scene_finish(s->base, &choice, fault);
    if (rc == 0) rc = blob_write(s->base, s->out, fault);
    if (rc == 0) rc = verify(s->out, NULL, &s->map, fault);
    if (rc == 0) count(&s->map, stats);
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
    int rc = builder_begin_frame(&b, s->base, &s->digest, &ignored);
    if (rc == 0) rc = gltf_read_frame(&s->g, s->choice, -LIMIT_TIME_S, &b, &ignored);
    if (rc == 0 && builder_count(&b, SCENE_INSTANCES) > 0 &&
        builder_bounds(&b, lowest, highest, &ignored) == 0)
        builder_set_bounds(s->base, lowest, highest);
    s->g.moves.asked = moves;
    builder_fini(&b);
}

static int write_base(struct sequence *s, struct fault *fault)
{
    int rc = gltf_read_base(&s->g, s->base, fault);
    if (rc == 0) rc = roles_apply(s->base, s->choice, false, fault);
    if (rc == 0) rc = builder_finish_base(s->base, fault);
    if (rc == 0) bound_first_pose(s);
    if (rc == 0) rc = blob_write(s->base, s->out, fault);
    if (rc == 0) rc = verify(s->out, NULL, &s->map, fault);
    if (rc == 0) digest_of(s->map.blob, s->map.blob_bytes, &s->digest);
    return rc;
}

static int write_frame(struct sequence *s, uint32_t index, struct import_stats *stats,
                       struct fault *fault)
{
    struct builder b;
    struct scene frame;
    char path[4096];
    const double time_s = s->choice->times[index];
    const struct shutter_frame shutter = {&s->g, s->choice, time_s, &s->digest, &b};
    frame_path(s, index, path);
    int rc = builder_begin_frame(&b, s->base, &s->digest, fault);
    b.moves = s->g.moving.plays;
    if (rc == 0) rc = gltf_read_frame(&s->g, s->choice, time_s, &b, fault);
    if (rc == 0) rc = scene_finish(&b, s->choice, fault);
    if (rc == 0) rc = shutter_add(&shutter, fault);
    if (rc == 0) rc = blob_write(&b, path, fault);
    if (rc == 0) rc = verify(path, &s->map, &frame, fault);
    if (rc == 0 && index == 0) {
        count(&frame, stats);
        stats->triangles += s->map.count[SCENE_TRIANGLES];
    }
    if (rc == 0) scene_unmap(&frame);
    if (index == 0) s->warnings = b.warnings;
    builder_fini(&b);
    return rc;
}

static double cpu_s(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/* What is wrong with a later frame is told when it comes first. */
static int write_frames(struct sequence *s, struct import_stats *stats, struct fault *fault)
{
    const double until_s = cpu_s() + FRAMES_CPU_S;
    struct fault later;
    int rc = write_frame(s, 0, stats, fault);
    if (rc != 0) return rc;
    stats->frames = 1;
    while (stats->frames < s->choice->time_count && cpu_s() < until_s &&
           write_frame(s, stats->frames, stats, &later) == 0)
        stats->frames++;
    return 0;
}

int sequence_import(struct files *files, const char *name, const struct scene_choice *choice,
                    const struct file_view *main, const char *out, struct builder *b,
                    struct import_stats *stats, struct fault *fault)
{
    static struct sequence s; /* large, and there is one */
    s = (struct sequence){.choice = choice, .out = out, .base = b};
    int rc = gltf_open(&s.g, files, name, choice, main, b, fault);
    if (rc == 0 && !s.g.moving.any) {
        rc = write_whole(&s, stats, fault);
    } else {
        if (rc == 0) rc = write_base(&s, fault);
        if (rc == 0) rc = write_frames(&s, stats, fault);
        if (stats->frames > 0) b->warnings = s.warnings;
    }
    gltf_close(&s.g);
    if (s.map.blob != NULL) scene_unmap(&s.map);
    if (rc != 0) unlink(out);
    return rc;
}
