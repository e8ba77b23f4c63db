/* The pixel feed's messages as a reader gets them: who stops in the middle knows what it lacks. */
#include "tests/unit/server/stream/fake_feed.h"
#include "tests/unit/unit.h"

TEST(a_still_picture_is_whole_with_its_last_block)
{
    struct streams *streams = NULL;
    struct heard heard;
    assert_int_equal(streams_create(&streams), 0);
    struct MHD_Response *feed = stream_still_response(streams, NULL, image_of(1), &wanted);
    assert_non_null(feed);
    assert_true(hear(feed, &heard));
    assert_int_equal(heard.width, 0);
    assert_int_equal(heard.revision, 0);
    for (int i = 0; i < BLOCKS; i++) {
        assert_true(hear(feed, &heard));
        assert_true(heard.width > 0);
        assert_int_equal(heard.revision, i == BLOCKS - 1 ? PIXELS_STILL_REVISION : 0);
    }
    assert_false(hear(feed, &heard));
    feed_end(feed);
    streams_destroy(&streams);
}

TEST(another_image_replaces_all_of_the_one_before)
{
    struct streams *streams = NULL;
    struct image *one = image_of(1), *two = image_of(2);
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, one);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wanted);
    assert_non_null(feed);
    assert_int_equal(blocks_due(feed, 0x3c00), 0); /* nothing was drawn yet */
    stream_pixels(streams, job, (struct rect){0, 0, 65, 1});
    assert_int_equal(blocks_due(feed, 0x3c00), 2);
    stream_image(streams, job, NULL);
    stream_image(streams, job, two); /* drawn while the other was shown */
    assert_int_equal(blocks_due(feed, 0x4000), BLOCKS);
    assert_int_equal(blocks_due(feed, 0x4000), 0);
    /* At once, too: what was due of the one before is not. */
    stream_pixels(streams, job, (struct rect){0, 0, 65, 1});
    stream_image(streams, job, one);
    assert_int_equal(streams->cache_budget.kept_bytes, 0);
    assert_int_equal(blocks_due(feed, 0x3c00), BLOCKS);
    stream_image(streams, job, NULL);
    feed_end(feed);
    streams_destroy(&streams);
    image_destroy(&one);
    image_destroy(&two);
}

/* Takes what is due: "v" for a view, "s" for a size, "b" for a block. */
static const char *messages_due(struct MHD_Response *feed)
{
    static char said[64];
    struct heard heard;
    size_t n = 0;
    while (n + 1 < sizeof said && hear(feed, &heard))
        said[n++] = heard.width > 0 ? 'b' : heard.height > 0 ? 'v' : 's';
    said[n] = '\0';
    return said;
}

TEST(a_view_has_nothing_of_the_one_before)
{
    struct streams *streams = NULL;
    struct image *one = image_of(1), *two = image_of(2);
    const struct stream_view first = {.number = 1, .width_px = 400, .height_px = 300};
    const struct stream_view second = {.number = 2, .width_px = 400, .height_px = 300};
    assert_int_equal(streams_create(&streams), 0);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wanted);
    stream_view(streams, job, one, &first);
    assert_memory_equal(messages_due(feed), "vs", 2);
    stream_pixels(streams, job, (struct rect){0, 0, 65, 1});
    stream_image(streams, job, NULL); /* moved, before the reader has looked */
    assert_string_equal(messages_due(feed), "");
    stream_view(streams, job, two, &second);
    assert_memory_equal(messages_due(feed), "vs", 2);
    stream_pixels(streams, job, (struct rect){0, 0, 1, 1});
    assert_int_equal(blocks_due(feed, 0x4000), 1);
    stream_image(streams, job, one);
    assert_true(blocks_due(feed, 0x3c00) == BLOCKS); /* no view: as ever */
    stream_image(streams, job, NULL);
    feed_end(feed);
    streams_destroy(&streams);
    image_destroy(&one);
    image_destroy(&two);
}

TEST(who_is_behind_has_the_whole_picture_after_its_end)
{
    struct streams *streams = NULL;
    struct image *image = image_of(1), *two = image_of(2);
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, image);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wanted);
    struct MHD_Response *done = stream_pixels_response(streams, job, NULL, &wanted);
    struct heard heard;
    assert_true(hear(feed, &heard));
    stream_pixels(streams, job, everything);
    assert_int_equal(blocks_due(done, 0x3c00), BLOCKS);
    stream_image(streams, job, NULL);
    image_destroy(&image);
    stream_event(streams, job, "state", NULL, true);
    assert_int_equal(blocks_due(feed, 0x3c00), BLOCKS);
    assert_int_equal(blocks_due(done, 0x3c00), 0);
    feed_end(feed);
    /* Another picture replaces what was kept. */
    stream_image(streams, job, two);
    assert_int_equal(blocks_due(done, 0x4000), BLOCKS);
    stream_image(streams, job, NULL);
    feed_end(done);
    streams_destroy(&streams);
    image_destroy(&two);
}

/* Feeds outlive their stream. */
TEST(a_forgotten_picture_leaves_no_reader_behind)
{
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, image);
    struct MHD_Response *a = stream_pixels_response(streams, job, NULL, &wanted);
    struct MHD_Response *b = stream_pixels_response(streams, job, NULL, &wanted);
    stream_pixels(streams, job, everything);
    uint8_t part[100];
    struct heard heard;
    assert_true(hear(a, &heard));
    assert_int_equal(a->read(a->ctx, 0, (char *)part, sizeof part), sizeof part);
    stream_forget(streams, job);
    feed_end(b);
    while (a->read(a->ctx, 0, (char *)part, sizeof part) > 0) {
    }
    feed_end(a);
    streams_destroy(&streams);
    image_destroy(&image);
}
