/* What is reported of a plan, as JSON. */
#include <string.h>

#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

EACH_TEST(stage_set_up, stage_tear_down);

TEST(names_of_materials_stay_ascii)
{
    struct stage *s = *state;
    memcpy(s->names + 1, "m\xc3\xa4 \xff", 6);
    s->material.specular = 1;
    assert_int_equal(make(s), 0);
    assert_string_equal(why(s, "light fields alone"),
                        "material 0 \"m\\xc3\\xa4 \\xff\" is not Lambert");
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    json_decref(json);
}

TEST(reports_as_json)
{
    struct stage *s = *state;
    s->scene.count[SCENE_WARNINGS] = 21;
    assert_int_equal(make(s), 0);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_int_equal(json_array_size(json_object_get(json, "warnings")), 2);
    assert_int_equal(json_array_size(json_object_get(json, "lights")), 1);
    json_t *skip = json_array_get(json_object_get(json, "skipped"), 0);
    assert_true(json_is_string(json_object_get(skip, "what")));
    assert_true(json_is_string(json_object_get(skip, "why")));
    assert_string_equal(json_string_value(json_object_get(json, "integrator")), "light_field");
    assert_true(json_is_null(json_object_get(json, "environment")));
    assert_true(json_is_null(json_object_get(json, "emitters")));
    json_decref(json);
}

static void has_word(const json_t *list, const char *word)
{
    size_t i;
    json_t *item;
    json_array_foreach (list, i, item)
        if (!strcmp(json_string_value(item), word)) return;
    fail_msg("%s is missing", word);
}

TEST(reports_paths_as_json)
{
    struct stage *s = *state;
    s->material.emission[0] = 1;
    s->job.spp = 100;
    s->job.layers = LAYERS_AVAILABLE;
    s->job.occlusion_distance = 1;
    s->job.aperture_radius = s->job.focus_distance = 1;
    s->job.environment = (struct job_environment){.kind = ENVIRONMENT_MAP, .intensity = 1};
    assert_int_equal(make(s), 0);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_string_equal(json_string_value(json_object_get(json, "integrator")), "paths");
    static const char *const effects[] = {"primary",  "antialias",  "direct", "shadows",
                                          "indirect", "emission",   "lens",   "occlusion",
                                          "emitters", "environment"};
    for (size_t i = 0; i < sizeof effects / sizeof effects[0]; i++)
        has_word(json_object_get(json, "effects"), effects[i]);
    static const char *const planes[] = {"depth",       "path_radiance", "path_diffuse_indirect",
                                         "path_albedo", "path_coverage", "path_visibility"};
    for (size_t i = 0; i < sizeof planes / sizeof planes[0]; i++)
        has_word(json_object_get(json, "planes"), planes[i]);
    const json_t *environment = json_object_get(json, "environment");
    assert_string_equal(json_string_value(json_object_get(environment, "type")), "map");
    assert_int_equal(json_string_length(json_object_get(environment, "map")), 64);
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(json, "emitters"), "instances")), 1);
    const json_t *samples = json_object_get(json, "samples");
    assert_int_equal(json_integer_value(json_object_get(samples, "paths")), 100);
    assert_int_equal(json_integer_value(json_object_get(samples, "passes")), 4);
    assert_true(
        json_real_value(json_object_get(json_object_get(json, "camera"), "focus_distance")) == 1);
    json_decref(json);
}

/* Rows as "light lobes by filter", one after the other. */
static void expect_filters(const struct stage *s, const char *expected)
{
    char text[1024] = "";
    size_t i;
    json_t *json = plan_report_json(&s->plan, &s->report), *row;
    assert_non_null(json);
    json_array_foreach (json_object_get(json, "light_filters"), i, row) {
        static const char *const keys[] = {"light", "lobes", "by", "filter"};
        for (int k = 0; k < 4; k++) {
            strcat(text, json_string_value(json_object_get(row, keys[k])));
            strcat(text, k < 3 ? " " : "\n");
        }
    }
    assert_string_equal(text, expected);
    json_decref(json);
}

TEST(tells_what_cleans_which_light)
{
    struct stage *s = *state;
    s->job.indirect_bounces = 2;
    assert_int_equal(make(s), 0);
    expect_filters(s, "rectangle diffuse light_field sheared\n"
                      "indirect diffuse light_field constant\n");
    s->material.metallic = s->material.roughness = 0.5f;
    assert_int_equal(make(s), 0);
    expect_filters(s, "rectangle diffuse light_field sheared\n"
                      "rectangle other paths halves\n"
                      "indirect diffuse light_field constant\n"
                      "indirect other paths halves\n");
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    assert_int_equal(make(s), 0);
    expect_filters(s, "rectangle diffuse light_field sheared\n"
                      "rectangle other paths halves\n"
                      "environment diffuse paths halves\n"
                      "environment other paths halves\n"
                      "indirect diffuse paths halves\n"
                      "indirect other paths halves\n");
    s->job.indirect = INDIRECT_LINEAR;
    s->job.glossy = GLOSSY_VIRTUAL_HIT;
    assert_int_equal(make(s), 0);
    expect_filters(s, "rectangle diffuse paths halves\n"
                      "rectangle other paths halves\n"
                      "environment diffuse paths halves\n"
                      "environment other paths halves\n"
                      "indirect diffuse light_field linear\n"
                      "indirect other light_field virtual_hit\n");
    s->job.method = FILTER_NONE;
    s->job.indirect_bounces = 0;
    assert_int_equal(make(s), 0);
    expect_filters(s, "rectangle diffuse paths none\n"
                      "rectangle other paths none\n"
                      "environment diffuse paths none\n"
                      "environment other paths none\n");
}
