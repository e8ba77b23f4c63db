#include "server/store/asset_removal.h"

#include <stdlib.h>
#include <uv.h>

#include "server/store/asset_tables.h"

struct removal {
    sqlite3 *db;
    const struct asset_room *room;
    const char *giver; /* the owner that gives it up and is still on record; NULL: none */
};

/* Asked by objects_remove, while nothing places the file. */
static bool is_free(void *ctx, const struct digest *d)
{
    const struct removal *r = ctx;
    struct asset_users users;
    return asset_owners_find_other(r->db, r->giver, d) == ERR_NOT_FOUND &&
           !asset_is_derived(r->db, d) && asset_users_find(r->db, NULL, d, &users) == 0 &&
           users.count == 0;
}

/* owner NULL: all of them. */
static int drop_owner(struct removal *r, const char *owner, const struct digest *asset)
{
    int error = asset_tables_begin(r->db);
    if (error) return error;
    error = asset_owners_drop(r->db, owner, asset);
    if (!error) error = asset_removals_add(r->db, asset);
    return asset_tables_end(r->db, error);
}

static int record_gone(struct removal *r, const struct digest *d)
{
    int error = asset_tables_begin(r->db);
    if (error) return error;
    error = asset_imports_drop(r->db, d);
    if (!error) error = asset_removals_drop(r->db, d);
    return asset_tables_end(r->db, error);
}

/* Settles a file that is not held, so that no thread is about to place it. Afterwards it has an
 * owner and no note, or neither. */
static int settle_owned(struct removal *r, const struct digest *d)
{
    if (asset_owners_find_other(r->db, NULL, d) != 0) return ERR_EXISTS;
    return objects_lack(r->room->objects, d) ? drop_owner(r, NULL, d)
                                             : asset_removals_drop(r->db, d);
}

/* The file goes if it can; blobs that may go with it are appended. */
static int sweep_file(struct removal *r, const struct digest *d, struct digest_list *blobs)
{
    int error = objects_remove(r->room->objects, d, is_free, r);
    if (error == ERR_EXISTS) {
        error = settle_owned(r, d);
        if (error || !objects_lack(r->room->objects, d)) return error;
    }
    if (!error) error = asset_list_blobs(r->db, d, blobs);
    return error ? error : record_gone(r, d);
}

/* Sweeps the list, which grows by files that go with others. A file that fails keeps its note, and
 * is tried again. */
static void sweep(struct removal *r, struct digest_list *files)
{
    for (size_t i = 0; i < files->count; i++) {
        const struct digest d = files->items[i];
        (void)sweep_file(r, &d, files);
    }
}

/* Finds the owner for whom the claim may give the asset up. "" is an upload without tokens, or
 * without an owner. */
static int find_owner(const struct removal *r, const struct asset_claim *claim, const char **owner)
{
    *owner = claim->owner;
    int error = asset_owners_find(r->db, claim->owner, &claim->asset);
    if (error != ERR_NOT_FOUND) return error;
    error = claim->sees_all ? asset_room_find(r->db, r->room, claim) : ERR_NOT_FOUND;
    if (error) return error;
    *owner = "";
    if (asset_owners_find(r->db, *owner, &claim->asset) == 0) return 0;
    if (asset_owners_find_other(r->db, NULL, &claim->asset) != ERR_NOT_FOUND)
        return claim->owner[0] ? ERR_NOT_FOUND : ERR_EXISTS;
    return asset_is_derived(r->db, &claim->asset) ? ERR_EXISTS : 0;
}

static int give_up(struct removal *r, const char *owner, const struct digest *asset)
{
    int error = drop_owner(r, owner, asset);
    if (error != ERR_NO_SPACE) return error;
    r->giver = owner;
    const int removed = objects_remove(r->room->objects, asset, is_free, r);
    r->giver = NULL;
    return removed ? error : drop_owner(r, owner, asset);
}

int asset_removal_run(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                      struct asset_users *users)
{
    struct removal r = {.db = db, .room = room};
    struct digest_list files = {0};
    const char *owner;
    *users = (struct asset_users){0};
    int error = find_owner(&r, claim, &owner);
    if (!error) error = asset_users_find(db, owner[0] ? owner : NULL, &claim->asset, users);
    if (!error && users->count > 0) error = ERR_STATE;
    if (!error) error = give_up(&r, owner, &claim->asset);
    if (error) return error;
    if (sweep_file(&r, &claim->asset, &files) == 0) sweep(&r, &files);
    free(files.items);
    return 0;
}

void asset_removal_resume(sqlite3 *db, const struct asset_room *room)
{
    struct removal r = {.db = db, .room = room};
    struct digest_list owned = {0}, files = {0};
    (void)asset_list_owned(db, &owned);
    for (size_t i = 0; i < owned.count; i++)
        if (objects_lack(room->objects, &owned.items[i]))
            (void)drop_owner(&r, NULL, &owned.items[i]);
    (void)asset_list_removals(db, NULL, SIZE_MAX, &files);
    sweep(&r, &files);
    free(owned.items);
    free(files.items);
}

void asset_removal_pass(sqlite3 *db, const struct asset_room *room, struct removal_pass *pass)
{
    const uint64_t began_ns = uv_hrtime();
    struct removal r = {.db = db, .room = room};
    struct digest_list files = {0};
    if (!pass->is_cut) *pass = (struct removal_pass){0};
    (void)asset_list_removals(db, pass->is_cut ? &pass->after : NULL, REMOVAL_PASS_FILES, &files);
    pass->is_cut = files.count == REMOVAL_PASS_FILES;
    if (pass->is_cut) pass->after = files.items[files.count - 1];
    sweep(&r, &files);
    free(files.items);
    if (!pass->is_cut && asset_removals_count(db, &pass->left) != 0) pass->left = 1;
    pass->took_us = (uv_hrtime() - began_ns) / 1000;
}

int asset_removal_check_import(sqlite3 *db, const struct asset_room *room,
                               const struct digest *assets, size_t count, const struct digest *blob,
                               bool *gone)
{
    size_t there = 0;
    while (there < count && objects_have(room->objects, &assets[there], NULL)) there++;
    *gone = there < count;
    /* What another import gave, too, goes with the assets of that one. */
    return *gone && !asset_is_derived(db, blob) ? asset_removals_add(db, blob) : 0;
}
