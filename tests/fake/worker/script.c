#include "tests/fake/worker/script.h"

#include <string.h>

#include "tests/fake/worker/link.h"
#include "tests/fake/worker/result.h"

static void tile_echo(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    result_send(f, request_id, tile, result_zero_samples(f, tile));
    link_send_want(f, 1);
}

static void tile_ignored(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    (void)f;
    (void)request_id;
    (void)tile;
}

static void send_whole(struct fake *f, struct bytes_writer *whole)
{
    f->answers++;
    link_send(f, whole->data, whole->size_bytes);
    bytes_writer_fini(whole);
}

static void flip(struct bytes_writer *whole, size_t bit)
{
    whole->data[bit / 8] ^= (uint8_t)(1u << (bit % 8));
}

/* The whole frame is right but for one bit, after the checksum was made. */
static void tile_flip(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct bytes_writer whole;
    result_whole(f, request_id, tile, &whole);
    size_t payload_bytes = whole.size_bytes - WIRE_FRAME_HEADER_BYTES;
    flip(&whole, 8 * WIRE_FRAME_HEADER_BYTES + (f->answers * 2654435761u) % (8 * payload_bytes));
    send_whole(f, &whole);
}

/* One bit of the header after the other, a link each. */
static void tile_header(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct bytes_writer whole;
    result_whole(f, request_id, tile, &whole);
    flip(&whole, f->answers % (8 * WIRE_FRAME_HEADER_BYTES));
    send_whole(f, &whole);
    link_end_soon(f);
}

/* splitmix64, of the number of the answer. */
static uint64_t random_of(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* One to eight bytes of the body are others than the checksum says, a link each. */
static void tile_mutate(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct bytes_writer whole;
    result_whole(f, request_id, tile, &whole);
    const uint64_t seed = random_of(f->answers);
    const size_t body_bytes = whole.size_bytes - WIRE_FRAME_HEADER_BYTES;
    uint8_t *body = whole.data + WIRE_FRAME_HEADER_BYTES;
    const uint32_t right = wire_frame_crc32c(0, body, body_bytes);
    for (uint64_t i = 0; i < 1 + seed % 8; i++) {
        const uint64_t r = random_of(seed + i);
        body[(r >> 8) % body_bytes] ^= (uint8_t)(1 + r % 255);
    }
    /* A few in a million change a byte twice, back to what it was. */
    if (wire_frame_crc32c(0, body, body_bytes) == right) body[0] ^= 1;
    send_whole(f, &whole);
    link_end_soon(f);
}

static void tile_die(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    (void)request_id;
    (void)tile;
    link_lose(f);
}

static void answer_once(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                        int32_t width, int32_t height, enum lie lie)
{
    struct bytes_writer packed;
    result_pack(f, tile, width, height, lie, &packed);
    result_send(f, request_id, tile, &packed);
    bytes_writer_fini(&packed);
    link_send_want(f, 1);
}

static void tile_lie(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    answer_once(f, request_id, tile, rect_width(tile->rect) + 1, rect_height(tile->rect), LIE_NONE);
}

static void tile_nan(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    answer_once(f, request_id, tile, rect_width(tile->rect), rect_height(tile->rect), LIE_NAN);
}

static void tile_lone(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    answer_once(f, request_id, tile, rect_width(tile->rect), rect_height(tile->rect), LIE_LONE);
}

static void tile_stale(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct message_tile old = *tile;
    old.generation = tile->generation ? tile->generation - 1 : 1;
    result_send(f, request_id, &old, result_zero_samples(f, tile));
}

static void tile_foreign(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    struct message_tile other = *tile;
    other.index = tile->index ^ 0x10000u; /* no image of a test has so many tiles */
    result_send(f, request_id, &other, result_zero_samples(f, tile));
}

static void tile_garbage(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    (void)request_id;
    uint64_t x = 0x9e3779b97f4a7c15u + tile->index;
    uint64_t noise[512];
    for (size_t i = 0; i < sizeof noise / sizeof noise[0]; i++) {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        noise[i] = x;
    }
    link_send(f, noise, sizeof noise);
}

static void tile_half(struct fake *f, uint64_t request_id, const struct message_tile *tile)
{
    const struct bytes_writer *packed = result_zero_samples(f, tile);
    struct bytes_writer head;
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    bytes_writer_init(&head);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = (uint32_t)packed->size_bytes};
    message_encode_result(&head, &m);
    wire_frame_header(header, MESSAGE_RESULT, request_id, head.data, (uint32_t)head.size_bytes,
                      packed->data, (uint32_t)packed->size_bytes);
    link_send(f, header, sizeof header);
    link_send(f, head.data, head.size_bytes / 2);
    bytes_writer_fini(&head);
    link_lose(f);
}

static const struct script scripts[] = {
    {"echo", "answers at once with empty samples", tile_echo, false},
    {"hang", "takes tiles, beats without progress", tile_ignored, false},
    {"silent", "takes tiles, says nothing", tile_ignored, true},
    {"garbage", "random bytes in place of a result", tile_garbage, false},
    {"flip", "a right result with one bit flipped on the wire", tile_flip, false},
    {"header", "right results, each with another bit of its header flipped", tile_header, false},
    {"mutate", "right results with one to eight bytes of their body changed", tile_mutate, false},
    {"die", "takes a tile and is gone", tile_die, false},
    {"lie", "samples of another tile size", tile_lie, false},
    {"nan", "samples that are not finite", tile_nan, false},
    {"lone", "lists of lone sub-samples out of order, or with light that is not finite", tile_lone,
     false},
    {"stale", "a result of an older generation", tile_stale, false},
    {"foreign", "a result for a tile that nobody leased", tile_foreign, false},
    {"wrong-build", "another build id", tile_ignored, false},
    {"wrong-protocol", "another protocol version", tile_ignored, false},
    {"wrong-isa", "another instruction set", tile_ignored, false},
    {"slow-hello", "says HELLO after 8 s", tile_ignored, false},
    {"disconnect-mid-result", "half a result, then gone", tile_half, false},
};

const struct script *script_find(const char *name)
{
    for (size_t i = 0; i < sizeof scripts / sizeof scripts[0]; i++)
        if (strcmp(scripts[i].name, name) == 0) return &scripts[i];
    return NULL;
}

bool script_plays(const struct fake *f, const char *script)
{
    return strcmp(f->script->name, script) == 0;
}

void script_print_all(FILE *file)
{
    for (size_t i = 0; i < sizeof scripts / sizeof scripts[0]; i++)
        fprintf(file, "  %-22s %s\n", scripts[i].name, scripts[i].text);
}
