#pragma once
/* A scene made by hand, and what is planned for it. */
#include <stdbool.h>

#include "server/job/plan/plan_parts.h"
#include "tests/unit/unit.h"

/* A scene of one mesh in the box [-1, 1]^3, one camera at z = 5, one lamp at the ceiling. */
struct stage {
    struct scene scene;
    struct scene_info info;
    struct scene_mesh mesh;
    struct scene_instance instances[3];
    struct scene_material material;
    float positions[9];
    uint32_t triangles[3];
    struct scene_light lights[LIMIT_LIGHTS + 1];
    struct scene_camera cameras[2];
    char names[32];
    char warnings[64];
    struct environment_header map, studio, estimate;
    bool has_studio, has_estimate, camera_stands;
    struct job job;
    struct plan plan;
    struct plan_report report;
    struct fault fault;
};

void set_lamp(struct scene_light *light);
int stage_set_up(void **state);
int stage_tear_down(void **state);
int make(struct stage *s);
const char *why(const struct stage *s, const char *what);
bool has_warning(const struct stage *s, const char *words);
