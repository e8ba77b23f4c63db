/* Scene blobs that stand on another, as frames of a scene that moves do. */
#include <stdalign.h>
#include <unistd.h>

#include "tests/unit/proto/scene/scene_case.h"
#include "tests/unit/unit.h"

static alignas(64) uint8_t blob[SCENE_CASE_BYTES];
static struct scene_case c;
static struct scene scene;

/* The case as a base, and as a frame that stands on it. */
static alignas(64) uint8_t base_blob[SCENE_CASE_BYTES];
static struct scene base;

static void make_base(void)
{
    struct fault fault;
    scene_case_init(&c);
    c.info.flags = SCENE_MOVES | SCENE_IS_BASE;
    const size_t size_bytes = scene_case_lay_out(&c, base_blob);
    assert_int_equal(scene_open(base_blob, size_bytes, &base, &fault), 0);
    c.info.flags = SCENE_MOVES;
    c.base_count = 1;
    c.meshes[0].flags |= MESH_IN_BASE;
    c.meshes[1].flags |= MESH_IN_BASE;
    c.images[0].flags |= IMAGE_IN_BASE;
}

static int open_frame(struct fault *fault)
{
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    return scene_open_on(blob, size_bytes, &base, &scene, fault);
}

TEST(frames_stand_on_a_base)
{
    struct fault fault;
    make_base();
    assert_int_equal(open_frame(&fault), 0);
    assert_ptr_equal(scene_mesh_home(&scene, &scene.meshes[1]), &base);
    assert_ptr_equal(scene_image_home(&scene, &scene.images[0]), &base);
    assert_int_equal(scene_open(blob, scene.blob_bytes, &scene, &fault), ERR_MISSING);
    assert_string_equal(fault.pointer, "base");
    scene_case_init(&c); /* one without a base takes no notice of one */
    assert_int_equal(open_frame(&fault), 0);
    assert_null(scene.base);
}

#define FRAME(change, code, place)                                                                 \
    do {                                                                                           \
        struct fault fault;                                                                        \
        make_base();                                                                               \
        change;                                                                                    \
        assert_int_equal(open_frame(&fault), code);                                                \
        assert_string_equal(fault.pointer, place);                                                 \
    } while (0)

TEST(frames_fit_their_base)
{
    FRAME(c.meshes[0].first_vertex = 1, ERR_MISMATCH, "meshes[0].first_vertex");
    FRAME(c.meshes[1].triangle_count = 2, ERR_MISMATCH, "meshes[1].first_vertex");
    FRAME(c.meshes[0].flags ^= MESH_HAS_NORMALS, ERR_MISMATCH, "meshes[0].first_vertex");
    FRAME(c.meshes[0].flags ^= MESH_IN_BASE, ERR_MISMATCH, "base");
    FRAME(c.meshes[0].material = 9, ERR_RANGE, "meshes[0].material");
    FRAME(c.instances[1].to_world[3] += 1, ERR_MISMATCH, "base");
    FRAME(base.count[SCENE_INSTANCES] = 4, ERR_MISMATCH, "base");
    FRAME(base.count[SCENE_MESHES] = 1, ERR_MISMATCH, "meshes[1].flags");
    FRAME(base.base = &base, ERR_MISMATCH, "base");
    FRAME(c.base_count = 0, ERR_MISMATCH, "meshes[0].flags");
    FRAME(c.images[0].first_byte = 1, ERR_RANGE, "images[0].first_byte");
    scene_case_init(&c);
    struct fault fault;
    c.images[0].flags |= IMAGE_IN_BASE;
    assert_int_equal(open_frame(&fault), ERR_MISMATCH);
    assert_string_equal(fault.pointer, "images[0].flags");
}

TEST(bases_are_found_in_files)
{
    char path[] = "/tmp/shearwater-test-scene-XXXXXX";
    struct digest found;
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    make_base();
    memset(&c.base, 7, sizeof c.base);
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    assert_int_equal(write(fd, blob, size_bytes), size_bytes);
    assert_int_equal(scene_find_base(path, &found), 0);
    assert_memory_equal(&found, &c.base, sizeof found);
    assert_int_equal(ftruncate(fd, 64), 0);
    assert_int_equal(scene_find_base(path, &found), 0);
    assert_true(digest_is_zero(&found));
    close(fd);
    unlink(path);
    assert_int_equal(scene_find_base(path, &found), ERR_IO);
}
