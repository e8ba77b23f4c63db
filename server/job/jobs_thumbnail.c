/* The picture that stands for a job in lists: its latest. */
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/picture_file.h"
#include "server/job/frame/state.h"
#include "server/job/jobs_table.h"

struct search {
    struct jobs *jobs;
    struct principal principal;
    struct digest png; /* of the last finished frame; zero: none */
    bool ended;
    char id[JOB_ID_BYTES];
    jobs_thumbnailed done;
    void *ctx;
};

static void answer(struct search *s, int error, const struct jobs_thumbnail *thumbnail)
{
    s->done(s->ctx, error, thumbnail);
    free(s);
}

static void on_kept(void *ctx, int error, const void *png, size_t size_bytes)
{
    struct search *s = ctx;
    const struct jobs_thumbnail thumbnail = {
        .kept = png, .kept_bytes = size_bytes, .png = s->png, .ended = s->ended};
    if (!error && !png && digest_is_zero(&s->png)) error = ERR_MISSING;
    answer(s, error, error ? NULL : &thumbnail);
}

static void on_row(void *ctx, int error, const struct job_row *row, const struct frame_row *frames,
                   size_t frame_count)
{
    struct search *s = ctx;
    enum job_state state;
    (void)frames, (void)frame_count;
    if (!error && (!row || !principal_sees(&s->principal, row->owner))) error = ERR_NOT_FOUND;
    if (error) {
        answer(s, error, NULL);
        return;
    }
    s->png = row->png;
    s->ended = row->state && job_state_from_name(row->state, &state) && job_state_is_final(state);
    job_store_find_thumbnail(s->jobs->options.store, s->id, on_kept, s);
}

static bool is_loaded(const struct active_job *active)
{
    return active && active->frames && active->prepared;
}

/* Finds the latest picture of a job in work: of the frame that forms, else of the last that is
 * finished. */
static bool find_in_work(const struct active_job *active, struct jobs_thumbnail *out)
{
    struct jobs_picture picture = {0};
    const struct plane *rgb[3];
    *out = (struct jobs_thumbnail){0};
    for (uint32_t i = active->frame_count; i-- > 0 && !out->image;) {
        const struct active_frame *frame = &active->frames[i];
        if (frame->work && jobs_picture_so_far(active, frame, &picture) &&
            image_layer_planes(picture.image, image_main_layer(picture.image), rgb)) {
            out->image = picture.image;
            out->revision = picture.revision;
            out->png_options = picture_png_options(&active->prepared->job);
            out->png_options.is_deep = out->png_options.alpha = false;
        } else if (digest_is_zero(&out->png)) {
            out->png = frame->png;
        }
    }
    return out->image || !digest_is_zero(&out->png);
}

/* What follows `of=` changes with the picture: a browser that has the address has the picture. */
json_t *jobs_thumbnail_address(const struct active_job *active, const struct job_row *row)
{
    struct jobs_thumbnail thumbnail = {.png = row->png};
    char hex[DIGEST_HEX_BYTES];
    if (is_loaded(active)) find_in_work(active, &thumbnail);
    if (thumbnail.image)
        return json_sprintf("/v1/jobs/%s/thumbnail?of=%llx", row->id,
                            (unsigned long long)thumbnail.revision);
    if (digest_is_zero(&thumbnail.png)) return json_null();
    digest_to_hex(&thumbnail.png, hex);
    return json_sprintf("/v1/jobs/%s/thumbnail?of=%.16s", row->id, hex);
}

void jobs_thumbnail(struct jobs *jobs, const struct principal *principal, const char *id,
                    jobs_thumbnailed done, void *ctx)
{
    struct active_job *active = jobs_table_find(jobs, id);
    struct jobs_thumbnail thumbnail;
    if (!job_id_is_valid(id) || (active && !principal_sees(principal, active->owner))) {
        done(ctx, ERR_NOT_FOUND, NULL);
        return;
    }
    if (is_loaded(active)) {
        const bool found = find_in_work(active, &thumbnail);
        done(ctx, found ? 0 : ERR_MISSING, found ? &thumbnail : NULL);
        return;
    }
    struct search *s = calloc(1, sizeof *s);
    if (!s) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    *s = (struct search){.jobs = jobs, .principal = *principal, .done = done, .ctx = ctx};
    memcpy(s->id, id, sizeof s->id);
    job_store_get(jobs->options.store, id, on_row, s);
}
