/* Sequences of colour and depth: what a frame is, and what is refused. */
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "tests/unit/import/scene_room.h"

#define WIDTH  40
#define HEIGHT 30

/* ---- files ---- */

static int grey; /* of colour images, of 255 */

static void write_color(const char *name, uint32_t width)
{
    static uint8_t rgb[3 * WIDTH * HEIGHT], file[65536];
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = width, .height = HEIGHT, .format = PNG_FORMAT_RGB};
    png_alloc_size_t size_bytes = sizeof file;
    memset(rgb, grey, sizeof rgb);
    assert_true(png_image_write_to_memory(&image, file, &size_bytes, 0, rgb, 0, NULL));
    room_write(name, file, size_bytes);
}

/* A wall at that many millimetres; 0: nothing was measured. */
static void write_depth(const char *name, unsigned mm)
{
    static uint8_t file[32 + 2 * WIDTH * HEIGHT];
    int at = sprintf((char *)file, "P5\n# a wall\n%d %d\n65535\n", WIDTH, HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        file[at++] = (uint8_t)(mm >> 8);
        file[at++] = (uint8_t)mm;
    }
    room_write(name, file, (size_t)at);
}

#define CAMERA "\"camera\": {\"fx\": 40, \"fy\": 40, \"cx\": 21.5, \"cy\": 14.5}"
#define FRAMES                                                                                     \
    "\"frames\": [{\"color\": \"1.png\", \"depth\": \"1.pgm\"}, "                                  \
    "{\"color\": \"2.png\", \"depth\": \"2.pgm\"}]"
#define POSES "\"poses\": {\"file\": \"poses.txt\", \"format\": \"tum\"}"
#define SCENE "\"to_scene\": [1,0,0,0, 0,-1,0,0, 0,0,-1,0, 0,0,0,1]"
#define WHOLE "{" CAMERA ", " FRAMES ", " POSES ", " SCENE "}"

static const char box[] = "v 0 0 -1\nv 0.1 0 -1\nv 0 0.1 -1\nf 1 2 3\n";
static const char tum[] = "# time x y z qx qy qz qw\n0 0 0 0 0 0 0 1\n0.1 0.5 0 0 0 0 0 1\n";

static int open_sequence(void **state)
{
    room_choice = (struct scene_choice){.catchers = "[]", .rgbd = "s.json"};
    if (room_open(state) != 0) return -1;
    grey = 128;
    write_color("1.png", WIDTH);
    write_color("2.png", WIDTH);
    write_depth("1.pgm", 2000);
    write_depth("2.pgm", 2000);
    room_write("poses.txt", tum, strlen(tum));
    room_write("s.json", WHOLE, strlen(WHOLE));
    return 0;
}

EACH_TEST(open_sequence, room_close);

TEST(a_frame_is_a_catcher_before_its_own_camera)
{
    struct scene s;
    room_choice.time_s = 1.0 / 24;
    assert_int_equal(room_import_text("box.obj", box, &s), 0);
    const struct scene_camera *c = &s.cameras[s.info->default_camera];
    assert_true(fabsf(c->eye[0] - 0.5f) < 1e-6f && fabsf(c->forward[2] + 1) < 1e-6f);
    assert_true(fabsf(c->half_width - 0.5f) < 1e-6f && fabsf(c->centre_x - 0.1f) < 1e-6f);
    assert_string_equal(scene_name(&s, s.info->plate), "2.png");
    assert_true(s.info->flags & SCENE_MOVES);
    assert_int_equal(s.count[SCENE_INSTANCES], 2);
    assert_int_equal(s.instances[1].flags, INSTANCE_CATCHER | INSTANCE_IDENTITY);
    assert_int_equal(s.meshes[1].triangle_count, 2 * WIDTH * HEIGHT);
    assert_true(fabsf(s.positions[3 * s.meshes[1].first_vertex + 2] + 2) < 1e-4f);
    scene_unmap(&s);
}

TEST(objects_stand_where_a_pixel_shows_a_surface)
{
    static const char *const pixels[] = {"[29, 14]", "[21.5, 14.5]"};
    for (int k = 0; k < 2; k++) {
        struct scene s;
        char text[512];
        snprintf(text, sizeof text,
                 "{" CAMERA ", " FRAMES ", " POSES
                 ", \"place\": {\"pixel\": %s, \"scale\": 3, \"turn_deg\": 90}}",
                 pixels[k]);
        room_write("s.json", text, strlen(text));
        assert_int_equal(room_import_text("box.obj", box, &s), 0);
        /* The wall, 2 m away, is the ground. */
        const struct scene_camera *c = &s.cameras[s.info->default_camera];
        assert_true(fabsf(c->eye[1] - 6) < 1e-3f && fabsf(c->forward[1] + 1) < 1e-3f);
        for (uint32_t v = 0; v < s.meshes[1].vertex_count; v++)
            assert_true(fabsf(s.positions[3 * (s.meshes[1].first_vertex + v) + 1]) < 1e-2f);
        if (k == 0) assert_true(c->eye[0] < -1 && fabsf(c->eye[2]) < 1e-3f);
        scene_unmap(&s);
    }
}

/* Both walls are one, of which the second frame sees what is to the right of the first one's. */
TEST(a_model_is_the_same_for_all_frames)
{
    struct scene s;
    float lowest[2] = {0}, highest[2] = {0};
    room_choice.is_fused = true;
    for (int frame = 0; frame < 2; frame++) {
        room_choice.time_s = frame / 24.0;
        assert_int_equal(room_import_text("box.obj", box, &s), 0);
        assert_int_equal(s.count[SCENE_INSTANCES], 2);
        assert_int_equal(s.instances[1].flags & INSTANCE_CATCHER, INSTANCE_CATCHER);
        assert_true(fabsf(s.cameras[s.info->default_camera].eye[0] - 0.5f * (float)frame) < 1e-6f);
        assert_string_equal(scene_name(&s, s.info->plate), frame ? "2.png" : "1.png");
        const struct scene_mesh *m = &s.meshes[1];
        for (uint32_t v = 0; v < m->vertex_count; v++) {
            const float *p = s.positions + 3 * (m->first_vertex + v);
            assert_true(fabsf(p[2] + 2) < 2e-3f);
            lowest[frame] = fminf(lowest[frame], p[0]);
            highest[frame] = fmaxf(highest[frame], p[0]);
        }
        scene_unmap(&s);
    }
    assert_true(lowest[0] == lowest[1] && highest[0] == highest[1]);
    assert_true(highest[0] - lowest[0] > 2.4f);
}

/* Imports the sequence. Returns the lamps that it has. */
static uint64_t estimate(struct scene *s)
{
    assert_int_equal(room_import_text("box.obj", box, s), 0);
    for (uint64_t i = 0; i < 3 * s->count[SCENE_SKY]; i++)
        assert_true(s->sky[i] >= 0 && s->sky[i] < 8);
    return s->count[SCENE_LIGHTS];
}

TEST(light_is_estimated_where_it_is_asked_for)
{
    struct scene s;
    assert_int_equal(estimate(&s), 0);
    assert_int_equal(s.count[SCENE_SKY], 0);
    scene_unmap(&s);
    room_choice.estimate = RGBD_ESTIMATE_UNLESS_LIT;
    for (int fused = 0; fused < 2; fused++) {
        room_choice.is_fused = fused;
        assert_int_equal(estimate(&s), 0);
        assert_int_equal(s.count[SCENE_SKY], SCENE_SKY_TEXELS);
        assert_true(room_warned("of what is around (lamps: 0)"));
        /* The wall is along -z: a quarter of the turn from the map's left edge. */
        const size_t wall = SCENE_SKY_WIDTH_PX * SCENE_SKY_HEIGHT_PX / 2 + SCENE_SKY_WIDTH_PX / 4;
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(s.sky[3 * wall + (size_t)c] - 0.2159f) < 1e-3f);
        scene_unmap(&s);
    }
}

TEST(a_file_with_lamps_is_lit_by_these_unless_an_estimate_is_asked_for)
{
    static const char lit[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"extensionsUsed\": [\"KHR_lights_punctual\"], "
        "\"extensions\": {\"KHR_lights_punctual\": {\"lights\": [{\"type\": \"point\"}]}}, "
        "\"scenes\": [{\"nodes\": [0, 1]}], \"nodes\": [{\"mesh\": 0}, {\"extensions\": "
        "{\"KHR_lights_punctual\": {\"light\": 0}}}], "
        "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}], "
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, "
        "\"type\": \"VEC3\", \"min\": [0, 0, 0], \"max\": [1, 1, 0]}], "
        "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}], "
        "\"buffers\": [{\"byteLength\": 36, \"uri\": \"data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";
    struct scene s;
    for (int always = 0; always < 2; always++) {
        room_choice.estimate = always ? RGBD_ESTIMATE_ALWAYS : RGBD_ESTIMATE_UNLESS_LIT;
        assert_int_equal(room_import_text("lit.gltf", lit, &s), 0);
        assert_int_equal(s.count[SCENE_LIGHTS], 1);
        assert_int_equal(s.count[SCENE_SKY], always ? SCENE_SKY_TEXELS : 0);
        scene_unmap(&s);
    }
}

TEST(of_black_frames_no_light_is_estimated)
{
    struct scene s;
    grey = 0;
    write_color("1.png", WIDTH);
    write_color("2.png", WIDTH);
    room_choice.estimate = RGBD_ESTIMATE_ALWAYS;
    assert_int_equal(estimate(&s), 0);
    assert_int_equal(s.count[SCENE_SKY], 0);
    assert_true(room_warned("they are too dark: no light is estimated"));
    scene_unmap(&s);
}

TEST(one_white_frame_is_a_lamp_of_finite_light)
{
    static const char one[] = "{" CAMERA ", " POSES ", " SCENE
                              ", \"frames\": [{\"color\": \"1.png\", \"depth\": \"1.pgm\"}]}";
    struct scene s;
    grey = 255;
    write_color("1.png", WIDTH);
    room_write("s.json", one, strlen(one));
    room_choice.estimate = RGBD_ESTIMATE_ALWAYS;
    assert_int_equal(estimate(&s), 1);
    assert_true(s.lights[0].color[0] > 0.5f && s.lights[0].color[0] < 2);
    assert_true(s.lights[0].direction[2] > 0.99f && s.lights[0].position[2] < -1.9f);
    scene_unmap(&s);
}

/* Changes a file of the sequence, and expects the place. */
static void refuses(const char *name, const char *text, int code, const char *place)
{
    room_write(name, text, strlen(text));
    room_refuses("box.obj", box, code, place);
}

#define UNIT "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"

static const char matrices[] = "{" CAMERA ", " FRAMES ", " SCENE
                               ", \"poses\": {\"file\": \"poses.txt\", \"format\": \"matrices\"}}";

TEST(refuses_lists_of_poses_with_a_place)
{
    static const char at[] = "/rgbd/poses/file";
    refuses("poses.txt", "0 0 0 0 0 0 0 1\n", ERR_TRUNCATED, at);
    refuses("poses.txt", "", ERR_TRUNCATED, at);
    refuses("poses.txt", "0 0 0 0 0 0 0 2\n0 0 0 0 0 0 0 1\n", ERR_RANGE, at);
    refuses("poses.txt", "0 0 0 0 0 0 0 nan\n0 0 0 0 0 0 0 1\n", ERR_SYNTAX, at);
    refuses("poses.txt", "0 0 0 0 0 0 1\n0 0 0\n", ERR_SYNTAX, at);
    refuses("poses.txt", "0 1e30 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", ERR_LIMIT, at);
    room_write("s.json", matrices, strlen(matrices));
    refuses("poses.txt", UNIT "1 0 0 0\n0 1 0 0\n", ERR_TRUNCATED, at);
    refuses("poses.txt", UNIT "1 0 0 0\n0 1 0 0\n0 0 2 0\n0 0 0 1\n", ERR_RANGE, at);
    refuses("poses.txt", UNIT "1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n", ERR_RANGE, at);
    refuses("poses.txt", UNIT "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 1 1\n", ERR_RANGE, at);
    struct scene s;
    room_write("poses.txt", UNIT UNIT, strlen(UNIT UNIT));
    assert_int_equal(room_import_text("box.obj", box, &s), 0);
    scene_unmap(&s);
}

/* Rounded numbers are a rotation nearly; the camera is one. */
TEST(cameras_of_rounded_poses_are_orthonormal)
{
    struct scene s;
    const char *poses = "0.997 -0.1 0 0\n0.105 0.996 0 0\n0 0 1.003 0\n0 0 0 1\n" UNIT;
    room_write("s.json", matrices, strlen(matrices));
    room_write("poses.txt", poses, strlen(poses));
    assert_int_equal(room_import_text("box.obj", box, &s), 0);
    const struct scene_camera *c = &s.cameras[s.info->default_camera];
    const float *axes[] = {c->right, c->up, c->forward};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const float sum =
                axes[i][0] * axes[k][0] + axes[i][1] * axes[k][1] + axes[i][2] * axes[k][2];
            assert_true(fabsf(sum - (i == k)) < 1e-6f);
        }
    assert_true(fabsf(c->right[0] - 0.9945f) < 2e-3f && fabsf(c->right[0]) < 0.9999f);
    scene_unmap(&s);
}

TEST(poses_have_a_limit)
{
    static const char line[] = "0 0 0 0 0 0 0 1\n";
    const size_t length = strlen(line), all = length * (LIMIT_POSES + 1);
    struct scene s;
    char *text = malloc(all + 1);
    assert_non_null(text);
    for (size_t i = 0; i <= LIMIT_POSES; i++) memcpy(text + length * i, line, length + 1);
    room_write("poses.txt", text, all);
    room_refuses("box.obj", box, ERR_LIMIT, "/rgbd/poses/file");
    room_write("poses.txt", text, all - length);
    assert_int_equal(room_import_text("box.obj", box, &s), 0);
    scene_unmap(&s);
    free(text);
}

TEST(names_of_images_are_never_cut)
{
    char name[301], path[400], old[100], text[1024];
    memset(name, 'a', 300);
    name[200] = name[300] = '\0'; /* a folder */
    snprintf(path, sizeof path, "%s/%s", room, name);
    assert_int_equal(mkdir(path, 0700), 0);
    name[200] = '/';
    snprintf(path, sizeof path, "%s/%s", room, name);
    snprintf(old, sizeof old, "%s/1.png", room);
    assert_int_equal(rename(old, path), 0);
    snprintf(text, sizeof text,
             "{" CAMERA ", " POSES ", " SCENE
             ", \"frames\": [{\"color\": \"%s\", \"depth\": \"1.pgm\"}]}",
             name);
    refuses("s.json", text, ERR_LIMIT, "/rgbd/frames/0/color");
}

TEST(refuses_images_with_a_place)
{
    write_depth("1.pgm", 0);
    room_refuses("box.obj", box, ERR_MISSING, "/rgbd/frames/0/depth");
    write_depth("1.pgm", 2000);
    write_color("1.png", WIDTH - 1);
    room_refuses("box.obj", box, ERR_MISMATCH, "/rgbd/frames/0/color");
    write_color("1.png", WIDTH);
    refuses("1.pgm", "P5 40 30 65535\nshort", ERR_TRUNCATED, "/rgbd/frames/0/depth");
    refuses("1.pgm", "P5 40 30 255\n", ERR_UNSUPPORTED, "/rgbd/frames/0/depth");
    refuses("1.pgm", "P5 16000 16000 65535\n", ERR_LIMIT, "/rgbd/frames/0/depth");
    refuses("1.pgm", "P5 99999999999 2 65535\n", ERR_CORRUPT, "/rgbd/frames/0/depth");
    refuses("1.pgm", "P5 1 1 65535\r\n12", ERR_CORRUPT, "/rgbd/frames/0/depth");
    refuses("1.pgm", "P5 1 1 65535#\n12", ERR_CORRUPT, "/rgbd/frames/0/depth");
    write_depth("1.pgm", 2000);
    refuses("2.pgm", "P5 1 1 65535\n12", ERR_MISMATCH, "/rgbd/frames/1/depth");
    write_depth("2.pgm", 2000);
    write_color("1.pgm", WIDTH); /* a PNG of colours */
    room_refuses("box.obj", box, ERR_CORRUPT, "/rgbd/frames/0/depth");
    write_depth("1.pgm", 2000);
    write_depth("2.pgm", 0);
    room_refuses("box.obj", box, ERR_MISSING, "/rgbd/frames/1/depth");
    room_choice.estimate = RGBD_ESTIMATE_ALWAYS;
    room_refuses("box.obj", box, ERR_MISSING, "/rgbd/frames/1/depth");
}

TEST(refuses_what_makes_no_model)
{
    room_choice.is_fused = true;
    write_depth("2.pgm", 0);
    room_refuses("box.obj", box, ERR_MISSING, "/rgbd/frames/1/depth");
    refuses("2.pgm", "P5 40 29 65535\n", ERR_TRUNCATED, "/rgbd/frames/1/depth");
    write_depth("2.pgm", 2000);
    refuses("poses.txt", "0 0 0 0 0 0 0 1\n0 1e14 0 0 0 0 0 1\n", ERR_LIMIT, "/rgbd/poses/file");
    room_write("poses.txt", tum, strlen(tum));
    room_choice.time_s = 1;
    room_refuses("box.obj", box, ERR_NOT_FOUND, "/rgbd/frames");
}

TEST(refuses_documents_with_a_place)
{
    refuses("s.json", "{", ERR_SYNTAX, "/rgbd");
    refuses("s.json", "{" CAMERA ", " FRAMES ", " POSES "}", ERR_MISSING, "/rgbd/place");
    refuses("s.json", "{" CAMERA ", \"frames\": [], " POSES ", " SCENE "}", ERR_RANGE,
            "/rgbd/frames");
    refuses("s.json",
            "{" CAMERA ", " FRAMES ", " POSES ", \"place\": {\"frame\": 3, \"pixel\": [1, 1]}}",
            ERR_RANGE, "/rgbd/place/frame");
    refuses("s.json",
            "{\"camera\": {\"fx\": 0, \"fy\": 40, \"cx\": 0, \"cy\": 0}, " FRAMES ", " POSES
            ", " SCENE "}",
            ERR_RANGE, "/rgbd/camera/fx");
    refuses("s.json",
            "{" CAMERA ", \"frames\": [{\"color\": \"../1.png\", \"depth\": \"1.pgm\"}], " POSES
            ", " SCENE "}",
            ERR_RANGE, "/rgbd/frames/0/color");
#define TIMED                                                                                      \
    "{" CAMERA ", " SCENE ", \"frames\": [{\"color\": \"1.png\", \"depth\": \"1.pgm\", "           \
    "\"time_s\": 0}], \"poses\": {\"file\": \"poses.txt\", \"format\": "
    refuses("s.json", TIMED "\"matrices\"}}", ERR_UNSUPPORTED, "/rgbd/poses/format");
    room_write("poses.txt", "0 0 0 0 0 0 1\n", 14);
    refuses("s.json", TIMED "\"tum\"}}", ERR_MISSING, "/rgbd/poses/file");
    room_write("poses.txt", tum, strlen(tum));
    room_write("s.json", WHOLE, strlen(WHOLE));
    room_choice.time_s = 1;
    room_refuses("box.obj", box, ERR_NOT_FOUND, "/rgbd/frames");
}
