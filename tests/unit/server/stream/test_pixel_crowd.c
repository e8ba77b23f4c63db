/* Many who read one picture: what is made for all, who waits for a turn, who is cut. */
#include <time.h>

#include "tests/unit/server/stream/fake_feed.h"
#include "tests/unit/unit.h"

TEST(blocks_are_made_once_for_all)
{
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct MHD_Response *feeds[5];
    struct streams_totals totals;
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, image);
    for (int i = 0; i < 5; i++) feeds[i] = stream_pixels_response(streams, job, NULL, &wanted);
    stream_pixels(streams, job, everything);
    for (int i = 0; i < 5; i++) assert_int_equal(blocks_due(feeds[i], 0x3c00), BLOCKS);
    streams_totals(streams, &totals);
    assert_int_equal(totals.blocks_made, BLOCKS);
    assert_int_equal(totals.blocks_sent, 5 * BLOCKS);
    /* What changes is made again: nobody is sent what was there before. */
    *plane_at(image_plane(image, "R"), 64, 0) = 2;
    stream_pixels(streams, job, (struct rect){64, 0, 65, 1});
    for (int i = 0; i < 5; i++) assert_int_equal(blocks_due(feeds[i], 0x4000), 1);
    streams_totals(streams, &totals);
    assert_int_equal(totals.blocks_made, BLOCKS + 1);
    for (int i = 0; i < 5; i++) feed_end(feeds[i]);
    stream_image(streams, job, NULL);
    streams_destroy(&streams);
    image_destroy(&image);
}

enum { MANY = 12, TURNS = 4 };

static const struct streams_limits few_bytes = {.feed_bytes_per_s = TURNS * RATE_LIMIT_TURN_BYTES,
                                                .stuck_ms = UINT64_MAX};

static int blocks_of_all(struct MHD_Response **feeds, int count, int *complete)
{
    int blocks = 0;
    *complete = 0;
    for (int i = 0; i < count; i++) {
        const int more = blocks_due(feeds[i], 0x3c00);
        *complete += more == BLOCKS;
        blocks += more;
    }
    return blocks;
}

TEST(many_feeds_share_what_may_be_sent)
{
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct MHD_Response *feeds[MANY];
    int complete, ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    socket_of_all = ends[0]; /* nobody has hung up */
    assert_int_equal(streams_create(&streams), 0);
    streams_limit(streams, &few_bytes);
    stream_image(streams, job, image);
    /* A handful is not limited. */
    for (int i = 0; i < 8; i++) feeds[i] = stream_pixels_response(streams, job, NULL, &wanted);
    stream_pixels(streams, job, everything);
    assert_int_equal(blocks_of_all(feeds, 8, &complete), 8 * BLOCKS);
    assert_false(streams_wait(streams));
    for (int i = 8; i < MANY; i++) feeds[i] = stream_pixels_response(streams, job, NULL, &wanted);
    assert_int_equal(blocks_of_all(feeds, MANY, &complete), (MANY - 8) * BLOCKS);
    assert_false(streams_wait(streams));
    streams_limit(streams, &few_bytes); /* the budget of a second */
    stream_pixels(streams, job, everything);
    blocks_of_all(feeds, MANY, &complete);
    assert_true(complete >= 1 && complete < MANY);
    assert_true(streams_wait(streams));
    /* Who stands in line gives a sign of life, and stays there. */
    struct heard heard;
    struct MHD_Response *last = feeds[MANY - 1];
    assert_false(hear(last, &heard));
    streams->beat_ms = 0;
    streams_tick(streams);
    assert_true(hear(last, &heard));
    assert_int_equal(heard.width, 0);
    assert_false(hear(last, &heard));
    assert_true(streams_wait(streams));
    /* Time brings the others their turns, in order. */
    const time_t begun = time(NULL);
    while (complete < MANY && time(NULL) - begun < 30) {
        int more;
        usleep(5000);
        (void)streams_pace(streams);
        blocks_of_all(feeds, MANY, &more);
        complete += more;
    }
    assert_int_equal(complete, MANY);
    /* A picture is in work until its job has ended: its files are written when it is gone. */
    stream_pixels(streams, job, everything);
    blocks_of_all(feeds, MANY, &complete);
    stream_image(streams, job, NULL);
    (void)streams_pace(streams);
    assert_true(streams_wait(streams));
    /* Where nothing is in work nobody waits. */
    stream_event(streams, job, "state", NULL, true);
    (void)streams_pace(streams);
    assert_false(streams_wait(streams));
    int more;
    blocks_of_all(feeds, MANY, &more);
    assert_int_equal(complete + more, MANY);
    for (int i = 0; i < MANY; i++) feed_end(feeds[i]);
    streams_destroy(&streams);
    image_destroy(&image);
    close(ends[0]);
    close(ends[1]);
}

TEST(who_takes_nothing_is_cut_and_counted)
{
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct streams_totals totals;
    int ends[2];
    uint8_t bytes[64];
    struct heard heard;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    socket_of_all = ends[0];
    assert_int_equal(streams_create(&streams), 0);
    streams_limit(streams, &(struct streams_limits){.stuck_ms = 50});
    stream_image(streams, job, image);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wanted);
    while (hear(feed, &heard)) {
    } /* it sleeps: it has all */
    usleep(80000);
    streams_tick(streams);
    streams_totals(streams, &totals);
    assert_int_equal(totals.cut_pixels, 0);
    stream_pixels(streams, job, everything); /* awake, and takes a part of a block alone */
    assert_int_equal(feed->read(feed->ctx, 0, (char *)bytes, sizeof bytes), sizeof bytes);
    streams_tick(streams);
    streams_totals(streams, &totals);
    assert_int_equal(totals.cut_pixels, 0);
    usleep(80000);
    streams_tick(streams);
    streams_tick(streams);
    streams_totals(streams, &totals);
    assert_int_equal(totals.cut_pixels, 1);
    assert_int_equal(recv(ends[1], bytes, sizeof bytes, MSG_DONTWAIT), 0);
    stream_image(streams, job, NULL);
    feed_end(feed);
    streams_destroy(&streams);
    image_destroy(&image);
    close(ends[0]);
    close(ends[1]);
}

/* Bytes leave its socket, though too few for MHD to ask for more. */
TEST(who_takes_little_is_not_cut)
{
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct streams_totals totals;
    int ends[2];
    uint8_t bytes[64];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    socket_of_all = ends[0];
    for (int i = 0; i < 8; i++)
        assert_int_equal(send(ends[0], bytes, sizeof bytes, 0), sizeof bytes);
    assert_int_equal(streams_create(&streams), 0);
    streams_limit(streams, &(struct streams_limits){.stuck_ms = 50});
    stream_image(streams, job, image);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wanted);
    stream_pixels(streams, job, everything);
    assert_int_equal(feed->read(feed->ctx, 0, (char *)bytes, 16), 16);
    for (int i = 0; i < 6; i++) {
        usleep(20000);
        assert_int_equal(recv(ends[1], bytes, sizeof bytes, 0), sizeof bytes);
        streams_tick(streams);
    }
    streams_totals(streams, &totals);
    assert_int_equal(totals.cut_pixels, 0);
    usleep(80000);
    streams_tick(streams);
    streams_totals(streams, &totals);
    assert_int_equal(totals.cut_pixels, 1);
    stream_image(streams, job, NULL);
    feed_end(feed);
    streams_destroy(&streams);
    image_destroy(&image);
    close(ends[0]);
    close(ends[1]);
}
