/* /v1/assets/{sha256}: files go in, by the digest of their bytes. */
#include <stdlib.h>
#include <string.h>

#include "server/http/etag.h"
#include "server/http/request.h"

/* An upload that has arrived: sealed by the pool, kept by the store, placed by the pool
 * (asset_room.h), while the connection sleeps. */
struct asset_upload {
    struct pool_task task;
    struct request *request;
    struct object_writer *writer; /* owned; NULL when it was placed */
    const struct objects *objects;
    struct job_store *store;
    struct asset_claim claim;
    uint64_t size_bytes;
    struct digest found;
    int error;
    bool existed;
};

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

static void answer(struct request *r, const struct asset_upload *u, int error)
{
    if (error == ERR_MISMATCH)
        answer_mismatch(r, &u->found);
    else if (error == ERR_QUOTA)
        request_problem(r, PROBLEM_QUOTA, "the tenant's assets would have more bytes than they may",
                        NULL);
    else if (error == ERR_STATE)
        request_problem(r, PROBLEM_DRAINING, "the server has stopped", NULL);
    else if (error)
        request_trouble(r, error, "the file could not be stored");
    else
        answer_stored(r, &u->found, u->existed);
}

static void finish(struct asset_upload *u, int error)
{
    object_writer_abort(&u->writer);
    if (request_back(u->request)) answer(u->request, u, error);
    free(u);
}

static void place_run(struct pool_task *task)
{
    struct asset_upload *u = (struct asset_upload *)task;
    u->error = object_writer_place(&u->writer, &u->found, NULL);
    if (!u->error) objects_release(u->objects, &u->found); /* it is held as well since before */
}

static void place_done(struct pool_task *task)
{
    struct asset_upload *u = (struct asset_upload *)task;
    objects_release(u->objects, &u->found);
    if (u->error) job_store_doubt_asset(u->store, &u->found);
    finish(u, u->error);
}

static void on_kept(void *ctx, int error, bool existed)
{
    struct asset_upload *u = ctx;
    struct thread_pool *pool = u->request->home->options.pool;
    u->existed = existed;
    if (!error && pool) {
        u->task = (struct pool_task){.run = place_run, .done = place_done};
        thread_pool_submit(pool, &u->task);
        return;
    }
    objects_release(u->objects, &u->found);
    finish(u, error ? error : ERR_STATE);
}

static void seal_run(struct pool_task *task)
{
    struct asset_upload *u = (struct asset_upload *)task;
    u->error = object_writer_seal(u->writer, &u->claim.asset, &u->found);
}

static void seal_done(struct pool_task *task)
{
    struct asset_upload *u = (struct asset_upload *)task;
    if (u->error) {
        finish(u, u->error);
        return;
    }
    objects_hold(u->objects, &u->found);
    job_store_keep_asset(u->store, &u->claim, u->size_bytes, on_kept, u);
}

static struct asset_claim claim_of(const struct request *r)
{
    struct asset_claim claim = {.asset = r->match.sha256, .sees_all = r->principal.sees_all};
    memcpy(claim.owner, r->principal.owner, sizeof claim.owner);
    return claim;
}

void route_asset_put(struct request *r)
{
    struct asset_upload *u = calloc(1, sizeof *u);
    if (!u) {
        request_trouble(r, ERR_MEMORY, NULL);
        return;
    }
    *u = (struct asset_upload){.task = {.run = seal_run, .done = seal_done},
                               .request = r,
                               .writer = upload_take_writer(r->upload),
                               .objects = r->http->options.objects,
                               .store = r->http->options.store,
                               .claim = claim_of(r),
                               .size_bytes = r->file_bytes};
    request_hold(r);
    thread_pool_submit(r->http->options.pool, &u->task);
}

static void on_found(void *ctx, int error)
{
    struct request *r = ctx;
    uint64_t size_bytes = 0;
    char etag[ETAG_BYTES];
    if (!request_back(r)) return;
    if (!error && !objects_have(r->http->options.objects, &r->match.sha256, &size_bytes))
        error = ERR_NOT_FOUND;
    if (error == ERR_NOT_FOUND) {
        request_problem(r, PROBLEM_NOT_FOUND, "there is no such asset", NULL);
        return;
    }
    if (error) {
        request_trouble(r, error, NULL);
        return;
    }
    struct MHD_Response *response = response_of_length(size_bytes);
    if (response) {
        etag_of_digest(&r->match.sha256, etag);
        response_header(response, "ETag", etag);
    }
    request_answer(r, 200, response);
}

void route_asset_head(struct request *r)
{
    const struct job_assets assets = {
        .items = &r->match.sha256, .count = 1, .sees_all = r->principal.sees_all};
    request_hold(r);
    job_store_find_assets(r->http->options.store, r->principal.owner, &assets, on_found, r);
}

/* Names the jobs that keep the asset: a few of them, and the number of others. */
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
        request_problem(
            r, PROBLEM_ASSET_IN_USE,
            "it belongs to a tenant, is a job's picture, or was made from another asset", NULL);
    else if (error)
        request_trouble(r, error, "the asset could not be removed");
    else
        request_answer(r, 204, response_empty());
}

void route_asset_delete(struct request *r)
{
    const struct asset_claim claim = claim_of(r);
    request_hold(r);
    job_store_remove_asset(r->http->options.store, &claim, on_given_up, r);
}
