/* Who has an asset, from its upload on: server/store/asset_room.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/asset_removal.h"
#include "server/store/asset_tables.h"
#include "server/store/job_schema.h"
#include "tests/unit/unit.h"

#define QUOTA 10

struct fixture {
    char dir[64];
    struct objects objects;
    struct asset_room room;
    sqlite3 *db;
};

static int setup(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    char path[96];
    strcpy(f->dir, "/tmp/shearwater-room-XXXXXX");
    if (!mkdtemp(f->dir) || objects_open(&f->objects, f->dir, false)) return -1;
    *state = f;
    f->room = (struct asset_room){.objects = &f->objects, .tenant_bytes = QUOTA};
    snprintf(path, sizeof path, "%s/jobs.sqlite", f->dir);
    return job_schema_open(path, false, &f->db);
}

static int teardown(void **state)
{
    struct fixture *f = *state;
    sqlite3_close(f->db);
    objects_remove_dir(f->dir);
    free(f);
    return 0;
}

EACH_TEST(setup, teardown);

static struct digest digest_text(const char *text)
{
    struct digest d;
    digest_of(text, strlen(text), &d);
    return d;
}

static struct asset_claim claim_of(const char *owner, const char *text)
{
    struct asset_claim claim = {.asset = digest_text(text), .sees_all = !owner[0]};
    strcpy(claim.owner, owner);
    return claim;
}

/* Held from now on. */
static int keep(struct fixture *f, const char *owner, const char *text, bool *existed)
{
    const struct asset_claim claim = claim_of(owner, text);
    objects_hold(&f->objects, &claim.asset);
    return asset_room_keep(f->db, &f->room, &claim, strlen(text), existed);
}

static void let_go(struct fixture *f, const char *text)
{
    const struct digest d = digest_text(text);
    objects_release(&f->objects, &d);
}

static void place(struct fixture *f, const char *text)
{
    struct object_writer *w;
    struct digest d;
    assert_int_equal(object_writer_begin(&f->objects, &w), 0);
    assert_int_equal(object_writer_append(w, text, strlen(text)), 0);
    assert_int_equal(object_writer_seal(w, NULL, &d), 0);
    assert_int_equal(object_writer_place(&w, &d, NULL), 0);
    objects_release(&f->objects, &d);
    let_go(f, text);
}

/* true: it was new. */
static bool bring(struct fixture *f, const char *owner, const char *text)
{
    bool existed = true;
    assert_int_equal(keep(f, owner, text, &existed), 0);
    place(f, text);
    return !existed;
}

static bool sees(struct fixture *f, const char *owner, const char *text)
{
    const struct asset_claim claim = claim_of(owner, text);
    return asset_room_find(f->db, &f->room, &claim) == 0;
}

static bool is_noted(struct fixture *f, const char *text)
{
    const struct digest d = digest_text(text);
    return asset_removals_find(f->db, &d) == 0;
}

static bool has(struct fixture *f, const char *owner, const char *text)
{
    const struct digest d = digest_text(text);
    return asset_owners_find(f->db, owner, &d) == 0;
}

static void note(struct fixture *f, const char *text)
{
    const struct digest d = digest_text(text);
    assert_int_equal(asset_removals_add(f->db, &d), 0);
}

static void pass(struct fixture *f)
{
    struct removal_pass pass = {0};
    asset_removal_pass(f->db, &f->room, &pass);
}

TEST(what_is_kept_is_its_owners)
{
    struct fixture *f = *state;
    assert_true(bring(f, "a", "scene"));
    assert_true(sees(f, "a", "scene") && sees(f, "", "scene") && !sees(f, "b", "scene"));
    assert_false(bring(f, "a", "scene"));
    assert_true(bring(f, "b", "scene")); /* that another has it is not told */
    assert_true(sees(f, "b", "scene"));
}

TEST(what_is_not_placed_is_not_there)
{
    struct fixture *f = *state;
    bool existed;
    assert_int_equal(keep(f, "a", "scene", &existed), 0);
    assert_false(sees(f, "a", "scene") || sees(f, "", "scene"));
    place(f, "scene");
    assert_true(sees(f, "a", "scene"));
}

/* As after a kill: the next life holds nothing. */
TEST(a_start_drops_what_was_not_placed)
{
    struct fixture *f = *state;
    bool existed;
    assert_true(bring(f, "a", "there"));
    assert_int_equal(keep(f, "a", "scene", &existed), 0);
    let_go(f, "scene");
    asset_removal_resume(f->db, &f->room);
    assert_false(has(f, "a", "scene") || is_noted(f, "scene"));
    assert_true(sees(f, "a", "there") && !is_noted(f, "there"));
}

/* It could not be placed, while somebody else places the same. */
TEST(what_is_in_doubt_is_dropped_unless_it_is_there)
{
    struct fixture *f = *state;
    bool existed;
    assert_int_equal(keep(f, "a", "scene", &existed), 0);
    assert_int_equal(keep(f, "b", "scene", &existed), 0);
    let_go(f, "scene"); /* a's */
    note(f, "scene");
    pass(f);
    assert_true(has(f, "a", "scene") && is_noted(f, "scene"));
    place(f, "scene"); /* b's */
    pass(f);
    assert_true(sees(f, "b", "scene") && !is_noted(f, "scene"));
    assert_int_equal(keep(f, "a", "alone", &existed), 0);
    let_go(f, "alone");
    note(f, "alone");
    pass(f);
    assert_false(has(f, "a", "alone") || is_noted(f, "alone"));
}

TEST(a_tenants_assets_have_so_many_bytes)
{
    struct fixture *f = *state;
    struct asset_users users;
    bool existed;
    const struct asset_claim six = claim_of("a", "123456");
    assert_true(bring(f, "a", "123456"));
    assert_int_equal(keep(f, "a", "12345", &existed), ERR_QUOTA);
    assert_false(has(f, "a", "12345"));
    assert_true(bring(f, "a", "1234"));
    assert_false(bring(f, "a", "123456")); /* counts once */
    assert_true(bring(f, "b", "12345") && bring(f, "", "more than any tenant may have"));
    assert_int_equal(asset_removal_run(f->db, &f->room, &six, &users), 0);
    assert_true(bring(f, "a", "654321"));
}

/* The last of three, the first of three, and none. */
TEST(others_are_found_beside_an_owner)
{
    struct fixture *f = *state;
    const struct digest d = digest_text("scene");
    assert_int_equal(asset_owners_find_other(f->db, NULL, &d), ERR_NOT_FOUND);
    assert_true(bring(f, "a", "another") && bring(f, "b", "another") && bring(f, "c", "scene"));
    assert_int_equal(asset_owners_find_other(f->db, NULL, &d), 0);
    assert_int_equal(asset_owners_find_other(f->db, "a", &d), 0);
    assert_int_equal(asset_owners_find_other(f->db, "c", &d), ERR_NOT_FOUND);
    assert_true(bring(f, "", "scene"));
    assert_int_equal(asset_owners_find_other(f->db, "c", &d), 0);
    assert_int_equal(asset_owners_find_other(f->db, "", &d), 0);
}
