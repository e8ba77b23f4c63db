/* map_ lines of MTL files. */
#include <string.h>

#include "proto/scene/mtl_map.h"
#include "tests/unit/unit.h"

TEST(names_may_have_spaces_and_options_before_them)
{
    static const struct {
        const char *line, *name;
        float scale[2], offset[2];
        bool clamp;
        const char *ignored;
    } rows[] = {
        {" a.png", "a.png", {1, 1}, {0, 0}, false, ""},
        {"my tex.png \r", "my tex.png", {1, 1}, {0, 0}, false, ""},
        {"-s 4 2 1 my tex.png", "my tex.png", {4, 2}, {0, 0}, false, ""},
        {"-s 4 tex.png", "tex.png", {4, 1}, {0, 0}, false, ""},
        {"-o 0.5 -0.25 -s 2 2 2 -clamp on t.png", "t.png", {2, 2}, {0.5f, -0.25f}, true, ""},
        {"-clamp off t.png", "t.png", {1, 1}, {0, 0}, false, ""},
        {"-s 1 1 1 2", "2", {1, 1}, {0, 0}, false, ""},
        {"-s 1 1 2 .png", ".png", {1, 1}, {0, 0}, false, ""},
        {"-boost 3 -mm 0 1 t.png", "t.png", {1, 1}, {0, 0}, false, "-boost"},
        {"-blendu on -texres 512 -type sphere t.png", "t.png", {1, 1}, {0, 0}, false, ""},
        {"-odd name.png", "-odd name.png", {1, 1}, {0, 0}, false, ""},
        {"\"my tex.png\"", "my tex.png", {1, 1}, {0, 0}, false, ""},
        {"maps\\wood\\a b.png", "maps/wood/a b.png", {1, 1}, {0, 0}, false, ""},
        {"maps\\\\wood\\\\\\t.png", "maps/wood/t.png", {1, 1}, {0, 0}, false, ""},
        {"", "", {1, 1}, {0, 0}, false, ""},
        {"-s", "", {1, 1}, {0, 0}, false, ""},
        {"-clamp", "", {1, 1}, {0, 0}, false, ""},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct mtl_map map;
        char line[128];
        strcpy(line, rows[i].line);
        mtl_map_read(line, &map);
        assert_string_equal(map.name, rows[i].name);
        assert_string_equal(map.ignored, rows[i].ignored);
        assert_int_equal(map.clamp, rows[i].clamp);
        assert_memory_equal(map.scale, rows[i].scale, sizeof map.scale);
        assert_memory_equal(map.offset, rows[i].offset, sizeof map.offset);
    }
}

TEST(names_of_other_folders_lose_them)
{
    static const char *const rows[][2] = {{"a b.png", "a b.png"},
                                          {"maps/a.png", "maps/a.png"},
                                          {"./a.png", "./a.png"},
                                          {"/home/me/a.png", "a.png"},
                                          {"C:/x/a b.png", "a b.png"},
                                          {"C:a.png", "a.png"},
                                          {"../maps/a.png", "a.png"},
                                          {"m/../../a.png", "a.png"},
                                          {"..a/b..c.png", "..a/b..c.png"},
                                          {"/", ""},
                                          {"", ""}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_string_equal(mtl_name_beside(rows[i][0]), rows[i][1]);
}
