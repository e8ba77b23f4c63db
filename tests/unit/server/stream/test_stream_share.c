/* Streams within their share of CPU time: readers whose every byte is dear, as a socket's are. */
#include <time.h>

#include "tests/unit/server/stream/fake_feed.h"
#include "tests/unit/unit.h"

enum { MANY = 20, PER_S = 40000, DEAR_US = 500 };

static const struct streams_limits limits = {.cpu_us_per_s = PER_S, .stuck_ms = UINT64_MAX};

static volatile unsigned burnt;
static uint64_t
    dearer_us; /* what sending took beyond that: a machine whose neighbours take of it */

/* The time of the thread goes to who was asked for bytes last, as MHD's sending does. */
static void send_it(struct streams *streams, enum cpu_meter_kind kind)
{
    const uint64_t end_us = cpu_meter_us(&streams->meter, kind) + DEAR_US;
    uint64_t now_us;
    while ((now_us = cpu_meter_us(&streams->meter, kind)) < end_us)
        for (int i = 0; i < 200; i++) burnt++;
    dearer_us += now_us - end_us;
}

/* Reads what is due to those who are awake; how many of them got something. */
static int read_awake(struct streams *streams, enum cpu_meter_kind kind,
                      struct MHD_Response *const *feed)
{
    static char bytes[PIXELS_MESSAGE_BYTES];
    int got = 0;
    for (int i = 0; i < MANY; i++) {
        const struct reader *r = feed[i]->ctx; /* base is its first member */
        bool any = false;
        while (!r->suspended && feed[i]->read(feed[i]->ctx, 0, bytes, sizeof bytes) > 0) {
            send_it(streams, kind);
            any = true;
        }
        got += any;
    }
    (void)cpu_meter_switch(&streams->meter, CPU_METER_NONE);
    return got;
}

struct crowd {
    struct streams *streams;
    struct MHD_Response *feed[MANY];
    int ends[2];
};

static void crowd_open(struct crowd *c)
{
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, c->ends), 0);
    socket_of_all = c->ends[0];
    assert_int_equal(streams_create(&c->streams), 0);
    streams_limit(c->streams, &limits);
}

static void crowd_close(struct crowd *c)
{
    for (int i = 0; i < MANY; i++) feed_end(c->feed[i]);
    streams_destroy(&c->streams);
    close(c->ends[0]);
    close(c->ends[1]);
}

static void tell(struct streams *streams, const char *name)
{
    json_t *data = json_pack("{s:i}", "v", 1);
    stream_event(streams, job, name, data, false);
    json_decref(data);
}

/* What they may take since then; a round more may have begun, and nobody foresees what was dearer.
 */
static uint64_t allowed_us(uint64_t begun_us, uint64_t per_s)
{
    return per_s / 4 + per_s * (streams_clock_us() - begun_us) / 1000000u + MANY * DEAR_US +
           dearer_us;
}

/* For 3 s, and, since what was dearer is paid before anybody gets more, as much longer: 30 s at
 * most. */
static bool goes_on(uint64_t begun_us, uint64_t per_s)
{
    const uint64_t past_us = streams_clock_us() - begun_us;
    return past_us < 30000000 && past_us < 3000000 + dearer_us * 1000000 / per_s;
}

TEST(progress_waits_and_news_do_not)
{
    struct crowd c;
    struct streams_totals totals;
    crowd_open(&c);
    dearer_us = 0;
    for (int i = 0; i < MANY; i++)
        c.feed[i] = stream_events_response(c.streams, job, NULL, 0, json_object(), false);
    assert_int_equal(read_awake(c.streams, CPU_METER_EVENTS, c.feed), MANY);
    const uint64_t begun_us = streams_clock_us();
    int told = 0;
    while (goes_on(begun_us, PER_S / 2)) {
        tell(c.streams, "progress");
        told += read_awake(c.streams, CPU_METER_EVENTS, c.feed);
        usleep(10000);
    }
    streams_totals(c.streams, &totals);
    /* The first round was the snapshots'. Without the share there would be ten a second. */
    assert_true(totals.events_cpu_us <= 2 * MANY * DEAR_US + allowed_us(begun_us, PER_S / 2));
    assert_true(told >= 2 * MANY && told <= 9 * MANY);
    assert_true(totals.tells_late > 0);
    /* They owe now, or soon: but what is new goes out, and so does the end. */
    for (int i = 0; i < 8; i++) {
        tell(c.streams, "state");
        assert_int_equal(read_awake(c.streams, CPU_METER_EVENTS, c.feed), MANY);
    }
    assert_false(streams_may_tell(c.streams));
    stream_event(c.streams, job, "state", NULL, true);
    for (int i = 0; i < MANY; i++) assert_false(((struct reader *)c.feed[i]->ctx)->suspended);
    crowd_close(&c);
}

/* That it is given now; each is sent at some cost. */
static int blocks_for(struct crowd *c, int i)
{
    const struct reader *r = c->feed[i]->ctx;
    struct heard heard;
    int blocks = 0;
    while (!r->suspended && hear(c->feed[i], &heard)) {
        send_it(c->streams, CPU_METER_PIXELS);
        blocks += heard.width > 0;
    }
    (void)cpu_meter_switch(&c->streams->meter, CPU_METER_NONE);
    return blocks;
}

TEST(feeds_share_the_time_and_get_all)
{
    struct crowd c;
    struct image *image = image_of(1);
    struct streams_totals totals;
    int got[MANY] = {0}, most = 0, least = 1 << 20;
    crowd_open(&c);
    stream_image(c.streams, job, image);
    for (int i = 0; i < MANY; i++)
        c.feed[i] = stream_pixels_response(c.streams, job, NULL, &wanted);
    read_awake(c.streams, CPU_METER_PIXELS, c.feed); /* its size */
    streams_totals(c.streams, &totals);
    const uint64_t before_us = totals.pixels_cpu_us, begun_us = streams_clock_us();
    dearer_us = 0;
    while (goes_on(begun_us, PER_S)) {
        stream_pixels(c.streams, job, everything);
        for (int i = 0; i < MANY; i++) got[i] += blocks_for(&c, i);
        usleep(RATE_LIMIT_EVERY_MS * 1000);
        (void)streams_pace(c.streams);
    }
    streams_totals(c.streams, &totals);
    assert_true(totals.pixels_cpu_us - before_us <= allowed_us(begun_us, PER_S));
    assert_true(totals.waits > 0);
    for (int i = 0; i < MANY; i++) {
        most = got[i] > most ? got[i] : most;
        least = got[i] < least ? got[i] : least;
    }
    print_message("# of pictures of %d blocks each got %d to %d blocks; dearer by %llu us\n",
                  BLOCKS, least, most, (unsigned long long)dearer_us);
    assert_true(least > 0 && most - least <= 3 * BLOCKS);
    /* The end: all have the last picture soon. */
    stream_pixels(c.streams, job, everything);
    stream_image(c.streams, job, NULL);
    stream_event(c.streams, job, "state", NULL, true);
    (void)streams_pace(c.streams);
    assert_false(streams_wait(c.streams));
    for (int i = 0; i < MANY; i++) assert_int_equal(blocks_due(c.feed[i], 0x3c00), BLOCKS);
    crowd_close(&c);
    image_destroy(&image);
}

/* What MHD does until it is told otherwise, for about so long. */
static void work_us(uint64_t us)
{
    struct timespec at;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
    const struct timespec begun = at;
    do clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
    while ((uint64_t)((at.tv_sec - begun.tv_sec) * 1000000 + (at.tv_nsec - begun.tv_nsec) / 1000) <
           us);
}

/* A turn of MHD's that begins with so much work; what events paid for it. */
static uint64_t paid_us(struct streams *streams)
{
    const uint64_t before_us = cpu_meter_us(&streams->meter, CPU_METER_EVENTS);
    streams_meter_run(streams);
    work_us(20000);
    streams_meter_ran(streams);
    return cpu_meter_us(&streams->meter, CPU_METER_EVENTS) - before_us;
}

TEST(turns_begin_with_what_is_due)
{
    struct crowd c;
    char bytes[PIXELS_MESSAGE_BYTES];
    crowd_open(&c);
    dearer_us = 0;
    for (int i = 0; i < MANY; i++)
        c.feed[i] = stream_events_response(c.streams, job, NULL, 0, json_object(), false);
    read_awake(c.streams, CPU_METER_EVENTS, c.feed);
    c.streams->due = CPU_METER_NONE; /* as if MHD had sent all that */
    /* They are awake: but others' handshakes may come before them. */
    tell(c.streams, "state");
    assert_false(((const struct reader *)c.feed[0]->ctx)->suspended);
    assert_true(paid_us(c.streams) < 10000); /* of 20000 */
    /* What one of them has given is sent on their time, once. */
    assert_true(c.feed[0]->read(c.feed[0]->ctx, 0, bytes, sizeof bytes) > 0);
    streams_meter_ran(c.streams);
    assert_in_range(paid_us(c.streams), 20000, 100000);
    assert_true(paid_us(c.streams) < 10000); /* of 20000 */
    crowd_close(&c);
}
