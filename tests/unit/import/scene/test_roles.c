/* Catchers and holdouts by name, and the ground. */
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"

static int open_room(void **state)
{
    room_choice = (struct scene_choice){0};
    return room_open(state);
}

EACH_TEST(open_room, room_close);

/* A lamp, a wall and a box of one triangle each; the lamp is a rectangle. */
static const char scene_text[] = "mtllib m.mtl\n"
                                 "v 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\nv 0 3 0\n"
                                 "g wall\nusemtl plaster\nf 1 2 5\n"
                                 "g box\nusemtl paint\nf 2 3 5\n"
                                 "g lamp\nusemtl glow\nf 1 2 3 4\n";
static const char materials[] = "newmtl plaster\nKd 1 1 1\nnewmtl paint\nKd 1 0 0\n"
                                "newmtl glow\nKd 0 0 0\nKe 5 5 5\n";

static void import(const char *catchers, const char *holdouts, struct scene *out)
{
    room_write("m.mtl", materials, strlen(materials));
    room_choice.catchers = catchers;
    room_choice.holdouts = holdouts;
    assert_int_equal(room_import_text("scene.obj", scene_text, out), 0);
}

static uint32_t flags_of(const struct scene *s, const char *name)
{
    for (uint64_t i = 0; i < s->count[SCENE_INSTANCES]; i++)
        if (strcmp(scene_name(s, s->instances[i].name), name) == 0)
            return s->instances[i].flags & (INSTANCE_CATCHER | INSTANCE_HOLDOUT);
    fail_msg("there is no %s", name);
    return 0;
}

TEST(names_of_nodes_and_of_materials_give_roles)
{
    struct scene s;
    import("[\"plaster\"]", "[\"lamp\"]", &s);
    assert_int_equal(flags_of(&s, "wall"), INSTANCE_CATCHER);
    assert_int_equal(flags_of(&s, "lamp"), INSTANCE_HOLDOUT);
    assert_int_equal(flags_of(&s, "box"), 0);
    assert_int_equal(s.count[SCENE_LIGHTS], 1);
    scene_unmap(&s);
}

TEST(a_lamp_that_is_not_in_the_photograph_is_no_light_of_the_scene)
{
    struct scene s;
    import("[\"wall\"]", NULL, &s);
    assert_int_equal(s.count[SCENE_LIGHTS], 0);
    scene_unmap(&s);
    import(NULL, NULL, &s);
    assert_int_equal(s.count[SCENE_LIGHTS], 1);
    assert_int_equal(flags_of(&s, "wall"), 0);
    scene_unmap(&s);
}

TEST(the_ground_is_a_large_catcher_that_moves_no_bounds)
{
    struct scene s;
    room_choice.has_ground = true;
    room_choice.ground_height = 0.5;
    import("[]", NULL, &s);
    const struct scene_instance *ground = &s.instances[s.count[SCENE_INSTANCES] - 1];
    const struct scene_mesh *mesh = &s.meshes[ground->mesh];
    assert_true(ground->flags & INSTANCE_CATCHER);
    assert_true(s.materials[mesh->material].specular == 0.0f);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        const float *p = s.positions + 3 * (size_t)(mesh->first_vertex + v);
        assert_true(p[1] == 0.5f);
        assert_true(p[0] < -20.0f || p[0] > 20.0f);
    }
    assert_true(s.info->bounds_min[1] == 1.0f && s.info->bounds_max[0] == 1.0f);
    assert_int_equal(s.info->placed_triangles, 6);
    scene_unmap(&s);
}

TEST(names_that_are_not_there_are_refused_where_they_stand)
{
    room_write("m.mtl", materials, strlen(materials));
    room_choice.catchers = "[\"wall\",\"floor\"]";
    room_refuses("scene.obj", scene_text, ERR_NOT_FOUND, "/catchers/1");
    room_choice.catchers = "[]";
    room_choice.holdouts = "[\"\\u001b\"]";
    room_refuses("scene.obj", scene_text, ERR_NOT_FOUND, "/holdouts/0");
    room_choice.catchers = "[\"wall\"]";
    room_choice.holdouts = "[\"plaster\"]";
    room_refuses("scene.obj", scene_text, ERR_EXISTS, "/holdouts/0");
}

/* A triangle as two nodes, with their extras.shearwater. */
static const char *two_nodes(const char *a, const char *b)
{
    static char text[1200];
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
             "\"nodes\":[{\"name\":\"a\",\"mesh\":0,\"extras\":{\"shearwater\":%s}},"
             "{\"name\":\"b\",\"mesh\":0,\"translation\":[2,0,0],"
             "\"extras\":{\"shearwater\":%s}}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
             "\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
             "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
             "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
             a, b);
    return text;
}

TEST(nodes_say_their_role_themselves)
{
    struct scene s;
    static const char *const words[][2] = {
        {"{\"catcher\":true}", "{\"holdout\":true}"},
        {"{\"catcher\":1}", "{\"holdout\":1,\"catcher\":0}"}, /* of Blender before 3.5 */
        {"{\"catcher\":true,\"holdout\":false}", "{\"holdout\":true}"}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        assert_int_equal(room_import_text("scene.gltf", two_nodes(words[i][0], words[i][1]), &s),
                         0);
        assert_int_equal(flags_of(&s, "a"), INSTANCE_CATCHER);
        assert_int_equal(flags_of(&s, "b"), INSTANCE_HOLDOUT);
        scene_unmap(&s);
    }
}

TEST(nodes_are_refused_what_no_role_has)
{
#define OURS "nodes[1].extras.shearwater"
    static const struct {
        const char *role, *place;
        int code;
    } bad[] = {{"{\"cather\":true}", OURS ".cather", ERR_UNKNOWN_MEMBER},
               {"{\"catcher\":\"yes\"}", OURS ".catcher", ERR_TYPE},
               {"{\"catcher\":2}", OURS ".catcher", ERR_TYPE},
               {"{\"holdout\":1.0}", OURS ".holdout", ERR_TYPE},
               {"{\"holdout\":null}", OURS ".holdout", ERR_TYPE},
               {"{\"holdout\":true,\"catcher\":1}", OURS, ERR_EXISTS},
               {"5", OURS, ERR_TYPE}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        room_refuses("scene.gltf", two_nodes("{}", bad[i].role), bad[i].code, bad[i].place);
}
