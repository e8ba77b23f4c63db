/* Requests about assets: who has them, which jobs need them. */
#include <stdio.h>

#include "server/store/job_store_internal.h"

int job_store_claim_assets(struct job_store *s, struct job_request *r, const char *owner,
                           const struct job_assets *assets)
{
    r->room = s->room;
    snprintf(r->claim.owner, sizeof r->claim.owner, "%s", owner);
    r->claim.sees_all = assets->sees_all;
    r->tell_missing = assets->missing;
    return job_request_take_assets(r, assets->items, assets->count);
}

void job_store_set_assets(struct job_store *s, const struct objects *objects, uint64_t tenant_bytes)
{
    s->room = (struct asset_room){.objects = objects, .tenant_bytes = tenant_bytes};
}

/* NULL on failed allocation. */
static struct job_request *create_claim(const struct job_store *s, enum request_kind kind,
                                        const struct asset_claim *claim, void *ctx)
{
    struct job_request *r = job_request_create(kind, NULL, ctx);
    if (!r) return NULL;
    r->room = s->room;
    r->claim = *claim;
    return r;
}

void job_store_keep_asset(struct job_store *s, const struct asset_claim *claim, uint64_t size_bytes,
                          job_store_kept done, void *ctx)
{
    struct job_request *r = create_claim(s, REQUEST_KEEP_ASSET, claim, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, false);
        return;
    }
    r->size_bytes = size_bytes;
    r->call.kept = done;
    job_batches_submit(&s->batches, r, 0);
}

/* Without memory, or when it fails, the next start finds it. */
void job_store_doubt_asset(struct job_store *s, const struct digest *asset)
{
    const struct asset_claim claim = {.asset = *asset};
    struct job_request *r = create_claim(s, REQUEST_NOTE_REMOVAL, &claim, NULL);
    if (r) job_batches_submit(&s->batches, r, 0);
}

void job_store_find_assets(struct job_store *s, const char *owner, const struct job_assets *assets,
                           job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_FIND_ASSETS, NULL, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY);
        return;
    }
    r->call.done = done;
    job_batches_submit(&s->batches, r, job_store_claim_assets(s, r, owner, assets));
}

void job_store_remove_asset(struct job_store *s, const struct asset_claim *claim,
                            job_store_gave_up done, void *ctx)
{
    struct job_request *r = create_claim(s, REQUEST_REMOVE_ASSET, claim, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, &(struct asset_users){0});
        return;
    }
    r->call.gave_up = done;
    job_batches_submit(&s->batches, r, 0);
}

void job_store_resume_removals(struct job_store *s)
{
    asset_removal_resume(job_database_connection(s->db), &s->room);
    job_store_look_at_removals(s);
}
