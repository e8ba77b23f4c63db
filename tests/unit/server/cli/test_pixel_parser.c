/* The command line's reader of pixel feeds: blocks from any cuts of the bytes; what is no feed is
 * refused before memory is taken for it. */
#include <string.h>

#include "proto/error.h"
#include "proto/job/job.h"
#include "server/cli/client/pixel_parser.h"
#include "server/stream/pixels.h"
#include "tests/unit/unit.h"

static uint8_t bytes[2 * PIXELS_HEADER_BYTES + 2 * PIXELS_MESSAGE_BYTES];

struct heard {
    int sizes, opaque, covered;
    uint64_t revision;
    float last, alpha;
    bool leave;
};

static bool hear(void *ctx, const struct pixel_block *b)
{
    struct heard *h = ctx;
    h->revision = b->revision;
    if (rect_is_empty(b->rect)) {
        assert_int_equal(b->width_px, 70);
        assert_int_equal(b->height_px, 60);
        h->sizes++;
        return !h->leave;
    }
    const size_t area = (size_t)rect_area(b->rect);
    *(b->alpha ? &h->covered : &h->opaque) += 1;
    h->last = b->numbers[3 * area - 1];
    if (b->alpha) h->alpha = b->alpha[area - 1];
    return true;
}

/* A size, an opaque block and one that is not. */
static size_t write_feed(void)
{
    struct image *image;
    size_t n = PIXELS_HEADER_BYTES;
    assert_int_equal(image_create(LAYER_BEAUTY, 70, 60, &image), 0);
    for (int32_t y = 0; y < 60; y++)
        for (int32_t x = 0; x < 70; x++) {
            *plane_at(image_plane(image, "A"), x, y) = x < 64 ? 1.0f : 0.5f;
            *plane_at(image_plane(image, "B"), x, y) = (float)x;
        }
    pixels_write_size(bytes, 70, 60, 3);
    n += pixels_write_block(bytes + n, image, "beauty", PIXELS_F32_ALPHA,
                            (struct rect){0, 0, 64, 60}, 4);
    n += pixels_write_block(bytes + n, image, "beauty", PIXELS_F32_ALPHA,
                            (struct rect){64, 0, 70, 60}, 5);
    image_destroy(&image);
    return n;
}

TEST(any_cut_gives_the_same_blocks)
{
    static const size_t cuts[] = {1, 7, 32, 1000, 1 << 20};
    const size_t size = write_feed();
    for (size_t k = 0; k < sizeof cuts / sizeof *cuts; k++) {
        struct pixel_parser p = {.data = NULL};
        struct heard heard = {0};
        for (size_t at = 0; at < size; at += cuts[k])
            assert_true(pixel_parser_feed(&p, bytes + at, size - at < cuts[k] ? size - at : cuts[k],
                                          hear, &heard));
        assert_true(heard.sizes == 1 && heard.opaque == 1 && heard.covered == 1);
        assert_true(heard.revision == 5 && heard.last == 69.0f && heard.alpha == 0.5f);
        pixel_parser_fini(&p);
    }
}

static bool hear_view(void *ctx, const struct pixel_block *b)
{
    struct pixel_block *heard = ctx;
    *heard = *b;
    return true;
}

TEST(a_view_tells_its_full_size)
{
    struct pixel_parser p = {.data = NULL};
    struct pixel_block heard = {.view = 1};
    pixels_write_view(bytes, 9, 640, 360, 3);
    assert_true(pixel_parser_feed(&p, bytes, PIXELS_HEADER_BYTES, hear_view, &heard));
    assert_true(heard.view == 9 && rect_is_empty(heard.rect));
    assert_true(heard.width_px == 640 && heard.height_px == 360 && heard.revision == 3);
    pixels_write_size(bytes, 160, 90, 4);
    assert_true(pixel_parser_feed(&p, bytes, PIXELS_HEADER_BYTES, hear_view, &heard));
    assert_true(heard.view == 0 && heard.width_px == 160 && heard.height_px == 90);
    pixel_parser_fini(&p);
}

TEST(what_is_no_feed_is_refused)
{
    static const struct {
        size_t at;
        uint8_t value;
    } faults[] = {{0, 'X'}, {4, 2}, {6, 1}, {6, 9}, {11, 1}, {18, 1}, {23, 0x80}};
    for (size_t k = 0; k < sizeof faults / sizeof *faults; k++) {
        struct pixel_parser p = {.data = NULL};
        struct heard heard = {0};
        const size_t size = write_feed();
        bytes[PIXELS_HEADER_BYTES + faults[k].at] = faults[k].value;
        assert_false(pixel_parser_feed(&p, bytes, size, hear, &heard));
        assert_int_equal(p.error, ERR_CORRUPT);
        assert_true(heard.opaque == 0 && p.held_bytes < 1u << 20);
        pixel_parser_fini(&p);
    }
}

TEST(a_reader_may_leave)
{
    struct pixel_parser p = {.data = NULL};
    struct heard heard = {.leave = true};
    const size_t size = write_feed();
    assert_false(pixel_parser_feed(&p, bytes, size, hear, &heard));
    assert_int_equal(p.error, 0);
    pixel_parser_restart(&p);
    heard.leave = false;
    assert_true(pixel_parser_feed(&p, bytes, size, hear, &heard));
    assert_int_equal(heard.covered, 1);
    pixel_parser_fini(&p);
}
