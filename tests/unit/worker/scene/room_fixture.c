#include "tests/unit/worker/scene/room_fixture.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>

void room_fixture_begin(struct room_fixture *r)
{
    r->parts = calloc(1, sizeof *r->parts);
    assert_non_null(r->parts);
    fixture_material(r->parts, 0.5f, 0.5f, 0.5f);
}

void room_fixture_build(struct room_fixture *r)
{
    struct fault fault = {0};
    const int rc = render_scene_create(fixture_scene(r->parts), 1, NULL, &r->scene, &fault);
    if (rc) print_message("%s: %s\n", fault.pointer, fault.detail);
    assert_int_equal(rc, 0);
}

void room_fixture_close(struct room_fixture *r)
{
    render_scene_destroy(&r->scene);
    free(r->parts);
    r->parts = NULL;
}

void room_fixture_add_room(struct room_fixture *r)
{
    static const float panels[][3][3] = {{{0, 0, 0}, {2, 0, 0}, {0, 0, 2}},
                                         {{0, 3, 0}, {2, 0, 0}, {0, 0, 2}},
                                         {{-2, 1.5f, 0}, {0, 1.5f, 0}, {0, 0, 2}},
                                         {{0, 1.5f, -2}, {2, 0, 0}, {0, 1.5f, 0}},
                                         {{0, 1.5f, 2}, {2, 0, 0}, {0, 1.5f, 0}},
                                         {{2, 0.5f, 0}, {0, 0.5f, 0}, {0, 0, 2}},
                                         {{2, 2.75f, 0}, {0, 0.25f, 0}, {0, 0, 2}},
                                         {{2, 1.75f, -1.5f}, {0, 0.75f, 0}, {0, 0, 0.5f}},
                                         {{2, 1.75f, 1.5f}, {0, 0.75f, 0}, {0, 0, 0.5f}}};
    for (size_t i = 0; i < sizeof panels / sizeof panels[0]; i++)
        fixture_panel(r->parts, 0, panels[i][0], panels[i][1], panels[i][2]);
}

bool room_fixture_sees(const struct room_fixture *r, const float place[3], const float direction[3])
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = {.org_x = place[0],
                         .org_y = place[1],
                         .org_z = place[2],
                         .dir_x = direction[0],
                         .dir_y = direction[1],
                         .dir_z = direction[2],
                         .tfar = INFINITY,
                         .mask = UINT32_MAX};
    rtcOccluded1(r->scene->top, &context, &ray);
    return ray.tfar > 0.0f;
}
