/* /v1/assets/{sha256}: files go in, by the digest of their bytes. */
#include <stdlib.h>
#include <string.h>

#include "server/http/etag.h"
#include "server/http/request.h"
#include "server/store/asset_owners.h"
#include "server/store/asset_usage.h"

/* Syncing and renaming wait for the disk: the team does it while the connection sleeps. */
struct asset_finish {
    struct team_task task;
    struct request *request;
    struct object_writer *writer; /* owned */
    uint64_t size_bytes;
    struct asset_usage *usage; /* NULL: no quota */
    const struct objects *objects;
    char owner[JOB_OWNER_BYTES]; /* "": nobody's */
    struct digest expected, found;
    int error;
    bool existed;
};

static void finish_run(struct team_task *task)
{
    struct asset_finish *f = (struct asset_finish *)task;
    if (!f->owner[0]) {
        f->error = object_writer_finish(&f->writer, &f->expected, &f->found, &f->existed);
        return;
    }
    /* What he has is counted already. */
    const bool counted = f->usage && !asset_owners_have(f->objects, f->owner, &f->expected);
    f->error = counted ? asset_usage_take(f->usage, f->owner, f->size_bytes) : 0;
    if (f->error) return;
    f->error = object_writer_finish(&f->writer, &f->expected, &f->found, &f->existed);
    f->existed = false; /* that somebody else has it is not this one's to know */
    if (!f->error) f->error = asset_owners_add(f->objects, f->owner, &f->expected, &f->existed);
    if (counted && (f->error || f->existed)) asset_usage_give(f->usage, f->owner, f->size_bytes);
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

static void finish_done(struct team_task *task)
{
    struct asset_finish *f = (struct asset_finish *)task;
    struct request *r = f->request;
    if (f->writer) object_writer_abort(&f->writer);
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
    f->task = (struct team_task){.run = finish_run, .done = finish_done};
    f->request = r;
    f->expected = r->match.sha256;
    f->objects = r->http->options.objects;
    f->size_bytes = r->file_bytes;
    f->usage = r->http->options.asset_usage;
    memcpy(f->owner, r->asker.owner, sizeof f->owner);
    f->writer = r->writer;
    r->writer = NULL;
    request_hold(r);
    team_submit(r->http->options.team, &f->task);
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
