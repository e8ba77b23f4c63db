/* What a plan decides, over scenes made by hand: effects, planes, lights, camera, reasons. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "proto/message.h"
#include "proto/plan_check.h"
#include "proto/samples.h"
#include "server/job/fingerprint.h"
#include "server/job/import_folder.h"
#include "server/job/imports.h"
#include "server/job/plan.h"

/* A scene of one mesh in the box [-1, 1]^3, one camera at z = 5, one lamp at the ceiling. */
struct stage {
    struct scene scene;
    struct scene_info info;
    struct scene_mesh mesh;
    struct scene_material material;
    struct scene_light lights[LIMIT_LIGHTS + 1];
    struct scene_camera cameras[2];
    char names[32];
    char warnings[64];
    struct job job;
    struct plan plan;
    struct plan_report report;
    struct fault fault;
};

static void set_lamp(struct scene_light *light)
{
    *light = (struct scene_light){.type = LIGHT_RECTANGLE,
                                  .position = {0, 1, 0},
                                  .direction = {0, -1, 0},
                                  .half_u = {0.25f, 0, 0},
                                  .half_v = {0, 0, 0.25f},
                                  .color = {10, 8, 6},
                                  .instance = SCENE_NONE};
}

static int set_up(void **state)
{
    static struct stage s;
    memset(&s, 0, sizeof s);
    memcpy(s.names, "\0main\0side", 11);
    memcpy(s.warnings, "first warning\0second", 21);
    s.info = (struct scene_info){.bounds_min = {-1, -1, -1}, .bounds_max = {1, 1, 1}};
    s.material = (struct scene_material){.base_color = {1, 1, 1, 1}};
    set_lamp(&s.lights[0]);
    for (int i = 0; i < 2; i++)
        s.cameras[i] = (struct scene_camera){.type = CAMERA_PERSPECTIVE,
                                             .name = i ? 6 : 1,
                                             .eye = {0, 0, 5},
                                             .right = {1, 0, 0},
                                             .up = {0, 1, 0},
                                             .forward = {0, 0, -1},
                                             .yfov_rad = i ? 0.5f : 1.0f};
    s.scene = (struct scene){.info = &s.info,
                             .meshes = &s.mesh,
                             .materials = &s.material,
                             .lights = s.lights,
                             .cameras = s.cameras,
                             .names = s.names,
                             .warnings = s.warnings};
    s.scene.count[SCENE_MESHES] = s.scene.count[SCENE_MATERIALS] = 1;
    s.scene.count[SCENE_LIGHTS] = 1;
    s.scene.count[SCENE_CAMERAS] = 2;
    s.scene.count[SCENE_NAMES] = 11;
    static const char text[] =
        "{\"scene\":{\"asset\":"
        "\"0000000000000000000000000000000000000000000000000000000000000001\"},"
        "\"image\":{\"width\":200,\"height\":100}}";
    assert_int_equal(job_read(text, sizeof text - 1, &s.job, &s.fault), 0);
    *state = &s;
    return 0;
}

static int tear_down(void **state)
{
    job_fini(&((struct stage *)*state)->job);
    return 0;
}

static int make(struct stage *s)
{
    struct digest blob = {{7}};
    s->fault = (struct fault){0};
    return plan_make(&s->job, &s->scene, &blob, 3, &s->plan, &s->report, &s->fault);
}

static const char *why(const struct stage *s, const char *what)
{
    for (uint32_t i = 0; i < s->report.skip_count; i++)
        if (!strcmp(s->report.skipped[i].what, what)) return s->report.skipped[i].why;
    return NULL;
}

static void plans_a_lit_scene(void **state)
{
    struct stage *s = *state;
    assert_int_equal(make(s), 0);
    assert_int_equal(plan_check(&s->plan, &s->fault), 0);
    assert_int_equal(s->plan.light_count, 1);
    assert_int_equal(s->plan.lights[0].strata_per_axis, 3);
    assert_true(fabsf(s->plan.lights[0].power - 1) < 1e-6f);
    assert_int_equal(s->plan.light_planes, 1u << LIGHT_PLANE_IRRADIANCE);
    assert_int_equal(s->plan.bounces, 1);
    assert_int_equal(s->plan.indirect_strata_per_axis, 3);
    assert_int_equal(s->plan.sub_samples, 3);
    assert_true(s->plan.planes & 1u << PLANE_INDIRECT_MEAN);
    assert_false(s->plan.planes & 1u << PLANE_INDIRECT_HALVES);
    assert_false(s->plan.planes & 1u << PLANE_EMISSION);
    assert_int_equal(s->plan.pattern.frame, 3);
    assert_int_equal(s->plan.capabilities, CAPABILITY_DIRECT | CAPABILITY_INDIRECT);
    assert_non_null(why(s, "filter"));
    assert_non_null(why(s, "plane emission"));
    assert_non_null(why(s, "plane slopes"));
    int exponent;
    assert_true(frexpf(s->plan.radiance_scale, &exponent) == 0.5f);
    assert_true(10 * s->plan.radiance_scale <= 256 && 10 * s->plan.radiance_scale > 100);
    assert_true(s->plan.length_unit == 2.0f); /* radius sqrt 3 */
}

static void keeps_the_vertical_view(void **state)
{
    struct stage *s = *state;
    assert_int_equal(make(s), 0);
    assert_true(fabsf(s->plan.camera.half_height - tanf(0.5f)) < 1e-6f);
    assert_true(fabsf(s->plan.camera.half_width - 2 * tanf(0.5f)) < 1e-6f);
    s->cameras[0].type = CAMERA_ORTHOGRAPHIC;
    s->cameras[0].half_width = s->cameras[0].half_height = 3;
    assert_int_equal(make(s), 0);
    assert_true(s->plan.camera.half_width == 6 && s->plan.camera.half_height == 3);
}

static void finds_cameras(void **state)
{
    struct stage *s = *state;
    s->job.camera.kind = JOB_CAMERA_NAME;
    strcpy(s->job.camera.name, "side");
    assert_int_equal(make(s), 0);
    assert_true(fabsf(s->plan.camera.half_height - tanf(0.25f)) < 1e-6f);
    assert_string_equal(s->report.camera_name, "side");
    strcpy(s->job.camera.name, "top");
    assert_int_equal(make(s), ERR_NOT_FOUND);
    assert_string_equal(s->fault.pointer, "/scene/camera");
    assert_non_null(strstr(s->fault.detail, "\"main\", \"side\""));
    s->job.camera.kind = JOB_CAMERA_INDEX;
    s->job.camera.index = 2;
    assert_int_equal(make(s), ERR_NOT_FOUND);
    s->job.camera.index = 1;
    assert_int_equal(make(s), 0);
}

static void looks_at_a_target(void **state)
{
    struct stage *s = *state;
    s->job.camera = (struct job_camera){.kind = JOB_CAMERA_LOOK_AT,
                                        .eye = {3, 4, 5},
                                        .target = {0, 1, 0},
                                        .up = {0, 2, 0.1f},
                                        .yfov_deg = 90};
    assert_int_equal(make(s), 0);
    const struct plan_camera *c = &s->plan.camera;
    assert_true(fabsf(c->half_height - 1) < 1e-6f);
    /* The middle of the picture goes through the target. */
    float origin[3], direction[3];
    plan_camera_ray(&s->plan, 100, 50, origin, direction);
    float t = (0 - origin[0]) / direction[0];
    assert_true(fabsf(origin[1] + t * direction[1] - 1) < 1e-5f);
    assert_true(fabsf(origin[2] + t * direction[2]) < 1e-5f);
    memcpy(s->job.camera.up, (float[3]){-3, -3, -5}, sizeof s->job.camera.up);
    assert_int_equal(make(s), ERR_RANGE);
    assert_string_equal(s->fault.pointer, "/scene/camera/up");
}

static void warns_of_darkness(void **state)
{
    struct stage *s = *state;
    s->scene.count[SCENE_LIGHTS] = 0;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_count, 0);
    assert_int_equal(s->plan.bounces, 0);
    assert_int_equal(s->plan.capabilities, 0);
    assert_non_null(strstr(s->report.warnings[s->report.warning_count - 1], "add \"lights\""));
    assert_string_equal(why(s, "effect indirect"), "nothing lights the scene");
    /* What glows lights by bounces, unless it stands for a light of the list. */
    s->material.emission[1] = 2;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.bounces, 1);
    assert_true(s->plan.planes & 1u << PLANE_EMISSION);
    s->mesh.flags = MESH_IS_LIGHT;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.bounces, 0);
    assert_true(s->plan.planes & 1u << PLANE_EMISSION);
}

static void drops_what_cannot_matter(void **state)
{
    struct stage *s = *state;
    s->job.light_count = 5;
    for (int i = 0; i < 5; i++)
        s->job.lights[i] = (struct plan_light){.type = LIGHT_POINT,
                                               .position = {0, 0, 10},
                                               .color = {1, 1, 1},
                                               .cos_inner = 1,
                                               .direction = {0, 0, -1}};
    memset(s->job.lights[0].color, 0, sizeof s->job.lights[0].color);
    s->job.lights[1].range = 8.9f;
    s->job.lights[2].range = 9.1f;
    s->job.lights[3].type = LIGHT_RECTANGLE; /* above the box, shining up */
    memcpy(s->job.lights[3].position, (float[3]){0, 2, 0}, 12);
    memcpy(s->job.lights[3].half_u, (float[3]){0, 0, 1}, 12);
    memcpy(s->job.lights[3].half_v, (float[3]){1, 0, 0}, 12);
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_count, 3);
    assert_string_equal(why(s, "light /lights/0"), "its colour is black");
    assert_string_equal(why(s, "light /lights/1"), "its range ends before the scene begins");
    assert_string_equal(why(s, "light /lights/3"), "it faces away from the whole scene");
    assert_true(s->report.lights[0].of_scene);
    assert_int_equal(s->report.lights[1].index, 2);
    assert_int_equal(s->report.lights[2].index, 4);
    s->job.scene_lights = false;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_count, 2);
    assert_non_null(why(s, "scene lights"));
}

static void refuses_too_many_lights(void **state)
{
    struct stage *s = *state;
    for (int i = 0; i <= LIMIT_LIGHTS; i++) set_lamp(&s->lights[i]);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS;
    assert_int_equal(make(s), 0);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS + 1;
    assert_int_equal(make(s), ERR_LIMIT);
    assert_string_equal(s->fault.pointer, "/lights");
}

static void layers_bring_their_planes(void **state)
{
    struct stage *s = *state;
    s->job.layers = LAYER_BEAUTY | LAYER_VISIBILITY | LAYER_SLOPE_MAX;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_planes, 7);
    assert_true(s->plan.capabilities & CAPABILITY_VISIBILITY);
    s->job.light_spp = 17 * 17;
    assert_int_equal(make(s), ERR_LIMIT);
    assert_string_equal(s->fault.pointer, "/sampling/light_spp");
    s->job.layers = LAYER_BEAUTY;
    assert_int_equal(make(s), 0);
}

static void shrinks_tiles_to_a_message(void **state)
{
    struct stage *s = *state;
    for (int i = 0; i < LIMIT_LIGHTS; i++) set_lamp(&s->lights[i]);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS;
    s->job.layers = LAYER_VISIBILITY;
    s->job.light_spp = 256;
    s->job.tile_px = 256;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.tile_px, 128);
    assert_non_null(strstr(s->report.warnings[s->report.warning_count - 1], "256"));
}

static void reports_as_json(void **state)
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
    json_decref(json);
}

static void fingerprints_leave_out_how(void **state)
{
    struct stage *s = *state;
    char a[FINGERPRINT_BYTES], b[FINGERPRINT_BYTES];
    assert_int_equal(fingerprint_of(&s->job, a), 0);
    s->job.priority = 7;
    s->job.tile_px = 64;
    assert_int_equal(fingerprint_of(&s->job, b), 0);
    assert_string_equal(a, b);
    s->job.seed++;
    assert_int_equal(fingerprint_of(&s->job, b), 0);
    assert_string_not_equal(a, b);
}

static void sources_depend_on_names_not_order(void **state)
{
    struct stage *s = *state;
    struct job_file files[2] = {{(char *)"a.bin", {{1}}}, {(char *)"b.png", {{2}}}};
    struct job_file swapped[2] = {files[1], files[0]};
    struct job_file renamed[2] = {files[0], {(char *)"c.png", {{2}}}};
    struct digest first, second, third;
    struct job job = s->job;
    job.file_count = 2;
    job.files = files;
    assert_int_equal(imports_source(&job, &first), 0);
    job.files = swapped;
    assert_int_equal(imports_source(&job, &second), 0);
    job.files = renamed;
    assert_int_equal(imports_source(&job, &third), 0);
    assert_true(digest_equal(&first, &second));
    assert_false(digest_equal(&first, &third));
}

static void sniffs_kinds(void **state)
{
    (void)state;
    assert_string_equal(import_folder_sniff("glTF\2\0\0\0", 8), ".glb");
    assert_string_equal(import_folder_sniff("\xef\xbb\xbf {\"asset\"", 12), ".gltf");
    assert_string_equal(import_folder_sniff("# Blender\nv 0 0 0\n", 18), ".obj");
    assert_null(import_folder_sniff("# bin\0ary", 9));
    assert_null(import_folder_sniff("\x89PNG\r\n", 6));
    assert_null(import_folder_sniff("  ", 2));
    assert_null(import_folder_sniff("", 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
        TEST(plans_a_lit_scene),
        TEST(keeps_the_vertical_view),
        TEST(finds_cameras),
        TEST(looks_at_a_target),
        TEST(warns_of_darkness),
        TEST(drops_what_cannot_matter),
        TEST(refuses_too_many_lights),
        TEST(layers_bring_their_planes),
        TEST(shrinks_tiles_to_a_message),
        TEST(reports_as_json),
        TEST(fingerprints_leave_out_how),
        TEST(sources_depend_on_names_not_order),
        TEST(sniffs_kinds),
    };
    return cmocka_run_group_tests_name("plan", tests, NULL, NULL);
}
