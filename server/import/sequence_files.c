#include "server/import/sequence_files.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#include "server/import/scene/blob_writer.h"

/* CPU time after which no further frame is begun: the job waits for its first. */
#define FRAMES_CPU_S 2.0

static void frame_path(const struct sequence_files *s, uint32_t index, char out[4096])
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

void sequence_count(const struct scene *scene, struct import_stats *stats)
{
    stats->triangles = scene->count[SCENE_TRIANGLES];
    stats->placed_triangles = scene->info->placed_triangles;
}

int sequence_write_base(struct sequence_files *s, struct fault *fault)
{
    int rc = blob_write(s->base, s->out, fault);
    if (rc == 0) rc = verify(s->out, NULL, &s->map, fault);
    if (rc == 0) digest_of(s->map.blob, s->map.blob_bytes, &s->digest);
    return rc;
}

static int write_frame(struct sequence_files *s, uint32_t index, struct import_stats *stats,
                       struct fault *fault)
{
    struct builder b;
    struct scene frame;
    char path[4096];
    frame_path(s, index, path);
    int rc = builder_begin_frame(&b, s->base, &s->digest, fault);
    if (rc == 0) rc = s->read(s->ctx, s->choice->times[index], &b, fault);
    if (rc == 0) rc = blob_write(&b, path, fault);
    if (rc == 0) rc = verify(path, &s->map, &frame, fault);
    if (rc == 0 && index == 0) {
        sequence_count(&frame, stats);
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

int sequence_write_frames(struct sequence_files *s, struct import_stats *stats, struct fault *fault)
{
    const double spent_s = cpu_s(); /* on the base, which a further import makes anew */
    const double until_s = spent_s + (spent_s > FRAMES_CPU_S ? spent_s : FRAMES_CPU_S);
    struct fault later;
    int rc = write_frame(s, 0, stats, fault);
    if (rc != 0) return rc;
    stats->frames = 1;
    while (stats->frames < s->choice->time_count && cpu_s() < until_s &&
           write_frame(s, stats->frames, stats, &later) == 0)
        stats->frames++;
    s->base->warnings = s->warnings;
    return 0;
}

int sequence_close(struct sequence_files *s, int rc)
{
    if (s->map.blob != NULL) scene_unmap(&s->map);
    if (rc != 0) unlink(s->out);
    return rc;
}
