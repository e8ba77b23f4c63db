/* OBJ with MTL, through assimp and our own file access. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

#define QUAD "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

ALL_TESTS(room_open, room_close);

TEST(reads_faces_and_materials)
{
    struct scene s;
    const char mtl[] =
        "newmtl red\nKd 0.5 0 0\nKs 0.1 0.1 0.1\nd 0.5\nnewmtl lamp\nKd 0 0 0\nKe 9 8 7\n";
    room_write("m.mtl", mtl, strlen(mtl));
    const char *text = "mtllib m.mtl\n" QUAD "g wall\nusemtl red\nf 1 2 3 4\n"
                       "g light\nusemtl lamp\nf -4 -3 -2 -1\n";
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_int_equal(s.count[SCENE_MESHES], 2);
    assert_int_equal(s.count[SCENE_TRIANGLES], 4);
    assert_int_equal(s.count[SCENE_MATERIALS], 2); /* and no phantom default */
    assert_int_equal(s.meshes[0].flags & MESH_HAS_NORMALS, 0);
    const struct scene_material *red = &s.materials[s.meshes[0].material];
    assert_string_equal(scene_name(&s, red->name), "red");
    assert_true(red->base_color[0] == 0.5f && red->metallic == 0 && red->roughness == 1);
    assert_int_equal(red->flags, MATERIAL_DOUBLE_SIDED);
    assert_string_equal(scene_name(&s, s.meshes[1].name), "light");
    assert_int_equal(s.count[SCENE_LIGHTS], 1);
    assert_true(s.lights[0].color[0] == 9 && s.lights[0].direction[2] == 1);
    assert_int_equal(s.meshes[1].flags & MESH_IS_LIGHT, MESH_IS_LIGHT);
    assert_true(room_warned("Ks and Ns are ignored"));
    assert_true(red->alpha_mode == ALPHA_BLEND && red->base_color[3] == 0.5f);
    assert_true(red->model == MODEL_GLTF && red->specular == 0);
    scene_unmap(&s);
}

/* The scene with one square of a material of these lines. */
static const struct scene_material *read_material(const char *lines, struct scene *s)
{
    char mtl[1024];
    snprintf(mtl, sizeof mtl, "newmtl m\n%s", lines);
    room_write("m.mtl", mtl, strlen(mtl));
    assert_int_equal(room_import_text("a.obj", "mtllib m.mtl\n" QUAD "usemtl m\nf 1 2 3 4\n", s),
                     0);
    return &s->materials[s->meshes[0].material];
}

TEST(models_follow_illum)
{
    static const struct {
        const char *lines;
        uint32_t model;
        float base, specular, exponent;
    } rows[] = {
        {"Kd .5 .5 .5\nillum 0\n", MODEL_GLTF, 0.5f, 0, 0},
        {"Kd .5 .5 .5\nillum 2\nKs 0 0 0\nNs 10\n", MODEL_GLTF, 0.5f, 0, 0},
        {"Kd .5 .5 .5\nillum 2\nKs .25 .25 .25\nNs 40\n", MODEL_BLINN_PHONG, 0.5f, 0.25f, 40},
        {"Kd 1 1 1\nillum 2\nKs 1 1 1\nNs 40\n", MODEL_BLINN_PHONG, 0.5f, 0.5f, 40},
        {"Kd 0 0 0\nillum 2\nKs 1 1 1\nNs 1e9\n", MODEL_BLINN_PHONG, 0, 1, 1e5f},
        {"Kd 0 0 0\nillum 3\nKs 1 1 1\nNs 1000\n", MODEL_MIRROR, 0, 1, 1000},
        {"Kd 0 0 0\nillum 5\nKs 1 1 1\n", MODEL_MIRROR, 0, 1, 0},
        {"Kd 0 0 0\nillum 8\nKs 1 1 1\nNs 20\n", MODEL_BLINN_PHONG, 0, 1, 20},
        {"Kd .5 .5 .5\nillum 5\nKs .25 .25 .25\nNs 999\n", MODEL_BECKMANN, 0.5f, 0.25f, 999},
        {"Kd .01 .01 .01\nillum 5\nKs 1 1 1\n", MODEL_MIRROR, 0, 1, 0},
        {"Kd .5 .5 .5\nillum 5\n", MODEL_GLTF, 0.5f, 0, 0},
        {"Kd .5 .5 .5\nillum 10\nKs 1 1 1\n", MODEL_GLTF, 0.5f, 0, 0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct scene s;
        const struct scene_material *m = read_material(rows[i].lines, &s);
        assert_int_equal(m->model, rows[i].model);
        assert_true(m->base_color[1] == rows[i].base);
        assert_true(m->model_specular[1] == rows[i].specular);
        assert_true(m->exponent_u == rows[i].exponent && m->exponent_v == rows[i].exponent);
        assert_true(m->specular == 0 && m->transmission == 0 && m->alpha_mode == ALPHA_OPAQUE);
        assert_int_equal(room_warned("sum up to more than 1"), i == 3);
        assert_int_equal(room_warned("Ns is out of range"), i == 4);
        assert_int_equal(room_warned("Ks and Ns are ignored"), i == 11);
        scene_unmap(&s);
    }
}

TEST(glass_is_a_solid)
{
    struct scene s;
    const struct scene_material *m =
        read_material("Kd .1 .1 .1\nKs 1 1 1\nTf .25 1 1\nNi 1.33\nd 0.5\nillum 7\n", &s);
    assert_true(m->model == MODEL_GLTF && m->transmission == 1 && m->thickness > 0);
    assert_true(m->specular == 1 && m->roughness == 0 && m->metallic == 0 && m->ior == 1.33f);
    assert_true(m->base_color[0] == 0.5f && m->base_color[1] == 1); /* twice passed: Tf */
    assert_true(m->alpha_mode == ALPHA_OPAQUE && m->base_color[3] == 1);
    scene_unmap(&s);
    m = read_material("illum 4\nNi 0.9\n", &s);
    assert_true(m->transmission == 1 && m->ior == 1.5f && m->base_color[0] == 1);
    assert_true(room_warned("Ni of 1 or less"));
    scene_unmap(&s);
}

TEST(metals_and_opacity_are_read)
{
    struct scene s;
    const struct scene_material *m = read_material("Kd 1 .5 0\nPm 1\nPr 0.25\nTr 0.25\n", &s);
    assert_true(m->model == MODEL_GLTF && m->metallic == 1 && m->roughness == 0.25f);
    assert_true(m->specular == 1 && m->base_color[1] == 0.5f);
    assert_true(m->alpha_mode == ALPHA_BLEND && m->base_color[3] == 0.75f);
    scene_unmap(&s);
    m = read_material("Kd 1 1 1\nPr 7\n", &s);
    assert_true(m->metallic == 0 && m->roughness == 1);
    assert_true(room_warned("Pr is out of range"));
    scene_unmap(&s);
}

TEST(turns_v_over)
{
    struct scene s;
    const char *text = QUAD "vt 0 0\nvt 1 0.25\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\n";
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_int_equal(s.meshes[0].flags, MESH_HAS_NORMALS);
    assert_true(s.uvs[1] == 1 && s.uvs[3] == 0.75f && s.uvs[5] == 0);
    scene_unmap(&s);
}

TEST(vertex_colours_are_srgb)
{
    struct scene s;
    const char *text = "v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 1 1 0 0 0 1\nf 1 2 3\n";
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_int_equal(s.meshes[0].flags, MESH_HAS_COLORS);
    assert_true(s.materials[s.meshes[0].material].flags & MATERIAL_COLORED);
    const float *c = s.colors + 4 * (size_t)s.meshes[0].first_color;
    assert_true(c[0] == 1 && c[1] == 0 && c[3] == 1);
    assert_true(fabsf(c[5] - 0.214041f) < 1e-6f && c[10] == 1); /* IEC 61966-2-1 */
    scene_unmap(&s);
}

TEST(reads_scenes_without_extension)
{
    struct scene s;
    assert_int_equal(room_import_text("deadbeef", "# a comment\n" QUAD "f 1 2 3\n", &s), 0);
    assert_int_equal(s.count[SCENE_TRIANGLES], 1);
    scene_unmap(&s);
}

TEST(missing_libraries_leave_grey)
{
    struct scene s;
    room_write("a.mtl", "newmtl a\nKd 1 0 0\n", 18);
    const char *text =
        "mtllib gone.mtl\nmtllib a.mtl my.mtl\n" QUAD "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n";
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_true(s.materials[s.meshes[0].material].base_color[0] == 1);
    assert_true(s.materials[s.meshes[1].material].base_color[1] == 0.6f);
    assert_true(room_warned("the file \"gone.mtl\" is missing: its materials are grey"));
    assert_true(room_warned("the file \"my.mtl\" is missing: its materials are grey"));
    scene_unmap(&s);
    assert_int_equal(room_import_text("a.obj", "mtllib my gone.mtl\n" QUAD "f 1 2 3\n", &s), 0);
    assert_true(room_warned("the file \"my gone.mtl\" is missing: its materials are grey"));
    scene_unmap(&s);
}

TEST(names_missing_maps)
{
    const char mtl[] = "newmtl red\nKd 1 0 0\nmap_Kd gone.png\n";
    room_write("t.mtl", mtl, strlen(mtl));
    room_refuses("a.obj", "mtllib t.mtl\n" QUAD "usemtl red\nf 1 2 3\n", ERR_NOT_FOUND,
                 "newmtl red.map_Kd");
    const char spaced[] = "newmtl my red\nmap_Kd -s 2 2 my tex.png\n";
    room_write("t.mtl", spaced, strlen(spaced));
    room_refuses("a.obj", "mtllib t.mtl\n" QUAD "usemtl my red\nf 1 2 3\n", ERR_NOT_FOUND,
                 "newmtl my red.map_Kd");
    assert_non_null(strstr(room_fault.detail, "\"my tex.png\""));
}

/* A PNG of 2 x 2 grey pixels, 0, 85, 170, 255. */
static const uint8_t png[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
    0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x00, 0x00, 0x00, 0x00, 0x57,
    0xdd, 0x52, 0xf8, 0x00, 0x00, 0x00, 0x0e, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x60,
    0x08, 0x65, 0x58, 0xf5, 0x1f, 0x00, 0x03, 0xad, 0x01, 0xff, 0x67, 0xfb, 0xca, 0x09, 0x00,
    0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

TEST(names_have_spaces_and_lines_end_as_on_windows)
{
    struct scene s;
    const char mtl[] = "newmtl m one\r\nKd 1 1 1\r\nmap_Kd -s 4 2 1 -o 0.5 0.25 -boost 2 my "
                       "tex.png\r\n\r\nnewmtl other\r\nKd 0 0 1\r\n";
    room_write("my mat.mtl", mtl, strlen(mtl));
    room_write("my tex.png", png, sizeof png);
    const char *text = "mtllib my mat.mtl\r\n" QUAD "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
                       "usemtl m one\nf -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1\n";
    assert_int_equal(room_import_text("a b.obj", text, &s), 0);
    const struct scene_material *m = &s.materials[s.meshes[0].material];
    assert_string_equal(scene_name(&s, m->name), "m one");
    assert_true(m->base_color[0] == 1 && m->base_color_texture.texture == 0);
    /* u' = 4 u + 0.5; v, which grows downwards, is 1 - (2 (1 - v) + 0.25) = 2 v - 1.25 */
    static const float expected[6] = {4, 0, 0.5f, 0, 2, -1.25f};
    assert_memory_equal(m->base_color_texture.transform, expected, sizeof expected);
    assert_int_equal(s.images[0].width_px, 2);
    assert_true(room_warned("the option -boost of map_Kd is ignored"));
    assert_string_equal(room_warnings.list[0].place, "my mat.mtl:3");
    assert_int_equal(s.count[SCENE_TRIANGLES], 2);
    scene_unmap(&s);
}

/* Files of other folders are those of the same name beside the scene, and never themselves. */
TEST(folders_of_other_machines_are_left_out)
{
    static const char *const names[] = {"C:\\Users\\me\\my tex.png", "/etc/my tex.png",
                                        "..\\maps\\my tex.png", "a/../../my tex.png"};
    struct scene s;
    room_write("my tex.png", png, sizeof png);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char mtl[128];
        snprintf(mtl, sizeof mtl, "\xef\xbb\xbfnewmtl m\nKd 1 1 1\nmap_Kd %s\n", names[i]);
        room_write("t.mtl", mtl, strlen(mtl));
        assert_int_equal(
            room_import_text("a.obj", "mtllib C:\\x\\t.mtl\n" QUAD "usemtl m\nf 1 2 3\n", &s), 0);
        assert_int_equal(s.images[0].width_px, 2);
        assert_string_equal(scene_name(&s, s.images[0].name), "my tex.png");
        scene_unmap(&s);
    }
    assert_true(
        room_warned("\"a/../../my tex.png\" is taken from beside the scene, as \"my tex.png\""));
    assert_int_equal(room_import_text("a.obj", "mtllib /etc/passwd\n" QUAD "f 1 2 3\n", &s), 0);
    assert_true(room_warned("the file \"/etc/passwd\" is missing: its materials are grey"));
    scene_unmap(&s);
}

TEST(several_libraries_and_missing_materials)
{
    struct scene s;
    room_write("a.mtl", "newmtl a\nKd 1 0 0\n", 18);
    room_write("b.mtl", "newmtl a\nKd 0 1 0\nnewmtl b\nKd 0 0 1\n", 36);
    const char *text = "mtllib a.mtl b.mtl\n" QUAD "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl "
                       "gone\nf 1 2 4\n";
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_true(s.materials[s.meshes[0].material].base_color[0] == 1); /* of one name the first */
    assert_true(s.materials[s.meshes[1].material].base_color[2] == 1);
    assert_true(s.materials[s.meshes[2].material].base_color[2] == 0.6f);
    assert_true(room_warned("no mtllib has this material"));
    assert_string_equal(room_warnings.list[0].place, "newmtl gone");
    scene_unmap(&s);
}

TEST(many_cornered_faces_may_be_concave)
{
    /* An arrow head, whose corners' fan would leave it. */
    struct scene s;
    const char *text = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 0\nf 1 2 4 3\n";
    double area = 0;
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    for (uint64_t t = 0; t < s.count[SCENE_TRIANGLES]; t++) {
        const float *p[3];
        for (int k = 0; k < 3; k++) p[k] = s.positions + 3 * s.triangles[3 * t + (size_t)k];
        const double twice = (double)((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                                      (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]));
        assert_true(twice > 0);
        area += twice / 2;
    }
    assert_true(area == 4);
    scene_unmap(&s);
}

TEST(refuses_what_is_no_geometry)
{
    struct scene s;
    assert_int_equal(room_import_text("a.obj", "", &s), ERR_TRUNCATED);
    assert_int_not_equal(room_import_text("a.obj", "nothing of this is a scene\n", &s), 0);
    assert_int_not_equal(room_import_text("a.obj", QUAD "l 1 2\nl 2 3\n", &s), 0);
    assert_int_equal(room_import_text("a.obj", "v nan 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", &s),
                     ERR_NOT_FINITE);
    assert_int_equal(room_import_text("a.obj", "v 1e20 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", &s),
                     ERR_LIMIT);
    assert_int_equal(room_import_text("a.stl", QUAD "f 1 2 3\n", &s), ERR_UNSUPPORTED);
    assert_int_not_equal(room_import_text("a.obj", QUAD "f 1 2 99\n", &s), 0);
}

/* A scan in metres of a national grid, exact to a millimetre, is drawn as near ones are. */
TEST(digits_beyond_floats_are_kept)
{
    static const char *const lines[] = {"v 500000.001 5400000.002 0.5 1 0 0\n",
                                        " v\t500000.003 5400000.002 0.5\t0 1 0\r\n",
                                        "v 500000.003 5400000.004 0.5 0 0 1\n"};
    struct scene s;
    char text[256];
    snprintf(text, sizeof text, "%s%s%sf 1 2 3\n", lines[0], lines[1], lines[2]);
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_int_equal(room_warnings.count, 0);
    const float *p = s.positions, *c = s.colors + 4 * (size_t)s.meshes[0].first_color;
    for (size_t i = 0; i < 3; i++) {
        const double x = s.info->origin[0] + (double)p[3 * i], y = (double)p[3 * i + 1];
        assert_true(fabs(x - (i == 0 ? 500000.001 : 500000.003)) < 1e-6);
        assert_true(fabs(s.info->origin[1] + y - (i == 2 ? 5400000.004 : 5400000.002)) < 1e-6);
        assert_true(c[4 * i + i] == 1.0f);
    }
    scene_unmap(&s);
}

/* What is no plain vertex leaves all of them as they are. */
TEST(odd_vertices_are_left_as_they_are)
{
    static const char *const odd[] = {"v 1e5 1e5 1e5 2", "v 1e5 1e5", "v 1e5 nan 1e5",
                                      "v 1e5 \\\n1e5 1e5", "v 1e5 1e5 1e5\rv 1e5 1e5 1e5"};
    size_t imported = 0;
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        struct scene s;
        char text[256];
        snprintf(text, sizeof text,
                 "%s\nv 100000 100000 100000\nv 100001 100000 100000\nv 100001 100001 100000\n"
                 "f 2 3 4\n",
                 odd[i]);
        if (room_import_text("a.obj", text, &s) != 0) continue;
        assert_true(s.info->origin[0] + (double)s.positions[0] == 100000.0);
        scene_unmap(&s);
        imported++;
    }
    assert_true(imported > 0);
}

TEST(vertices_after_a_byte_order_mark_keep_their_digits)
{
    struct scene s;
    assert_int_equal(room_import_text("a.obj",
                                      "\xef\xbb\xbfv 1000000.0625 0 0\nv 1000001 0 0\n"
                                      "v 1000001 1 0\nf 1 2 3\n",
                                      &s),
                     0);
    assert_true(s.info->origin[0] + (double)s.positions[0] == 1000000.0625);
    scene_unmap(&s);
}
