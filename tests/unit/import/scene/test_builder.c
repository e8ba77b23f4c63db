/* The builder, the warnings and the report: limits, names, and what they become. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/import/report.h"
#include "server/import/scene/blob_writer.h"
#include "server/import/scene/cameras.h"
#include "server/import/scene/surface.h"
#include "tests/unit/unit.h"

static void add_triangle(struct builder *b)
{
    static const float p[] = {-1, 0, 0, 1, 0, 0, 0, 2, 0};
    void *at;
    assert_int_equal(builder_append(b, SCENE_POSITIONS, 3, &at, NULL), 0);
    memcpy(at, p, sizeof p);
    assert_int_equal(builder_append(b, SCENE_TRIANGLES, 1, &at, NULL), 0);
    memcpy(at, (uint32_t[]){0, 1, 2}, 12);
    assert_int_equal(builder_append(b, SCENE_MATERIALS, 1, &at, NULL), 0);
    surface_init(at);
    assert_int_equal(builder_append(b, SCENE_MESHES, 1, &at, NULL), 0);
    *(struct scene_mesh *)at = (struct scene_mesh){
        .vertex_count = 3, .triangle_count = 1, .first_uv = {SCENE_NONE, SCENE_NONE}};
    assert_int_equal(builder_append(b, SCENE_INSTANCES, 1, &at, NULL), 0);
    *(struct scene_instance *)at = (struct scene_instance){
        .flags = INSTANCE_IDENTITY, .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
}

TEST(writes_a_blob_that_opens)
{
    struct builder b;
    struct scene s;
    char path[] = "/tmp/test_builder.XXXXXX";
    close(mkstemp(path));
    assert_int_equal(builder_init(&b, NULL), 0);
    add_triangle(&b);
    uint32_t name;
    assert_int_equal(builder_name(&b, "chair", &name, NULL), 0);
    builder_meshes(&b)[0].name = name;
    warnings_add(&b.warnings, "somewhere", "something %d", 7);
    assert_int_equal(camera_append_default(&b, NULL), 0);
    assert_int_equal(builder_finish(&b, NULL), 0);
    assert_int_equal(blob_write(&b, path, NULL), 0);
    assert_int_equal(scene_map(path, &s, NULL), 0);
    assert_int_equal(s.info->placed_triangles, 1);
    assert_true(s.info->bounds_min[0] == -1 && s.info->bounds_max[1] == 2);
    assert_string_equal(scene_name(&s, s.meshes[0].name), "chair");
    assert_string_equal(s.warnings, "somewhere: something 7");
    assert_int_equal(s.cameras[0].is_default, 1);
    scene_unmap(&s);
    unlink(path);
    builder_fini(&b);
}

TEST(write_failures_leave_nothing)
{
    struct builder b;
    struct fault fault;
    assert_int_equal(builder_init(&b, NULL), 0);
    assert_int_equal(blob_write(&b, "/nowhere/at/all.blob", &fault), ERR_IO);
    builder_fini(&b);
}

TEST(refuses_an_empty_scene)
{
    struct builder b;
    struct fault fault;
    assert_int_equal(builder_init(&b, NULL), 0);
    assert_int_equal(builder_finish(&b, &fault), ERR_MISSING);
    assert_string_equal(fault.detail, "the scene has no triangles");
    builder_fini(&b);
}

TEST(refuses_counts_above_the_limits)
{
    struct builder b;
    struct fault fault;
    void *at;
    assert_int_equal(builder_init(&b, NULL), 0);
    assert_int_equal(builder_append(&b, SCENE_POSITIONS, LIMIT_VERTICES + 1ull, &at, &fault),
                     ERR_LIMIT);
    assert_int_equal(builder_append(&b, SCENE_POSITIONS, UINT64_MAX, &at, &fault), ERR_LIMIT);
    assert_int_equal(builder_append(&b, SCENE_LIGHTS, LIMIT_LIGHTS, &at, &fault), 0);
    assert_int_equal(builder_append(&b, SCENE_LIGHTS, 1, &at, &fault), ERR_LIMIT);
    builder_fini(&b);
}

TEST(far_instances_are_refused)
{
    struct builder b;
    struct fault fault;
    assert_int_equal(builder_init(&b, NULL), 0);
    add_triangle(&b);
    builder_instances(&b)[0].to_world[3] = 1e16f;
    assert_int_equal(builder_finish(&b, &fault), ERR_LIMIT);
    assert_string_equal(fault.pointer, "instances[0]");
    builder_fini(&b);
}

TEST(names_are_cut_between_characters)
{
    struct builder b;
    uint32_t name;
    char text[2 * LIMIT_NAME_BYTES + 1];
    for (size_t i = 0; i < sizeof text - 1; i += 2) memcpy(text + i, "\xc3\xa9", 2);
    text[sizeof text - 1] = 0;
    assert_int_equal(builder_init(&b, NULL), 0);
    assert_int_equal(builder_name(&b, "", &name, NULL), 0);
    assert_int_equal(name, 0);
    assert_int_equal(builder_name(&b, text, &name, NULL), 0);
    const char *stored = (const char *)b.sections[SCENE_NAMES].data + name;
    assert_true(strlen(stored) < LIMIT_NAME_BYTES);
    assert_int_equal(strlen(stored) % 2, 0);
    builder_fini(&b);
}

TEST(text_becomes_printable)
{
    static const char *const pairs[][2] = {
        {"plain", "plain"},          {"caf\xc3\xa9", "caf\xc3\xa9"},
        {"a\nb\x7f", "a?b?"},        {"\xc3", "?"},
        {"\xff\xfe", "??"},          {"\xc0\x80", "??"},
        {"\xed\xa0\x80", "???"},     {"\xf0\x9f\x98\x80", "\xf0\x9f\x98\x80"},
        {"\xf4\x90\x80\x80", "????"}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        char text[32];
        strcpy(text, pairs[i][0]);
        text_make_printable(text);
        assert_string_equal(text, pairs[i][1]);
    }
}

TEST(warnings_are_said_once)
{
    static struct warnings w;
    char text[WARNING_TEXT_BYTES];
    for (int i = 0; i < 5; i++) {
        char place[32];
        snprintf(place, sizeof place, "meshes[%d]", i);
        warnings_add(&w, place, "vertex colours are ignored");
    }
    assert_int_equal(w.count, 1);
    warnings_text(&w, 0, text);
    assert_string_equal(text, "meshes[0] and 4 more: vertex colours are ignored");
    for (int i = 0; i < 200; i++) warnings_add(&w, "", "kind %d", i);
    assert_int_equal(w.count, LIMIT_WARNINGS - 1);
    assert_int_equal(w.dropped, 201 - (LIMIT_WARNINGS - 1));
}

TEST(reports_are_one_line_of_json)
{
    struct fault fault;
    fault_set(&fault, ERR_TRUNCATED, "meshes[3].\xff\"x\"", "line\nbreak");
    char *line = report_failure(&fault);
    json_t *json = json_loads(line, 0, NULL);
    assert_non_null(json);
    assert_ptr_equal(strchr(line, '\n'), line + strlen(line) - 1);
    assert_true(json_is_false(json_object_get(json, "ok")));
    assert_string_equal(json_string_value(json_object_get(json, "code")), "TRUNCATED");
    assert_string_equal(json_string_value(json_object_get(json, "pointer")), "meshes[3].?\"x\"");
    json_decref(json);
    free(line);
    static struct warnings w;
    warnings_add(&w, "", "a \xff b");
    line = report_success(&(struct import_stats){.triangles = 2, .placed_triangles = 4}, &w, 0.25);
    json = json_loads(line, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(json, "placed_triangles")), 4);
    assert_int_equal(json_array_size(json_object_get(json, "warnings")), 1);
    assert_true(json_number_value(json_object_get(json, "cpu_s")) == 0.25);
    json_decref(json);
    free(line);
}
