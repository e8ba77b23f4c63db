#include "tests/unit/server/stream/fake_feed.h"

#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

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

int socket_of_all = -1;

const union MHD_ConnectionInfo *MHD_get_connection_info(struct MHD_Connection *connection,
                                                        enum MHD_ConnectionInfoType type, ...)
{
    static union MHD_ConnectionInfo info;
    (void)connection;
    (void)type;
    info.connect_fd = socket_of_all;
    return &info;
}

void feed_end(struct MHD_Response *feed)
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

bool hear(struct MHD_Response *feed, struct heard *heard)
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

struct image *image_of(float red)
{
    struct image *image = NULL;
    assert_int_equal(image_create(LAYER_BEAUTY, WIDTH, HEIGHT, &image), 0);
    const struct plane *plane = image_plane(image, "R");
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) *plane_at(plane, x, y) = red;
    return image;
}

int blocks_due(struct MHD_Response *feed, uint16_t red)
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
