/* /v1/assets/{sha256}: files go in, by the digest of their bytes. */
#include <stdlib.h>
#include <string.h>

#include "server/http/etag.h"
#include "server/http/request.h"
#include "server/store/asset_owners.h"
#include "server/store/asset_usage.h"
#include "server/store/removal_notes.h"

/* Syncing and renaming wait for the disk: the pool does it while the connection sleeps. */
struct asset_finish {
    struct pool_task task;
    struct request *request;
    struct object_writer *writer; /* owned */
    uint64_t size_bytes;
    struct asset_usage *usage; /* NULL: no quota */
    const struct objects *objects;
    struct job_store *store;
    char owner[JOB_OWNER_BYTES]; /* "": nobody's */
    struct digest expected, found;
    int error;
    bool existed;
    bool is_noted; /* the file is left to asset_removal.h */
};

static void note_unkept(struct asset_finish *f)
{
    f->is_noted = removal_notes_add(f->objects, &f->expected) == 0;
}

/* What is placed is held until the mark says whose it is, or a note that it may be nobody's. A mark
 * that was there, so that it was not counted, may have been taken away meanwhile: then this one
 * counts. */
static void keep(struct asset_finish *f, bool is_new, bool *counted)
{
    f->error = asset_owners_add(f->objects, f->owner, &f->expected, &f->existed);
    if (f->error && is_new) note_unkept(f);
    if (f->error || f->existed || !f->usage || *counted) return;
    f->error = asset_usage_take(f->usage, f->owner, f->size_bytes);
    *counted = !f->error;
    if (!f->error) return;
    note_unkept(f);
    (void)asset_owners_remove(f->objects, f->owner, &f->expected);
}

static void finish_run(struct pool_task *task)
{
    struct asset_finish *f = (struct asset_finish *)task;
    const bool is_owned = f->owner[0] != '\0';
    bool counted = false;
    if (is_owned && f->usage) {
        f->error = asset_usage_learn(f->usage, f->owner);
        /* What he has is counted already. */
        counted = !f->error && !asset_owners_have(f->objects, f->owner, &f->expected);
        if (counted) f->error = asset_usage_take(f->usage, f->owner, f->size_bytes);
    }
    if (f->error) {
        object_writer_abort(&f->writer);
        return;
    }
    f->error = object_writer_finish(&f->writer, &f->expected, &f->found, &f->existed);
    const bool is_held = !f->error;
    if (is_owned) {
        const bool is_new = !f->existed;
        f->existed = false; /* that somebody else has it is not this one's to know */
        if (is_held) keep(f, is_new, &counted);
        if (counted && (f->error || f->existed))
            asset_usage_give(f->usage, f->owner, f->size_bytes);
    }
    if (is_held && !is_owned) removal_notes_forget(f->objects, &f->expected);
    if (is_held) objects_release(f->objects, &f->expected);
}

static void answer_mismatch(struct request *r, const struct digest *found)
{
    char hex[DIGEST_HEX_BYTES], detail[128];
    digest_to_hex(found, hex);
    snprintf(detail, sizeof detail, "the body's SHA-256 is %s", hex);
    request_problem(r, PROBLEM_DIGEST, detail, NULL);
}

static void answer_stored(struct request *r, const struct digest *digest, bool existed)
{
    char hex[DIGEST_HEX_BYTES], path[DIGEST_HEX_BYTES + 16];
    digest_to_hex(digest, hex);
    snprintf(path, sizeof path, "/v1/assets/%s", hex);
    json_t *body = json_pack("{s:s, s:I}", "sha256", hex, "bytes", (json_int_t)r->file_bytes);
    struct MHD_Response *response = response_of_json(body, "application/json");
    json_decref(body);
    if (response) response_header(response, "Location", path);
    request_answer(r, existed ? 200 : 201, response);
}

static void finish_done(struct pool_task *task)
{
    struct asset_finish *f = (struct asset_finish *)task;
    struct request *r = f->request;
    if (f->is_noted) job_store_look_at_removals(f->store);
    if (request_back(r)) {
        if (f->error == ERR_MISMATCH)
            answer_mismatch(r, &f->found);
        else if (f->error == ERR_QUOTA)
            request_problem(r, PROBLEM_QUOTA,
                            "the tenant's assets would have more bytes than they may", NULL);
        else if (f->error)
            request_trouble(r, f->error, "the file could not be stored");
        else
            answer_stored(r, &f->found, f->existed);
    }
    free(f);
}

void route_asset_put(struct request *r)
{
    struct asset_finish *f = calloc(1, sizeof *f);
    if (!f) {
        request_trouble(r, ERR_MEMORY, NULL);
        return;
    }
    f->task = (struct pool_task){.run = finish_run, .done = finish_done};
    f->request = r;
    f->expected = r->match.sha256;
    f->objects = r->http->options.objects;
    f->store = r->http->options.store;
    f->size_bytes = r->file_bytes;
    f->usage = r->http->options.asset_usage;
    memcpy(f->owner, r->asker.owner, sizeof f->owner);
    f->writer = upload_take_writer(r->upload);
    request_hold(r);
    thread_pool_submit(r->http->options.pool, &f->task);
}

void route_asset_head(struct request *r)
{
    uint64_t size_bytes = 0;
    char etag[ETAG_BYTES];
    const struct objects *objects = r->http->options.objects;
    if (!objects_have(objects, &r->match.sha256, &size_bytes) ||
        !(r->asker.sees_all || asset_owners_have(objects, r->asker.owner, &r->match.sha256))) {
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such asset", NULL);
        return;
    }
    struct MHD_Response *response = response_of_length(size_bytes);
    if (response) {
        etag_of_digest(&r->match.sha256, etag);
        response_header(response, "ETag", etag);
    }
    request_answer(r, 200, response);
}

/* Which jobs keep it: a few of them, and how many more there are. */
static void refuse_named(struct request *r, const struct asset_users *users)
{
    char detail[64 + ASSET_USERS_NAMED * (JOB_ID_BYTES + 2)];
    const size_t named = users->count < ASSET_USERS_NAMED ? users->count : ASSET_USERS_NAMED;
    int n = snprintf(detail, sizeof detail, "not ended, and in need of it: job%s ",
                     users->count > 1 ? "s" : "");
    for (size_t i = 0; i < named; i++)
        n += snprintf(detail + n, sizeof detail - (size_t)n, "%s%s", i > 0 ? ", " : "",
                      users->ids[i]);
    if (users->count > named)
        snprintf(detail + n, sizeof detail - (size_t)n, " and %zu more", users->count - named);
    request_problem(r, PROBLEM_ASSET_IN_USE, detail, NULL);
}

static void on_given_up(void *ctx, int error, const struct asset_users *users)
{
    struct request *r = ctx;
    if (!request_back(r)) return;
    if (error == ERR_NOT_FOUND)
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such asset", NULL);
    else if (error == ERR_STATE)
        refuse_named(r, users);
    else if (error == ERR_EXISTS)
        request_problem(r, PROBLEM_ASSET_IN_USE,
                        "it is a tenant's, a job's picture, or what became of another asset", NULL);
    else if (error == ERR_FULL)
        request_problem(r, PROBLEM_BUSY,
                        "it, or a file that is kept beside it, is being written just now", NULL);
    else if (error)
        request_trouble(r, error, "the asset could not be removed");
    else
        request_answer(r, 204, response_empty());
}

void route_asset_delete(struct request *r)
{
    struct asset_claim claim = {.asset = r->match.sha256, .sees_all = r->asker.sees_all};
    memcpy(claim.owner, r->asker.owner, sizeof claim.owner);
    request_hold(r);
    job_store_remove_asset(r->http->options.store, &claim, on_given_up, r);
}
