#include "tests/unit/server/job/plan/plan_stage.h"

#include <string.h>

void set_lamp(struct scene_light *light)
{
    *light = (struct scene_light){.type = LIGHT_RECTANGLE,
                                  .position = {0, 1, 0},
                                  .direction = {0, -1, 0},
                                  .half_u = {0.25f, 0, 0},
                                  .half_v = {0, 0, 0.25f},
                                  .color = {10, 8, 6},
                                  .instance = SCENE_NONE};
}

int stage_set_up(void **state)
{
    static struct stage s;
    memset(&s, 0, sizeof s);
    memcpy(s.names, "\0main\0side", 11);
    memcpy(s.warnings, "first warning\0second", 21);
    s.info = (struct scene_info){.bounds_min = {-1, -1, -1}, .bounds_max = {1, 1, 1}};
    /* A triangle of area 2 with a Lambert surface. */
    s.mesh = (struct scene_mesh){.vertex_count = 3, .triangle_count = 1};
    memcpy(s.positions, (float[]){0, 0, 0, 2, 0, 0, 0, 2, 0}, sizeof s.positions);
    memcpy(s.triangles, (uint32_t[]){0, 1, 2}, sizeof s.triangles);
    s.instances[0].flags = INSTANCE_IDENTITY;
    s.material = (struct scene_material){
        .base_color = {1, 1, 1, 1}, .name = 1, .normal_texture = {.texture = SCENE_NONE}};
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
                             .positions = s.positions,
                             .triangles = s.triangles,
                             .meshes = &s.mesh,
                             .instances = s.instances,
                             .materials = &s.material,
                             .lights = s.lights,
                             .cameras = s.cameras,
                             .names = s.names,
                             .warnings = s.warnings};
    s.scene.count[SCENE_MESHES] = s.scene.count[SCENE_MATERIALS] = 1;
    s.scene.count[SCENE_INSTANCES] = s.scene.count[SCENE_TRIANGLES] = 1;
    s.map = (struct environment_header){.mean = {1, 2, 3}, .maximum = {100, 200, 300}};
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

int stage_tear_down(void **state)
{
    job_fini(&((struct stage *)*state)->job);
    return 0;
}

int make(struct stage *s)
{
    struct plan_source source = {
        .scene = &s->scene, .scene_blob = {{7}}, .map = &s->map, .map_blob = {{8}}};
    source.camera_stands = s->camera_stands;
    if (s->has_studio) source.studio = &s->studio, source.studio_blob = (struct digest){{9}};
    if (s->has_estimate) source.estimate = &s->estimate, source.estimate_blob.bytes[0] = 10;
    s->fault = (struct fault){0};
    return plan_make(&s->job, &source, 3, &s->plan, &s->report, &s->fault);
}

const char *why(const struct stage *s, const char *what)
{
    for (uint32_t i = 0; i < s->report.skip_count; i++)
        if (!strcmp(s->report.skipped[i].what, what)) return s->report.skipped[i].why;
    return NULL;
}

bool has_warning(const struct stage *s, const char *words)
{
    for (uint32_t i = 0; i < s->report.warning_count; i++)
        if (strstr(s->report.warnings[i], words)) return true;
    return false;
}
