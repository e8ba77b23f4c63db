/* WebP images, alone and behind EXT_texture_webp. */
#include <stdio.h>
#include <string.h>
#include <webp/encode.h>

#include "server/import/image/image_decoder.h"
#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

enum { WIDTH = 5, HEIGHT = 3 };
static uint8_t pixels[4 * WIDTH * HEIGHT];
static uint8_t *webp; /* lossless */
static size_t webp_bytes;

static int set_up(void **state)
{
    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = i % 4 == 3 ? (uint8_t)(200 + i / 4) : (uint8_t)(i * 7);
    webp_bytes = WebPEncodeLosslessRGBA(pixels, WIDTH, HEIGHT, 4 * WIDTH, &webp);
    return webp_bytes > 0 ? room_open(state) : -1;
}

static int tear_down(void **state)
{
    WebPFree(webp);
    return room_close(state);
}

ALL_TESTS(set_up, tear_down);

TEST(lossless_images_keep_every_byte)
{
    struct image_header header;
    struct fault fault = {0};
    uint8_t rgba[sizeof pixels];
    assert_int_equal(image_measure(webp, webp_bytes, "p", &header, &fault), 0);
    assert_true(header.width_px == WIDTH && header.height_px == HEIGHT);
    assert_int_equal(image_decode(webp, webp_bytes, &header, "p", rgba, &room_warnings, &fault), 0);
    assert_memory_equal(rgba, pixels, sizeof pixels);
}

TEST(cut_images_are_refused)
{
    for (size_t n = 12; n < webp_bytes; n++) {
        struct image_header header;
        struct fault fault = {0};
        uint8_t rgba[sizeof pixels];
        int rc = image_measure(webp, n, "p", &header, &fault);
        if (rc == 0) rc = image_decode(webp, n, &header, "p", rgba, &room_warnings, &fault);
        assert_int_equal(rc, ERR_CORRUPT);
    }
}

/* The size of a lossless image stands behind the chunk's head and a byte: 14 bits a side, less 1.
 */
TEST(bombs_are_refused_by_their_header)
{
    struct image_header header;
    struct fault fault = {0};
    uint8_t bomb[64];
    memcpy(bomb, webp, webp_bytes < sizeof bomb ? webp_bytes : sizeof bomb);
    assert_memory_equal(bomb + 12, "VP8L", 4);
    memset(bomb + 21, 0xff, 3);
    bomb[24] |= 0x0f;
    assert_int_equal(image_measure(bomb, sizeof bomb, "p", &header, &fault), ERR_LIMIT);
}

#define TEXTURED(texture)                                                                          \
    "{\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": [\"EXT_texture_webp\"],"          \
    "\"buffers\": [{\"uri\": "                                                                     \
    "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAA"                     \
    "AAAAAAAgD8AAAAA\", \"byteLength\": 36}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": "  \
    "36}],"                                                                                        \
    "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": "        \
    "\"VEC3\"}],"                                                                                  \
    "\"images\": [{\"uri\": \"gone.png\"}, {\"uri\": \"a.webp\"}], \"textures\": [" texture "],"   \
    "\"materials\": [{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0}}}],"         \
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"material\": 0}]}],"      \
    "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}]}"

TEST(the_extension_s_image_stands_for_the_texture_s_own)
{
    struct scene s;
    room_write("a.webp", webp, webp_bytes);
    assert_int_equal(
        room_import_text("a.gltf",
                         TEXTURED("{\"source\": 0, \"extensions\": {\"EXT_texture_webp\": "
                                  "{\"source\": 1}}}"),
                         &s),
        0);
    assert_int_equal(s.count[SCENE_IMAGES], 1);
    assert_string_equal(scene_name(&s, s.images[0].name), "a.webp");
    assert_memory_equal(s.pixels + s.images[0].first_byte, pixels, sizeof pixels);
    scene_unmap(&s);
    room_refuses("a.gltf", TEXTURED("{\"extensions\": {\"EXT_texture_webp\": {\"source\": 2}}}"),
                 ERR_RANGE, "textures[0].extensions.EXT_texture_webp.source");
}
