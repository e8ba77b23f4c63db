#include "server/store/asset_removal.h"

#include <stdlib.h>
#include <string.h>
#include <uv.h>

#include "server/store/asset_owners.h"
#include "server/store/asset_uses.h"
#include "server/store/removal_notes.h"

#define PASS_NS 20000000u

struct removal {
    sqlite3 *db;
    const struct asset_room *room;
};

static bool is_named(const struct removal *r, const struct digest *d)
{
    struct asset_users users;
    return asset_uses_jobs(r->db, NULL, d, &users) != 0 || users.count > 0;
}

static bool is_free(void *ctx, const struct digest *d)
{
    const struct removal *r = ctx;
    return !asset_owners_any(r->room->objects, d) && !asset_uses_is_derived(r->db, d) &&
           !is_named(r, d);
}

/* On a full disk, too, files can go: then who is killed meanwhile leaves one that nobody has. What
 * cannot go at once needs its note. */
static int note_if_there_is_room(const struct removal *r, const struct digest *d)
{
    const struct objects *objects = r->room->objects;
    const int error = removal_notes_add(objects, d);
    if (error != ERR_NO_SPACE) return error;
    return object_holds_any(objects->holds, d) || is_named(r, d) ? error : 0;
}

static bool forget_if_over(void *ctx, const struct digest *d)
{
    const struct removal *r = ctx;
    const struct objects *objects = r->room->objects;
    if (!objects_have(objects, d, NULL) || asset_owners_any(objects, d))
        removal_notes_forget(objects, d);
    return false;
}

/* A note of what is gone, or what somebody has again, is not needed; of what is held, named or a
 * picture it stays. Asked as objects_remove asks: who holds it may just be leaving a note. */
static void settle_note(struct removal *r, const struct digest *d)
{
    (void)objects_remove(r->room->objects, d, forget_if_over, r);
}

static int remove_object(struct removal *r, const struct digest *d)
{
    const int error = objects_remove(r->room->objects, d, is_free, r);
    settle_note(r, d);
    return error;
}

struct digest_list {
    struct digest *items; /* owned */
    size_t count;
};

static int list_digest(void *ctx, const struct digest *d)
{
    struct digest_list *list = ctx;
    struct digest *grown = realloc(list->items, (list->count + 1) * sizeof *grown);
    if (!grown) return ERR_MEMORY;
    list->items = grown;
    list->items[list->count++] = *d;
    return 0;
}

/* Blobs are noted before the record forgets whose they were. */
static int remove_blobs(struct removal *r, const struct digest *asset)
{
    struct digest_list list = {0};
    int error = asset_uses_each_blob(r->db, asset, list_digest, &list);
    for (size_t i = 0; !error && i < list.count; i++)
        error = removal_notes_add(r->room->objects, &list.items[i]);
    if (!error && list.count > 0) error = asset_uses_forget_imports(r->db, asset);
    for (size_t i = 0; !error && i < list.count; i++) (void)remove_object(r, &list.items[i]);
    free(list.items);
    return error;
}

/* While the record has imports of an asset that is gone, its note or else a start finds them: so
 * the file goes first, and what its blobs come to is no matter of who gave it up. */
static int sweep(struct removal *r, const struct digest *d)
{
    const int error = objects_remove(r->room->objects, d, is_free, r);
    if (error || remove_blobs(r, d) == 0) settle_note(r, d);
    return error;
}

/* What has no owner is of before there were tokens, and everybody's who sees all. */
static int check_ownerless(const struct removal *r, const struct asset_claim *claim)
{
    const struct objects *objects = r->room->objects;
    if (!claim->sees_all || !objects_have(objects, &claim->asset, NULL)) return ERR_NOT_FOUND;
    if (asset_owners_any(objects, &claim->asset))
        return claim->owner[0] ? ERR_NOT_FOUND : ERR_EXISTS;
    return asset_uses_is_derived(r->db, &claim->asset) ? ERR_EXISTS : 0;
}

/* Nothing but its note tells that it is not wanted: where it stays that goes. */
static int remove_ownerless(struct removal *r, const struct asset_claim *claim)
{
    int error = note_if_there_is_room(r, &claim->asset);
    if (!error) error = sweep(r, &claim->asset);
    if (error) removal_notes_forget(r->room->objects, &claim->asset);
    return error == ERR_STATE ? ERR_FULL : error;
}

/* He has it no more whatever comes of the file. */
static int remove_owned(struct removal *r, const struct asset_claim *claim)
{
    const struct asset_room *room = r->room;
    uint64_t size_bytes = 0;
    int error = room->usage ? asset_usage_learn(room->usage, claim->owner) : 0;
    if (!error) error = note_if_there_is_room(r, &claim->asset);
    (void)objects_have(room->objects, &claim->asset, &size_bytes);
    if (!error) error = asset_owners_remove(room->objects, claim->owner, &claim->asset);
    /* Gone and perhaps not durably so is gone for as long as this process lives. */
    const bool has = error && asset_owners_have(room->objects, claim->owner, &claim->asset);
    if (has || error == ERR_NOT_FOUND) return error;
    if (room->usage) asset_usage_give(room->usage, claim->owner, size_bytes);
    if (!error) (void)sweep(r, &claim->asset);
    return error;
}

int asset_removal_run(sqlite3 *db, const struct asset_room *room, const struct asset_claim *claim,
                      struct asset_users *users)
{
    struct removal r = {.db = db, .room = room};
    const bool is_owned = asset_owners_have(room->objects, claim->owner, &claim->asset);
    *users = (struct asset_users){0};
    int error = is_owned ? 0 : check_ownerless(&r, claim);
    if (error) return error;
    error = asset_uses_jobs(db, is_owned ? claim->owner : NULL, &claim->asset, users);
    if (error) return error;
    if (users->count > 0) return ERR_STATE;
    return is_owned ? remove_owned(&r, claim) : remove_ownerless(&r, claim);
}

static void resume_note(void *ctx, const struct digest *d)
{
    (void)sweep(ctx, d);
}

void asset_removal_resume(sqlite3 *db, const struct asset_room *room)
{
    struct removal r = {.db = db, .room = room};
    struct digest_list read = {0};
    removal_notes_each(room->objects, resume_note, &r);
    (void)asset_uses_each_read(db, list_digest, &read);
    for (size_t i = 0; i < read.count; i++) {
        const struct digest *asset = &read.items[i];
        if (!objects_have(room->objects, asset, NULL) && !is_named(&r, asset))
            (void)remove_blobs(&r, asset);
    }
    free(read.items);
}

static void list_note(void *ctx, const struct digest *d)
{
    (void)list_digest(ctx, d); /* without memory another round has it */
}

static void count_note(void *ctx, const struct digest *d)
{
    (void)d;
    ++*(size_t *)ctx;
}

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(struct digest));
}

void asset_removal_pass(sqlite3 *db, const struct asset_room *room, struct removal_pass *pass)
{
    const uint64_t began_ns = uv_hrtime();
    struct removal r = {.db = db, .room = room};
    struct digest_list notes = {0};
    size_t i = 0;
    if (!pass->is_cut) *pass = (struct removal_pass){0};
    removal_notes_each(room->objects, list_note, &notes);
    if (notes.count > 0) qsort(notes.items, notes.count, sizeof *notes.items, compare);
    while (pass->is_cut && i < notes.count && compare(&notes.items[i], &pass->after) <= 0) i++;
    pass->is_cut = false;
    for (; i < notes.count && !pass->is_cut; i++) {
        pass->after = notes.items[i];
        (void)sweep(&r, &pass->after);
        pass->is_cut = i + 1 < notes.count && uv_hrtime() - began_ns > PASS_NS;
    }
    free(notes.items);
    if (!pass->is_cut) removal_notes_each(room->objects, count_note, &pass->left);
    pass->took_us = (uv_hrtime() - began_ns) / 1000;
}

int asset_removal_check_import(sqlite3 *db, const struct asset_room *room,
                               const struct digest *assets, size_t count, const struct digest *blob)
{
    size_t there = 0;
    while (there < count && objects_have(room->objects, &assets[there], NULL)) there++;
    if (there == count) return 0;
    /* What another import gave, too, goes with the assets of that one. */
    const int error = asset_uses_is_derived(db, blob) ? 0 : removal_notes_add(room->objects, blob);
    return error ? error : ERR_NOT_FOUND;
}
