#pragma once
/* A closed room of 4 x 3 x 4 from (-2, 0, -2) on, with one window towards +x: y from 1 to 2.5, z
 * from -1 to 1. */
#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/scene/render_scene.h"

struct room_fixture {
    struct scene_fixture *parts;
    struct render_scene *scene;
};

/* Parts may be added between the first two. */
void room_fixture_begin(struct room_fixture *r); /* without anything */
void room_fixture_build(struct room_fixture *r);
void room_fixture_close(struct room_fixture *r);

void room_fixture_add_room(struct room_fixture *r);

/* Whether nothing is in the way. */
bool room_fixture_sees(const struct room_fixture *r, const float place[3],
                       const float direction[3]);
