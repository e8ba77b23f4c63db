/* What was imported of an asset goes with it: server/store/asset_removal.h. */
#include "tests/unit/server/store/removal_case.h"

EACH_TEST(setup, teardown);

TEST(blobs_go_with_the_last_asset_that_gave_them)
{
    struct fixture *f = *state;
    const struct digest assets[] = {bring(f, "a", "scene"), bring(f, "a", "its file"),
                                    bring(f, "a", "another scene")};
    const struct digest one = store(f, "blob of one"), two = store(f, "blob of two");
    remember(f, "first", &one, assets, 2);
    remember(f, "second", &two, assets, 1);
    (void)store(f, "blob of two"); /* placed once more */
    remember(f, "third", &two, assets + 2, 1);
    assert_int_equal(give_up(f, "a", &assets[1]), 0); /* a file beside the scene */
    assert_false(is_there(f, &one));
    assert_true(is_there(f, &assets[0]) && is_there(f, &two));
    assert_int_equal(give_up(f, "a", &assets[0]), 0);
    assert_true(is_there(f, &two));
    assert_int_equal(give_up(f, "a", &assets[2]), 0);
    assert_false(is_there(f, &two));
}

static void on_blob(void *ctx, int error, const struct digest *blob)
{
    *(bool *)ctx = !error && blob;
}

/* Given up while it was imported for a dry run, whom no job row stands for. */
TEST(no_blob_is_remembered_of_what_is_gone)
{
    struct fixture *f = *state;
    const struct digest assets[] = {bring(f, "a", "scene"), bring(f, "a", "its file")},
                        blob = store(f, "blob"), source = {{1}};
    int error = 1;
    bool found = true;
    assert_int_equal(give_up(f, "a", &assets[1]), 0);
    job_store_remember_blob(f->store, &source, &blob, assets, 2, on_done, &error);
    job_store_find_blob(f->store, &source, on_blob, &found);
    settle(f);
    assert_int_equal(error, ERR_NOT_FOUND);
    assert_false(found);
    assert_true(is_there(f, &blob));
    objects_release(&f->objects, &blob);
    assert_true(goes(f, &blob));
    assert_true(is_there(f, &assets[0]));
}

/* Recorded, but held still, when the asset goes. */
TEST(a_held_blob_goes_after_its_asset)
{
    struct fixture *f = *state;
    const struct digest asset = bring(f, "a", "scene"), blob = store(f, "blob"), source = {{1}};
    int error = 1;
    job_store_remember_blob(f->store, &source, &blob, &asset, 1, on_done, &error);
    assert_int_equal(give_up(f, "a", &asset), 0);
    assert_int_equal(error, 0);
    assert_false(is_there(f, &asset) || is_noted(f, &asset));
    assert_true(is_there(f, &blob) && is_noted(f, &blob));
    objects_release(&f->objects, &blob);
    assert_true(goes(f, &blob));
}
