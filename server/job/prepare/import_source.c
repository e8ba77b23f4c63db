/* What tells one import of a scene from another. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "server/job/prepare/imports.h"

static int compare_files(const void *a, const void *b)
{
    const struct job_file *p = a, *q = b;
    return strcmp(p->path, q->path);
}

static int hash_files(struct digest_state *state, const struct job *scene)
{
    int error = 0;
    if (scene->file_count == 0) return 0;
    struct job_file *sorted = calloc(scene->file_count, sizeof *sorted); /* borrows the paths */
    if (!sorted) return ERR_MEMORY;
    memcpy(sorted, scene->files, scene->file_count * sizeof *sorted);
    qsort(sorted, scene->file_count, sizeof *sorted, compare_files);
    for (uint32_t i = 0; !error && i < scene->file_count; i++) {
        error = digest_update(state, sorted[i].path, strlen(sorted[i].path) + 1);
        if (!error) error = digest_update(state, sorted[i].asset.bytes, DIGEST_BYTES);
    }
    free(sorted);
    return error;
}

/* A scene that stands is one blob, and another one than the same in a sequence. */
static int hash_time(struct digest_state *state, const struct job *scene)
{
    const double moment[2] = {scene->time_s, job_shutter_s(scene)};
    int error = digest_update(state, scene->stands ? "\1" : "\2", 1);
    if (!error) error = digest_update(state, moment, sizeof moment);
    if (!error) error = digest_update(state, scene->animation, strlen(scene->animation));
    return error;
}

static int hash_composite(struct digest_state *state, const struct job_composite *c)
{
    char text[64];
    const char *const lists[] = {c->catchers, c->holdouts};
    int error = 0;
    for (int k = 0; k < 2 && !error; k++)
        error = digest_update(state, lists[k] ? lists[k] : "", lists[k] ? strlen(lists[k]) + 1 : 1);
    if (!error && c->rgbd) error = digest_update(state, c->rgbd, strlen(c->rgbd) + 1);
    if (!error && c->rgbd) error = digest_update(state, c->surfaces == RGBD_FUSED ? "f" : "s", 1);
    snprintf(text, sizeof text, "%d %.9g %d", (int)c->has_ground, (double)c->ground_height,
             (int)c->estimate);
    return error ? error : digest_update(state, text, strlen(text));
}

/* After a byte that begins nothing else, and with their number, so that what follows is no move. */
static int hash_moves(struct digest_state *state, const struct job_moves *moves)
{
    const uint32_t count = (uint32_t)moves->count;
    int error = digest_update(state, "\3", 1);
    if (!error) error = digest_update(state, &count, sizeof count);
    return error ? error : digest_update(state, moves->list, moves->count * sizeof *moves->list);
}

int imports_source(const struct job *scene, struct digest *out)
{
    struct digest_state *state = digest_begin();
    if (!state) return ERR_MEMORY;
    int error = digest_update(state, build_id(), strlen(build_id()) + 1);
    if (!error) error = digest_update(state, scene->scene.bytes, DIGEST_BYTES);
    if (!error) error = hash_files(state, scene);
    if (!error && scene->variant[0]) /* after a byte that no path begins with */
        error = digest_update(state, "", 1);
    if (!error && scene->variant[0])
        error = digest_update(state, scene->variant, strlen(scene->variant));
    if (!error) error = hash_time(state, scene);
    if (!error && scene->moves.count > 0) error = hash_moves(state, &scene->moves);
    if (!error && scene->composite.on) error = hash_composite(state, &scene->composite);
    digest_finish(&state, out);
    return error;
}
