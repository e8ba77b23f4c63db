/* Scene blobs: a good one opens, and each field, index and number is broken once. */
#include <math.h>
#include <stdalign.h>
#include <unistd.h>

#include "tests/unit/proto/golden.h"
#include "tests/unit/proto/scene/scene_case.h"
#include "tests/unit/unit.h"

static alignas(64) uint8_t blob[SCENE_CASE_BYTES];
static struct scene_case c;
static struct scene scene;

/* Memory that ends with the blob, so that a sanitizer sees a read beyond. */
static int open_exact(size_t size_bytes, struct fault *fault)
{
    void *exact;
    assert_int_equal(posix_memalign(&exact, 64, size_bytes + (size_bytes == 0)), 0);
    memcpy(exact, blob, size_bytes);
    const int error = scene_open(exact, size_bytes, &scene, fault);
    free(exact);
    return error;
}

TEST(good_blobs_open)
{
    struct fault fault = {0};
    scene_case_init(&c);
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    if (scene_open(blob, size_bytes, &scene, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_int_equal(scene.count[SCENE_MESHES], 2);
    assert_int_equal(scene.info->default_camera, 1);
    assert_memory_equal(scene.positions, c.positions, sizeof c.positions);
    assert_memory_equal(scene.triangles, c.triangles, sizeof c.triangles);
    assert_memory_equal(scene.materials, c.materials, sizeof c.materials);
    assert_memory_equal(scene.pixels, c.pixels, sizeof c.pixels);
    assert_memory_equal(scene.cameras, c.cameras, sizeof c.cameras);
    assert_string_equal(scene_name(&scene, scene.meshes[0].name), "quad");
    assert_string_equal(scene_name(&scene, scene.meshes[1].name), "light");
    assert_string_equal(scene_name(&scene, 0), "");
    golden_check("tests/golden/wire/scene.bin", blob, size_bytes);
}

TEST(files_are_mapped)
{
    char path[] = "/tmp/shearwater-test-scene-XXXXXX";
    struct fault fault = {0};
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(scene_map(path, &scene, &fault), ERR_TRUNCATED);
    scene_case_init(&c);
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    assert_int_equal(write(fd, blob, size_bytes), size_bytes);
    assert_int_equal(scene_map(path, &scene, &fault), 0);
    assert_int_equal(scene.blob_bytes, size_bytes);
    scene_unmap(&scene);
    assert_null(scene.blob);
    scene_unmap(&scene);
    assert_int_equal(ftruncate(fd, 100), 0);
    assert_int_equal(scene_map(path, &scene, &fault), ERR_TRUNCATED);
    assert_null(scene.blob);
    close(fd);
    unlink(path);
    assert_int_equal(scene_map(path, &scene, &fault), ERR_IO);
    assert_int_equal(scene_map("/tmp", &scene, &fault), ERR_IO);
}

TEST(cut_blobs_fail)
{
    struct fault fault;
    scene_case_init(&c);
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    for (size_t cut = 0; cut < size_bytes; cut++) {
        assert_int_equal(open_exact(cut, &fault), ERR_TRUNCATED);
        /* And a header that agrees with the cut. */
        ((struct scene_header *)(void *)blob)->total_bytes = cut;
        assert_true(open_exact(cut, &fault) != 0);
        ((struct scene_header *)(void *)blob)->total_bytes = size_bytes;
    }
    assert_int_equal(open_exact(size_bytes + 1, &fault), ERR_TRAILING);
    assert_int_equal(scene_open(blob + 32, size_bytes, &scene, &fault), ERR_RANGE);
}

static void expect(size_t size_bytes, int expected, const char *place, const char *change)
{
    struct fault fault = {0};
    const int error = open_exact(size_bytes, &fault);
    if (error != expected || strcmp(fault.pointer, place) != 0)
        fail_msg("%s gives %s at \"%s\": %s", change, error_name(error), fault.pointer,
                 fault.detail);
}

/* Changes the case before it is laid out. */
#define EXPECT(change, expected, place)                                                            \
    do {                                                                                           \
        scene_case_init(&c);                                                                       \
        change;                                                                                    \
        expect(scene_case_lay_out(&c, blob), expected, place, #change);                            \
    } while (0)

/* Changes the header or the table afterwards. */
#define EXPECT_HEAD(change, expected, place)                                                       \
    do {                                                                                           \
        scene_case_init(&c);                                                                       \
        const size_t size_bytes = scene_case_lay_out(&c, blob);                                    \
        struct scene_header *header = (void *)blob;                                                \
        struct scene_section_entry *table = (void *)(header + 1);                                  \
        (void)table;                                                                               \
        change;                                                                                    \
        expect(size_bytes, expected, place, #change);                                              \
    } while (0)

TEST(headers_are_checked)
{
    EXPECT_HEAD(header->magic[0] = 'X', ERR_MAGIC, "header.magic");
    EXPECT_HEAD(header->magic[7] = 'X', ERR_MAGIC, "header.magic");
    EXPECT_HEAD(header->version = 1, ERR_VERSION, "header.version");
    EXPECT_HEAD(header->section_count = 15, ERR_RANGE, "header.section_count");
    EXPECT_HEAD(header->total_bytes = UINT64_MAX, ERR_TRUNCATED, "header.total_bytes");
    EXPECT_HEAD(header->total_bytes -= 1, ERR_TRAILING, "header.total_bytes");
    EXPECT_HEAD(header->reserved = 1, ERR_RANGE, "header.reserved");
}

TEST(tables_are_checked)
{
    EXPECT_HEAD(table[1].record_bytes = 16, ERR_MISMATCH, "sections[positions].record_bytes");
    EXPECT_HEAD(table[1].record_bytes = 0, ERR_MISMATCH, "sections[positions].record_bytes");
    EXPECT_HEAD(table[2].reserved = 1, ERR_RANGE, "sections[normals].reserved");
    EXPECT_HEAD(table[1].offset += 4, ERR_RANGE, "sections[positions].offset");
    EXPECT_HEAD(table[1].offset = UINT64_MAX - 63, ERR_TRUNCATED, "sections[positions].offset");
    EXPECT_HEAD(table[1].offset = 1 << 20, ERR_TRUNCATED, "sections[positions].offset");
    EXPECT_HEAD(table[1].count = UINT64_MAX, ERR_LIMIT, "sections[positions].count");
    EXPECT_HEAD(table[1].count = UINT64_MAX / 12 + 2, ERR_LIMIT, "sections[positions].count");
    EXPECT_HEAD(table[1].count = LIMIT_VERTICES, ERR_TRUNCATED, "sections[positions].offset");
    EXPECT_HEAD(table[11].count = LIMIT_BLOB_BYTES + 1, ERR_LIMIT, "sections[pixels].count");
    EXPECT_HEAD(table[16].count += 1, ERR_TRUNCATED, "sections[colors].offset");
    EXPECT_HEAD(table[5].offset = 0, ERR_CORRUPT, "sections");
    EXPECT_HEAD(table[5].offset = 384, ERR_CORRUPT, "sections");
    EXPECT_HEAD(table[5].offset = table[6].offset, ERR_CORRUPT, "sections");
    EXPECT_HEAD(table[1].count = 20, ERR_CORRUPT, "sections");
    EXPECT_HEAD(table[0].count = 2, ERR_LIMIT, "sections[info].count");
    EXPECT_HEAD(table[0].count = 0, ERR_MISSING, "info");
    EXPECT_HEAD(table[13].count = 0, ERR_MISSING, "cameras");
    EXPECT_HEAD(table[14].count = 0, ERR_CORRUPT, "names");
    EXPECT_HEAD((table[15].count = 0, table[15].offset = 0), ERR_OK, "");
    EXPECT_HEAD(table[12].count = 0, ERR_OK, "");
    EXPECT_HEAD(table[6].count = 0, ERR_RANGE, "instances[0].mesh");
    EXPECT_HEAD(table[4].count = 3, ERR_RANGE, "meshes[0].first_uv");
}

TEST(info_and_strings_are_checked)
{
    EXPECT(c.info.bounds_min[1] = NAN, ERR_NOT_FINITE, "info[0].bounds_min");
    EXPECT(c.info.bounds_max[0] = INFINITY, ERR_NOT_FINITE, "info[0].bounds_max");
    EXPECT(c.info.bounds_max[2] = -2, ERR_RANGE, "info[0].bounds_max");
    EXPECT(c.info.bounds_max[2] = 2e15f, ERR_RANGE, "info[0].bounds_max");
    EXPECT(c.info.default_camera = 2, ERR_RANGE, "info[0].default_camera");
    EXPECT(c.info.placed_triangles = 5, ERR_MISMATCH, "info[0].placed_triangles");
    EXPECT(c.info.flags = 4, ERR_RANGE, "info[0].flags");
    EXPECT(c.info.origin[1] = NAN, ERR_NOT_FINITE, "info[0].origin");
    EXPECT(c.info.origin[2] = -1e16, ERR_RANGE, "info[0].origin");
    EXPECT(c.names[0] = 'x', ERR_CORRUPT, "names");
    EXPECT(c.names[15] = 'x', ERR_CORRUPT, "names");
    EXPECT(c.warnings[23] = 'x', ERR_CORRUPT, "warnings");
}

TEST(vertices_are_checked)
{
    EXPECT(c.positions[6][2] = NAN, ERR_NOT_FINITE, "positions[6]");
    EXPECT(c.positions[0][0] = -INFINITY, ERR_NOT_FINITE, "positions[0]");
    EXPECT(c.positions[3][1] = 2e15f, ERR_RANGE, "positions[3]");
    EXPECT(c.normals[2][1] = 0.5f, ERR_RANGE, "normals[2]");
    EXPECT(c.normals[2][1] = 0, ERR_RANGE, "normals[2]");
    EXPECT(c.normals[2][1] = NAN, ERR_NOT_FINITE, "normals[2]");
    EXPECT(c.tangents[1][0] = 2, ERR_RANGE, "tangents[1]");
    EXPECT(c.tangents[1][3] = 0, ERR_RANGE, "tangents[1].w");
    EXPECT(c.tangents[1][3] = INFINITY, ERR_NOT_FINITE, "tangents[1]");
    EXPECT(c.uvs[3][0] = NAN, ERR_NOT_FINITE, "uvs[3]");
    EXPECT(c.triangles[1][2] = 4, ERR_RANGE, "triangles[1]");
    EXPECT(c.triangles[2][0] = 3, ERR_RANGE, "triangles[2]");
    EXPECT(c.triangles[0][0] = UINT32_MAX, ERR_RANGE, "triangles[0]");
}

TEST(meshes_are_checked)
{
    EXPECT(c.meshes[0].first_vertex = 4, ERR_RANGE, "meshes[0].first_vertex");
    EXPECT(c.meshes[0].first_vertex = UINT32_MAX, ERR_RANGE, "meshes[0].first_vertex");
    EXPECT(c.meshes[0].vertex_count = UINT32_MAX, ERR_RANGE, "meshes[0].first_vertex");
    EXPECT(c.meshes[1].first_triangle = 3, ERR_RANGE, "meshes[1].first_triangle");
    EXPECT(c.meshes[1].first_triangle = UINT32_MAX, ERR_RANGE, "meshes[1].first_triangle");
    EXPECT(c.meshes[1].triangle_count = 2, ERR_RANGE, "meshes[1].first_triangle");
    EXPECT((c.meshes[1].first_vertex = 0, c.meshes[1].first_triangle = 0), ERR_OK, "");
    EXPECT(c.meshes[0].first_normal = 1, ERR_RANGE, "meshes[0].first_normal");
    EXPECT(c.meshes[1].first_normal = 1, ERR_RANGE, "meshes[1].first_normal");
    EXPECT(c.meshes[0].first_tangent = 1, ERR_RANGE, "meshes[0].first_tangent");
    EXPECT(c.meshes[0].first_uv[0] = 1, ERR_RANGE, "meshes[0].first_uv");
    EXPECT(c.meshes[0].first_uv[1] = UINT32_MAX - 1, ERR_RANGE, "meshes[0].first_uv");
    EXPECT(c.meshes[1].material = 2, ERR_RANGE, "meshes[1].material");
    EXPECT(c.meshes[1].material = SCENE_NONE, ERR_RANGE, "meshes[1].material");
    EXPECT(c.meshes[1].flags = 32, ERR_RANGE, "meshes[1].flags");
    EXPECT(c.meshes[1].name = 16, ERR_RANGE, "meshes[1].name");
    EXPECT(c.meshes[1].first_color = 1, ERR_RANGE, "meshes[1].first_color");
    EXPECT(c.meshes[0].first_color = 1, ERR_RANGE, "meshes[0].first_color");
    EXPECT(c.colors[2][1] = 1.5f, ERR_RANGE, "colors[2]");
    EXPECT(c.colors[1][3] = -0.5f, ERR_RANGE, "colors[1]");
    EXPECT(c.colors[0][0] = NAN, ERR_NOT_FINITE, "colors[0]");
}

TEST(instances_are_checked)
{
    EXPECT(c.instances[2].mesh = 2, ERR_RANGE, "instances[2].mesh");
    EXPECT(c.instances[2].flags = 8, ERR_RANGE, "instances[2].flags");
    EXPECT(c.instances[2].flags = 1, ERR_MISMATCH, "instances[2].to_world");
    EXPECT(c.instances[2].name = UINT32_MAX, ERR_RANGE, "instances[2].name");
    EXPECT(c.instances[2].reserved = 1, ERR_RANGE, "instances[2].reserved");
    EXPECT(c.instances[2].to_world[11] = NAN, ERR_NOT_FINITE, "instances[2].to_world");
    EXPECT(c.instances[2].to_world[11] = 1e16f, ERR_RANGE, "instances[2].to_world");
    EXPECT(c.instances[2].to_world[0] = 0, ERR_RANGE, "instances[2].to_world");
    EXPECT((c.instances[2].to_world[0] = 1, c.instances[2].to_world[1] = 1,
            c.instances[2].to_world[4] = 1),
           ERR_RANGE, "instances[2].to_world");
    EXPECT(c.instances[2].to_world[0] = 1e-6f, ERR_OK, "");
}

TEST(materials_are_checked)
{
    EXPECT(c.materials[1].base_color[3] = 1.5f, ERR_RANGE, "materials[1].base_color");
    EXPECT(c.materials[1].base_color[0] = NAN, ERR_NOT_FINITE, "materials[1].base_color");
    EXPECT(c.materials[1].emission[0] = -1, ERR_RANGE, "materials[1].emission");
    EXPECT(c.materials[1].metallic = 2, ERR_RANGE, "materials[1].metallic");
    EXPECT(c.materials[1].roughness = 1.7f, ERR_RANGE, "materials[1].roughness");
    EXPECT(c.materials[1].normal_scale = INFINITY, ERR_NOT_FINITE, "materials[1].normal_scale");
    EXPECT(c.materials[1].alpha_cutoff = -1, ERR_RANGE, "materials[1].alpha_cutoff");
    EXPECT(c.materials[1].specular = -1, ERR_RANGE, "materials[1].specular");
    EXPECT(c.materials[1].ior = -1, ERR_RANGE, "materials[1].ior");
    EXPECT(c.materials[1].transmission = NAN, ERR_NOT_FINITE, "materials[1].transmission");
    EXPECT(c.materials[1].alpha_mode = 3, ERR_RANGE, "materials[1].alpha_mode");
    EXPECT(c.materials[1].flags = 16, ERR_RANGE, "materials[1].flags");
    EXPECT(c.materials[1].name = 16, ERR_RANGE, "materials[1].name");
    EXPECT(c.materials[1].clearcoat = 1.5f, ERR_RANGE, "materials[1].clearcoat");
    EXPECT(c.materials[1].clearcoat_roughness = NAN, ERR_NOT_FINITE,
           "materials[1].clearcoat_roughness");
    EXPECT(c.materials[1].clearcoat_normal_scale = NAN, ERR_NOT_FINITE,
           "materials[1].clearcoat_normal_scale");
    EXPECT(c.materials[1].dispersion = -1, ERR_RANGE, "materials[1].dispersion");
    EXPECT(c.materials[1].dispersion = NAN, ERR_NOT_FINITE, "materials[1].dispersion");
    EXPECT(c.materials[1].sheen_color[2] = 1.5f, ERR_RANGE, "materials[1].sheen_color");
    EXPECT(c.materials[1].sheen_roughness = NAN, ERR_NOT_FINITE, "materials[1].sheen_roughness");
    EXPECT(c.materials[1].iridescence = NAN, ERR_NOT_FINITE, "materials[1].iridescence");
    EXPECT(c.materials[1].iridescence_ior = 0.5f, ERR_RANGE, "materials[1].iridescence_ior");
    EXPECT(c.materials[1].iridescence_nm[1] = INFINITY, ERR_NOT_FINITE,
           "materials[1].iridescence_nm");
    EXPECT(c.materials[1].diffuse_transmission = NAN, ERR_NOT_FINITE,
           "materials[1].diffuse_transmission");
    EXPECT(c.materials[1].diffuse_transmission_color[0] = -1, ERR_RANGE,
           "materials[1].diffuse_transmission_color");
    EXPECT(c.materials[1].sheen_color_texture.texture = 9, ERR_RANGE,
           "materials[1].sheen_color_texture");
    EXPECT(c.materials[1].clearcoat_texture.texture = 9, ERR_RANGE,
           "materials[1].clearcoat_texture");
    EXPECT(c.materials[1].base_color_texture.texture = 1, ERR_RANGE,
           "materials[1].base_color_texture");
    EXPECT(c.materials[1].metallic_roughness_texture.uv_set = 2, ERR_RANGE,
           "materials[1].metallic_roughness_texture");
    EXPECT(c.materials[1].normal_texture.transform[5] = NAN, ERR_NOT_FINITE,
           "materials[1].normal_texture");
    EXPECT(c.materials[1].emission_texture.texture = UINT32_MAX - 1, ERR_RANGE,
           "materials[1].emission_texture");
}

TEST(scattering_is_checked)
{
    EXPECT(c.materials[0].ior = 0, ERR_OK, "");
    EXPECT(c.materials[0].ior = 0.9f, ERR_RANGE, "materials[0].ior");
    EXPECT(c.materials[0].ior = 2000, ERR_RANGE, "materials[0].ior");
    EXPECT(c.materials[0].specular_color[2] = -1, ERR_RANGE, "materials[0].specular_color");
    EXPECT(c.materials[0].specular_color[0] = 40, ERR_OK, "");
    EXPECT(c.materials[0].anisotropy = 1.5f, ERR_RANGE, "materials[0].anisotropy");
    EXPECT(c.materials[0].anisotropy_rad = 7, ERR_RANGE, "materials[0].anisotropy_rad");
    EXPECT(c.materials[0].thickness = -1, ERR_RANGE, "materials[0].thickness");
    EXPECT(c.materials[0].thickness = INFINITY, ERR_NOT_FINITE, "materials[0].thickness");
    EXPECT(c.materials[0].attenuation[1] = 0, ERR_RANGE, "materials[0].attenuation");
    EXPECT(c.materials[0].attenuation[1] = 1.5f, ERR_RANGE, "materials[0].attenuation");
    EXPECT(c.materials[0].attenuation_distance = NAN, ERR_NOT_FINITE,
           "materials[0].attenuation_distance");
    EXPECT(c.materials[0].model = MODEL_COUNT, ERR_RANGE, "materials[0].model");
    EXPECT(c.materials[0].model = MODEL_MIRROR, ERR_OK, "");
    EXPECT(c.materials[0].model_specular[1] = 1.1f, ERR_RANGE, "materials[0].model_specular");
    EXPECT(c.materials[0].exponent_u = 1e6f, ERR_RANGE, "materials[0].exponent_u");
    EXPECT(c.materials[0].exponent_v = -1, ERR_RANGE, "materials[0].exponent_v");
    EXPECT(c.materials[0].alpha_u = 2, ERR_RANGE, "materials[0].alpha_u");
    EXPECT(c.materials[0].alpha_v = NAN, ERR_NOT_FINITE, "materials[0].alpha_v");
    EXPECT(c.materials[0].second_specular[2] = NAN, ERR_NOT_FINITE, "materials[0].second_specular");
    EXPECT(c.materials[0].second_alpha = 1.5f, ERR_RANGE, "materials[0].second_alpha");
    EXPECT(c.materials[0].grazing[1] = -1, ERR_RANGE, "materials[0].grazing");
    EXPECT(c.materials[0].eta[2] = -1, ERR_RANGE, "materials[0].eta");
    EXPECT(c.materials[0].k[0] = NAN, ERR_NOT_FINITE, "materials[0].k");
    EXPECT(c.materials[0].transmission_texture.texture = 1, ERR_RANGE,
           "materials[0].transmission_texture");
    EXPECT(c.materials[0].specular_texture.texture = 1, ERR_RANGE, "materials[0].specular_texture");
    EXPECT(c.materials[0].specular_color_texture.uv_set = 2, ERR_RANGE,
           "materials[0].specular_color_texture");
    EXPECT(c.materials[0].anisotropy_texture.transform[0] = INFINITY, ERR_NOT_FINITE,
           "materials[0].anisotropy_texture");
}

TEST(images_are_checked)
{
    EXPECT(c.textures[0].image = 1, ERR_RANGE, "textures[0].image");
    EXPECT(c.textures[0].wrap_u = 3, ERR_RANGE, "textures[0].wrap_u");
    EXPECT(c.textures[0].wrap_v = 3, ERR_RANGE, "textures[0].wrap_v");
    EXPECT(c.textures[0].filter = 2, ERR_RANGE, "textures[0].filter");
    EXPECT(c.images[0].width_px = 0, ERR_LIMIT, "images[0].width_px");
    EXPECT(c.images[0].width_px = UINT32_MAX, ERR_LIMIT, "images[0].width_px");
    EXPECT(c.images[0].height_px = 16385, ERR_LIMIT, "images[0].height_px");
    EXPECT(c.images[0].height_px = 3, ERR_RANGE, "images[0].first_byte");
    EXPECT(c.images[0].format = 1, ERR_RANGE, "images[0].format");
    EXPECT(c.images[0].flags = 4, ERR_RANGE, "images[0].flags");
    EXPECT(c.images[0].first_byte = 1, ERR_RANGE, "images[0].first_byte");
    EXPECT(c.images[0].first_byte = UINT64_MAX - 7, ERR_RANGE, "images[0].first_byte");
    EXPECT(c.images[0].name = 16, ERR_RANGE, "images[0].name");
    EXPECT(c.images[0].reserved = 1, ERR_RANGE, "images[0].reserved");
}

TEST(lights_are_checked)
{
    EXPECT(c.lights[0].type = 4, ERR_RANGE, "lights[0].type");
    EXPECT(c.lights[0].profile = 2, ERR_RANGE, "lights[0].profile");
    EXPECT(c.lights[0].position[0] = NAN, ERR_NOT_FINITE, "lights[0].position");
    EXPECT(c.lights[0].half_u[0] = 0, ERR_RANGE, "lights[0].half_u");
    EXPECT(c.lights[0].direction[1] = 1, ERR_RANGE, "lights[0].direction");
    EXPECT(c.lights[0].instance = 3, ERR_RANGE, "lights[0].instance");
    EXPECT(c.lights[1].color[0] = -1, ERR_RANGE, "lights[1].color");
    EXPECT(c.lights[1].cos_outer = 1, ERR_RANGE, "lights[1].cos_inner");
    EXPECT(c.lights[1].range = NAN, ERR_NOT_FINITE, "lights[1].range");
    EXPECT(c.lights[1].name = 16, ERR_RANGE, "lights[1].name");
}

TEST(cameras_are_checked)
{
    EXPECT(c.cameras[0].type = 2, ERR_RANGE, "cameras[0].type");
    EXPECT(c.cameras[0].name = 16, ERR_RANGE, "cameras[0].name");
    EXPECT(c.cameras[0].eye[0] = NAN, ERR_NOT_FINITE, "cameras[0].eye");
    EXPECT(c.cameras[0].right[0] = 0, ERR_RANGE, "cameras[0].right");
    EXPECT(c.cameras[0].forward[2] = 1, ERR_RANGE, "cameras[0].forward");
    EXPECT(c.cameras[0].yfov_rad = 0, ERR_RANGE, "cameras[0].yfov_rad");
    EXPECT(c.cameras[0].yfov_rad = 4, ERR_RANGE, "cameras[0].yfov_rad");
    EXPECT(c.cameras[0].aspect = -1, ERR_RANGE, "cameras[0].aspect");
    EXPECT(c.cameras[0].half_width = NAN, ERR_NOT_FINITE, "cameras[0].half_width");
    EXPECT(c.cameras[1].half_height = 0, ERR_RANGE, "cameras[1].half_height");
    EXPECT(c.cameras[1].is_default = 2, ERR_RANGE, "cameras[1].is_default");
    EXPECT(c.cameras[1].reserved = 1, ERR_RANGE, "cameras[1].reserved");
}

TEST(skies_are_checked)
{
    EXPECT(c.sky_count = 1, ERR_MISMATCH, "sky");
    EXPECT((c.sky_count = SCENE_SKY_TEXELS, c.sky[3][1] = NAN), ERR_NOT_FINITE, "sky[3].rgb");
    EXPECT((c.sky_count = SCENE_SKY_TEXELS, c.sky[3][1] = -1), ERR_RANGE, "sky[3].rgb");
}

TEST(record_sizes_are_known)
{
    assert_int_equal(scene_record_bytes(SCENE_POSITIONS), 12);
    assert_int_equal(scene_record_bytes(SCENE_MATERIALS), sizeof(struct scene_material));
    assert_int_equal(scene_record_bytes(SCENE_SECTION_COUNT), 0);
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) assert_true(scene_record_bytes(s) > 0);
}
