#pragma once
/* Feeds of pixels without an HTTP server: a test asks them for bytes as MHD would, and reads
 * messages. */
#include <microhttpd.h>
#include <stdbool.h>

#include "proto/job/job.h"
#include "server/stream/streams.h"
#include "tests/unit/unit.h"

enum { WIDTH = 130, HEIGHT = 70, BLOCKS = 3 * 2 };

/* A feed in place of MHD's response: MHD would ask it for bytes when its connection can take some.
 */
struct MHD_Response {
    MHD_ContentReaderCallback read;
    MHD_ContentReaderFreeCallback free;
    void *ctx;
};

extern int socket_of_all;
void feed_end(struct MHD_Response *feed);

struct heard {
    uint32_t width, height;
    uint64_t revision;
    uint16_t red; /* of the block's first pixel, a half float */
};

/* The next message: false when the feed has ended or has nothing to say. */
bool hear(struct MHD_Response *feed, struct heard *heard);

struct image *image_of(float red);
static const struct pixels_request wanted = {.layer = "beauty", .format = PIXELS_F16};
static const char job[] = "0123456789abcdefghijklmnop";

/* Counts the blocks that are due, all of that value. */
int blocks_due(struct MHD_Response *feed, uint16_t red);

static const struct rect everything = {0, 0, WIDTH, HEIGHT};
