/* Textures: decoding, sRGB flags, samplers and transforms; faults in images. */
#include <math.h>
#include <png.h>
#include <string.h>
#include <turbojpeg.h>

#include "server/import/image/image_decoder.h"
#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

#define WIDTH  3
#define HEIGHT 2
static uint8_t png_bytes[4096], jpeg_bytes[8192];
static size_t png_size, jpeg_size;

/* WIDTH x HEIGHT pixels of a PNG kind, each channel counting up. */
static size_t make_png(uint32_t format, uint8_t *out)
{
    uint8_t pixels[WIDTH * HEIGHT * 8];
    for (size_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)(i * 9);
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = format};
    png_alloc_size_t size_bytes = 4096;
    assert_true(png_image_write_to_memory(&image, out, &size_bytes, 0, pixels, 0, NULL));
    return size_bytes;
}

static int set_up(void **state)
{
    if (room_open(state) != 0) return -1;
    png_size = make_png(PNG_FORMAT_RGBA, png_bytes);
    uint8_t pixels[16 * 16 * 3];
    memset(pixels, 128, sizeof pixels);
    tjhandle tj = tjInitCompress();
    unsigned char *jpeg = NULL;
    unsigned long size_bytes = 0;
    tjCompress2(tj, pixels, 16, 0, 16, TJPF_RGB, &jpeg, &size_bytes, TJSAMP_444, 90, 0);
    jpeg_size = size_bytes;
    memcpy(jpeg_bytes, jpeg, jpeg_size);
    tjFree(jpeg);
    tjDestroy(tj);
    room_write("color.png", png_bytes, png_size);
    room_write("data.jpg", jpeg_bytes, jpeg_size);
    return 0;
}

ALL_TESTS(set_up, room_close);

TEST(decodes_all_kinds_of_png)
{
    static const uint32_t formats[] = {PNG_FORMAT_GRAY, PNG_FORMAT_GA,       PNG_FORMAT_RGB,
                                       PNG_FORMAT_RGBA, PNG_FORMAT_LINEAR_Y, PNG_FORMAT_LINEAR_RGB};
    uint8_t bytes[4096], rgba[4 * WIDTH * HEIGHT];
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
        struct image_header header;
        size_t size_bytes = make_png(formats[i], bytes);
        assert_int_equal(image_measure(bytes, size_bytes, "p", &header, NULL), 0);
        assert_int_equal(header.width_px, WIDTH);
        assert_int_equal(header.height_px, HEIGHT);
        assert_int_equal(image_decode(bytes, size_bytes, &header, "p", rgba, &room_warnings, NULL),
                         0);
        if (formats[i] == PNG_FORMAT_RGB) assert_int_equal(rgba[3], 255);
        if (formats[i] == PNG_FORMAT_RGBA) assert_int_equal(rgba[7], 63);
        if (formats[i] == PNG_FORMAT_GRAY) assert_int_equal(rgba[4], rgba[5]);
    }
}

TEST(refuses_every_truncation_of_a_png)
{
    uint8_t rgba[4 * WIDTH * HEIGHT];
    for (size_t n = 0; n + 12 + 4 < png_size; n++) { /* the end chunk and a checksum may lack */
        struct image_header header;
        int rc = image_measure(png_bytes, n, "p", &header, NULL);
        if (rc == 0) rc = image_decode(png_bytes, n, &header, "p", rgba, &room_warnings, NULL);
        assert_int_not_equal(rc, 0);
    }
}

TEST(survives_every_truncation_of_a_jpeg)
{
    uint8_t rgba[4 * 16 * 16];
    for (size_t n = 0; n < jpeg_size; n++) {
        struct image_header header;
        if (image_measure(jpeg_bytes, n, "j", &header, NULL) != 0) continue;
        assert_int_equal(header.width_px, 16);
        image_decode(jpeg_bytes, n, &header, "j", rgba, &room_warnings, NULL);
    }
}

TEST(refuses_other_formats_and_sizes)
{
    struct image_header header;
    struct fault fault;
    uint8_t large[4096];
    assert_int_equal(image_measure((const uint8_t *)"", 0, "p", &header, &fault), ERR_TRUNCATED);
    assert_int_equal(image_measure((const uint8_t *)"RIFF....WEBP", 12, "p", &header, &fault),
                     ERR_CORRUPT);
    assert_int_equal(image_measure((const uint8_t *)"DDS .........", 12, "p", &header, &fault),
                     ERR_UNSUPPORTED);
    assert_non_null(strstr(fault.detail, "DDS"));
    memcpy(large, png_bytes, png_size);
    large[16] = 1; /* 16,777,219 pixels wide, said before anything is decoded */
    assert_int_equal(image_measure(large, png_size, "p", &header, &fault), ERR_LIMIT);
    large[16] = 0;
    large[19] = 0;
    assert_int_equal(image_measure(large, png_size, "p", &header, &fault), ERR_CORRUPT);
}

#define TEXTURED(images, material)                                                                 \
    "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 36, \"uri\": "             \
    "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]," \
    "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}], \"accessors\": [{\"bufferView\": 0,"  \
    "\"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"}, {\"bufferView\": 0,"              \
    "\"componentType\": 5126, \"count\": 3, \"type\": \"VEC2\"}],"                                 \
    "\"images\": [" images                                                                         \
    "], \"samplers\": [{\"wrapS\": 33071, \"wrapT\": 33648, \"magFilter\": "                       \
    "9728}], \"textures\": [{\"source\": 0, \"sampler\": 0}, {\"source\": 1}],"                    \
    "\"materials\": [" material "], \"meshes\": [{\"primitives\": [{\"material\": 0,"              \
    "\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 1}}]}], \"scenes\": [{\"nodes\": [0]}],"    \
    "\"nodes\": [{\"mesh\": 0}]}"
#define IMAGES "{\"uri\": \"color.png\"}, {\"uri\": \"data.jpg\", \"name\": \"grey\"}"

TEST(records_textures)
{
    struct scene s;
    const char *text = TEXTURED(
        IMAGES, "{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0},"
                "\"metallicRoughnessTexture\": {\"index\": 0}}, \"normalTexture\": {\"index\": 1,"
                "\"scale\": 0.5, \"extensions\": {\"KHR_texture_transform\": {\"offset\": [1, 2],"
                "\"scale\": [2, 3], \"rotation\": 1.5707963267948966}}}}");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    const struct scene_material *m = &s.materials[0];
    const struct scene_texture *color = &s.textures[m->base_color_texture.texture];
    const struct scene_texture *data = &s.textures[m->metallic_roughness_texture.texture];
    assert_int_equal(color->wrap_u, WRAP_CLAMP);
    assert_int_equal(color->wrap_v, WRAP_MIRROR);
    assert_int_equal(color->filter, FILTER_NEAREST);
    assert_int_equal(s.images[color->image].flags, IMAGE_IS_SRGB);
    assert_int_equal(s.images[data->image].flags, 0);
    assert_int_equal(s.images[color->image].first_byte, s.images[data->image].first_byte);
    assert_int_equal(s.count[SCENE_IMAGES], 3);
    assert_int_equal(s.count[SCENE_PIXELS], 4 * (WIDTH * HEIGHT + 16 * 16));
    const uint8_t *pixel = s.pixels + s.images[color->image].first_byte + 4;
    for (int c = 0; c < 4; c++) assert_int_equal(pixel[c], (4 + c) * 9);
    const float expected[6] = {0, 3, 1, -2, 0, 2};
    for (int i = 0; i < 6; i++)
        assert_true(fabsf(m->normal_texture.transform[i] - expected[i]) < 1e-6f);
    assert_true(m->normal_scale == 0.5f);
    /* A normal map brings tangents, and flat normals where the file has none. */
    assert_int_equal(s.meshes[0].flags, MESH_HAS_NORMALS | MESH_HAS_TANGENTS);
    scene_unmap(&s);
}

TEST(unused_images_are_not_read)
{
    struct scene s;
    assert_int_equal(room_import_text("a.gltf", TEXTURED("{\"uri\": \"gone.png\"}, {}", "{}"), &s),
                     0);
    assert_int_equal(s.count[SCENE_IMAGES], 0);
    scene_unmap(&s);
}

TEST(names_the_image_at_fault)
{
#define FAULTY(images) TEXTURED(images, "{\"emissiveTexture\": {\"index\": 1}}")
    room_refuses("a.gltf", FAULTY("{}, {\"uri\": \"gone.png\"}"), ERR_NOT_FOUND, "images[1].uri");
    room_refuses("a.gltf", FAULTY("{}, {\"uri\": \"a.gltf\"}"), ERR_UNSUPPORTED, "images[1].uri");
    room_refuses("a.gltf", FAULTY("{}, {}"), ERR_MISSING, "images[1]");
    room_refuses("a.gltf", FAULTY("{}, {\"bufferView\": 3}"), ERR_RANGE, "images[1].bufferView");
    room_refuses("a.gltf", FAULTY("{}, {\"bufferView\": 0}"), ERR_UNSUPPORTED, "images[1]");
    room_refuses("a.gltf", FAULTY("{}, {\"uri\": \"data:image/png;base64,iVB?\"}"), ERR_SYNTAX,
                 "images[1].uri");
    room_refuses("a.gltf", FAULTY("{}, {\"uri\": \"data:image/png,iVB\"}"), ERR_UNSUPPORTED,
                 "images[1].uri");
    room_refuses("a.gltf", FAULTY("{}"), ERR_RANGE, "textures[1].source");
}
