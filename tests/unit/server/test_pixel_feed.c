/* The pixel feed's messages as a reader gets them: who stops in the middle knows what it lacks. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "proto/job.h"
#include "server/stream/streams.h"

enum { WIDTH = 130, HEIGHT = 70, BLOCKS = 3 * 2 };

/* A feed in place of MHD's response: MHD would ask it for bytes when its connection can take some.
 */
struct MHD_Response {
    MHD_ContentReaderCallback read;
    MHD_ContentReaderFreeCallback free;
    void *ctx;
};

struct MHD_Response *MHD_create_response_from_callback(uint64_t size, size_t block_size,
                                                       MHD_ContentReaderCallback crc, void *crc_cls,
                                                       MHD_ContentReaderFreeCallback crfc)
{
    (void)size;
    (void)block_size;
    struct MHD_Response *response = malloc(sizeof *response);
    if (response) *response = (struct MHD_Response){crc, crfc, crc_cls};
    return response;
}

void MHD_suspend_connection(struct MHD_Connection *connection)
{
    (void)connection;
}

void MHD_resume_connection(struct MHD_Connection *connection)
{
    (void)connection;
}

static int socket_of_all = -1;

const union MHD_ConnectionInfo *MHD_get_connection_info(struct MHD_Connection *connection,
                                                        enum MHD_ConnectionInfoType type, ...)
{
    static union MHD_ConnectionInfo info;
    (void)connection;
    (void)type;
    info.connect_fd = socket_of_all;
    return &info;
}

static void feed_end(struct MHD_Response *feed)
{
    feed->free(feed->ctx);
    free(feed);
}

static uint64_t read_number(const uint8_t *at, int bytes)
{
    uint64_t v = 0;
    for (int i = bytes; i-- > 0;) v = v << 8 | at[i];
    return v;
}

struct heard {
    uint32_t width, height;
    uint64_t revision;
    uint16_t red; /* of the block's first pixel, a half float */
};

/* The next message: false when the feed has ended or has nothing to say. */
static bool hear(struct MHD_Response *feed, struct heard *heard)
{
    static uint8_t bytes[PIXELS_MESSAGE_BYTES];
    static ssize_t left, at; /* two short messages may come at once */
    ssize_t got = left;
    if (left > 0)
        memmove(bytes, bytes + at, (size_t)left);
    else
        got = feed->read(feed->ctx, 0, (char *)bytes, sizeof bytes);
    if (got <= 0) return false;
    at = read_number(bytes + 16, 4) == 0 ? (ssize_t)PIXELS_HEADER_BYTES : got;
    left = got - at;
    assert_true(got >= (ssize_t)PIXELS_HEADER_BYTES);
    assert_memory_equal(bytes, "SWPX", 4);
    *heard = (struct heard){.width = (uint32_t)read_number(bytes + 16, 4),
                            .height = (uint32_t)read_number(bytes + 20, 4),
                            .revision = read_number(bytes + 24, 8)};
    if (heard->width > 0) heard->red = (uint16_t)read_number(bytes + PIXELS_HEADER_BYTES, 2);
    return true;
}

static struct image *image_of(float red)
{
    struct image *image = NULL;
    assert_int_equal(image_create(LAYER_BEAUTY, WIDTH, HEIGHT, &image), 0);
    const struct plane *plane = image_plane(image, "R");
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) *plane_at(plane, x, y) = red;
    return image;
}

static const struct pixels_wish wish = {.layer = "beauty", .format = PIXELS_F16};
static const char job[] = "0123456789abcdefghijklmnop";

static void a_still_picture_is_whole_with_its_last_block(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct heard heard;
    assert_int_equal(streams_create(&streams), 0);
    struct MHD_Response *feed = stream_still_response(streams, NULL, image_of(1), &wish);
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

/* Counts the blocks that are due, all of that value. */
static int blocks_due(struct MHD_Response *feed, uint16_t red)
{
    struct heard heard;
    int blocks = 0;
    while (hear(feed, &heard)) {
        if (heard.width == 0) continue;
        assert_int_equal(heard.red, red);
        blocks++;
    }
    return blocks;
}

static void another_image_replaces_all_of_the_one_before(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *one = image_of(1), *two = image_of(2);
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, one);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wish);
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
    assert_int_equal(streams->sheet_budget.kept_bytes, 0);
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

static void a_view_has_nothing_of_the_one_before(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *one = image_of(1), *two = image_of(2);
    const struct stream_view first = {.number = 1, .width_px = 400, .height_px = 300};
    const struct stream_view second = {.number = 2, .width_px = 400, .height_px = 300};
    assert_int_equal(streams_create(&streams), 0);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wish);
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

static const struct rect everything = {0, 0, WIDTH, HEIGHT};

static void blocks_are_made_once_for_all(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct MHD_Response *feeds[5];
    struct streams_totals totals;
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, image);
    for (int i = 0; i < 5; i++) feeds[i] = stream_pixels_response(streams, job, NULL, &wish);
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

static void who_is_behind_has_the_whole_picture_after_its_end(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *image = image_of(1), *two = image_of(2);
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, image);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wish);
    struct MHD_Response *done = stream_pixels_response(streams, job, NULL, &wish);
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
static void a_forgotten_picture_leaves_no_reader_behind(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    assert_int_equal(streams_create(&streams), 0);
    stream_image(streams, job, image);
    struct MHD_Response *a = stream_pixels_response(streams, job, NULL, &wish);
    struct MHD_Response *b = stream_pixels_response(streams, job, NULL, &wish);
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

enum { MANY = 12, TURNS = 4 };

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

static void many_feeds_share_what_may_be_sent(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct MHD_Response *feeds[MANY];
    int complete, ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    socket_of_all = ends[0]; /* nobody has hung up */
    assert_int_equal(streams_create(&streams), 0);
    streams_limit(streams, TURNS * PACE_TURN_BYTES, UINT64_MAX);
    stream_image(streams, job, image);
    /* A handful is not limited. */
    for (int i = 0; i < 8; i++) feeds[i] = stream_pixels_response(streams, job, NULL, &wish);
    stream_pixels(streams, job, everything);
    assert_int_equal(blocks_of_all(feeds, 8, &complete), 8 * BLOCKS);
    assert_false(streams_wait(streams));
    for (int i = 8; i < MANY; i++) feeds[i] = stream_pixels_response(streams, job, NULL, &wish);
    assert_int_equal(blocks_of_all(feeds, MANY, &complete), (MANY - 8) * BLOCKS);
    assert_false(streams_wait(streams));
    streams_limit(streams, TURNS * PACE_TURN_BYTES, UINT64_MAX); /* the budget of a second */
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
    /* Where nothing is in work nobody waits. */
    stream_pixels(streams, job, everything);
    blocks_of_all(feeds, MANY, &complete);
    stream_image(streams, job, NULL);
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

static void who_takes_nothing_is_cut_and_counted(void **state)
{
    (void)state;
    struct streams *streams = NULL;
    struct image *image = image_of(1);
    struct streams_totals totals;
    int ends[2];
    uint8_t bytes[64];
    struct heard heard;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    socket_of_all = ends[0];
    assert_int_equal(streams_create(&streams), 0);
    streams_limit(streams, 0, 50);
    stream_image(streams, job, image);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wish);
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
static void who_takes_little_is_not_cut(void **state)
{
    (void)state;
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
    streams_limit(streams, 0, 50);
    stream_image(streams, job, image);
    struct MHD_Response *feed = stream_pixels_response(streams, job, NULL, &wish);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_still_picture_is_whole_with_its_last_block),
        cmocka_unit_test(blocks_are_made_once_for_all),
        cmocka_unit_test(who_is_behind_has_the_whole_picture_after_its_end),
        cmocka_unit_test(a_forgotten_picture_leaves_no_reader_behind),
        cmocka_unit_test(many_feeds_share_what_may_be_sent),
        cmocka_unit_test(who_takes_nothing_is_cut_and_counted),
        cmocka_unit_test(who_takes_little_is_not_cut),
        cmocka_unit_test(another_image_replaces_all_of_the_one_before),
        cmocka_unit_test(a_view_has_nothing_of_the_one_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
