/* Boxes of surfaces with other lobes than a diffuse one, and the pixels that may show them. */
#include <stdlib.h>

#include "tests/random.h"
#include "tests/unit/worker/tile_fixture.h"
#include "worker/scene/mesh.h"
#include "worker/tile/lobe_view.h"

static uint32_t coated(struct scene_fixture *f)
{
    const uint32_t m = fixture_material(f, 0.5f, 0.5f, 0.5f);
    f->materials[m].specular = 1.0f;
    return m;
}

/* Lambert ones have none; what is placed through a transform has its own place. */
TEST(boxes_are_around_instances)
{
    struct scene_fixture *f = fixture_new();
    const uint32_t plain = fixture_material(f, 0.5f, 0.5f, 0.5f), other = coated(f);
    fixture_panel(f, plain, (float[]){0, 0, 0}, (float[]){9, 0, 0}, (float[]){0, 0, 9});
    fixture_panel(f, other, (float[]){1, 2, 3}, (float[]){0.5f, 0, 0}, (float[]){0, 0, 0.25f});
    fixture_place_at(f, f->mesh_count - 1, (float[]){0, 0, 2, 5, 0, 2, 0, 0, 2, 0, 0, 0});
    struct plan p = fixture_plan(16, 16, (float[]){0, 0, 20}, 1.0f);
    struct traced t = trace_all(f, &p);
    const struct lobe_boxes *b = t.scene->lobes;
    static const float expected[2][2][3] = {{{0.5f, 2, 2.75f}, {1.5f, 2, 3.25f}},
                                            {{10.5f, 4, 1}, {11.5f, 4, 3}}};
    assert_int_equal(b->count, 2);
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < 3; c++) {
            assert_true(b->box[k].low[c] == expected[k][0][c]);
            assert_true(b->box[k].high[c] == expected[k][1][c]);
        }
    traced_fini(&t);
    free(f);
}

/* Of scenes with catchers or holdouts there are boxes around all else, too. */
TEST(boxes_are_around_virtual_objects)
{
    struct scene_fixture *f = fixture_new();
    const uint32_t plain = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, plain, (float[]){0, 0, 0}, (float[]){9, 0, 0}, (float[]){0, 0, 9});
    struct plan p = fixture_plan(16, 16, (float[]){0, 0, 20}, 1.0f);
    struct traced t = trace_all(f, &p);
    assert_null(t.scene->virtuals);
    traced_fini(&t);
    const uint32_t object =
        fixture_panel(f, plain, (float[]){1, 2, 3}, (float[]){0.5f, 0, 0}, (float[]){0, 0, 0.25f});
    f->instances[0].flags |= INSTANCE_CATCHER;
    assert_int_equal(object, 1);
    t = trace_all(f, &p);
    const struct lobe_boxes *b = t.scene->virtuals;
    assert_int_equal(b->count, 1);
    assert_true(b->box[0].low[0] == 0.5f && b->box[0].high[2] == 3.25f);
    assert_int_equal(t.scene->lobes->count, 0);
    traced_fini(&t);
    free(f);
}

TEST(many_instances_share_boxes)
{
    struct scene_fixture *f = fixture_new();
    const uint32_t other = coated(f), count = 2 * LOBE_BOXES_MAX + 1;
    struct scene_instance *many = calloc(count, sizeof *many);
    assert_non_null(many);
    fixture_panel(f, other, (float[]){0, 0, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0.5f, 0});
    struct plan p = fixture_plan(16, 16, (float[]){0, 0, 20}, 1.0f);
    struct traced t = trace_all(f, &p);
    struct scene crowd = f->scene;
    for (uint32_t i = 0; i < count; i++) {
        many[i] = f->instances[0];
        many[i].to_world[3] = (float)(2 * i);
    }
    crowd.instances = many;
    crowd.count[SCENE_INSTANCES] = count;
    struct lobe_boxes *b;
    assert_int_equal(lobe_boxes_create(BOXES_OF_LOBES, &crowd, t.scene->meshes, NULL, &b), 0);
    assert_int_equal(b->count, (count + 2) / 3);
    for (uint32_t k = 0; k < b->count; k++) {
        const uint32_t last = 3 * k + 2 < count ? 3 * k + 2 : count - 1;
        assert_true(b->box[k].low[0] == (float)(6 * k) - 0.5f);
        assert_true(b->box[k].high[0] == (float)(2 * last) + 0.5f);
    }
    lobe_boxes_destroy(&b);
    assert_null(b);
    traced_fini(&t);
    free(many);
    free(f);
}

/* Whether a ray meets a box. */
static bool meets(const struct lobe_box *b, const float from[3], const float way[3])
{
    float first = 0, last = INFINITY;
    for (int c = 0; c < 3; c++) {
        const float a = (b->low[c] - from[c]) / way[c], z = (b->high[c] - from[c]) / way[c];
        first = fmaxf(first, fminf(a, z));
        last = fminf(last, fmaxf(a, z));
    }
    return first <= last;
}

static void draw_camera(struct random *r, struct plan *p)
{
    const float turn = (float)(6.28 * (double)random_unit(r)),
                lean = (float)((double)random_unit(r) - 0.5);
    const float s = sinf(turn), c = cosf(turn), ls = sinf(lean), lc = cosf(lean);
    for (int k = 0; k < 3; k++) p->camera.eye[k] = (float)(4 * (double)random_unit(r) - 2);
    fixture_look(p, (float[]){s * lc, ls, c * lc}, (float[]){-s * ls, lc, -c * ls});
    p->camera.half_width = p->camera.half_height = (float)(0.2 + (double)random_unit(r));
    if ((double)random_unit(r) < 0.3) p->camera.type = CAMERA_ORTHOGRAPHIC;
}

/* Whatever the camera, rays through the pixels of a block that is said to show no box meet none;
 * where boxes are small most blocks are said so. */
TEST(no_box_is_overlooked)
{
    struct random r = {7};
    static struct lobe_view view;
    static struct lobe_boxes boxes = {.count = 1};
    uint32_t met = 0, without = 0;
    for (int run = 0; run < 2000; run++) {
        struct plan p = fixture_plan(40, 24, (float[]){0, 0, 0}, 1.0f);
        const struct rect tile = {8, 8, 40, 24};
        draw_camera(&r, &p);
        for (int c = 0; c < 3; c++) {
            boxes.box[0].low[c] = (float)(4 * (double)random_unit(&r) - 2);
            boxes.box[0].high[c] = boxes.box[0].low[c] + 0.8f * random_unit(&r);
        }
        lobe_view_init(&boxes, &p, tile, &view);
        for (int32_t k = 0; k < 32; k++) {
            const int32_t x = 8 + k % 8 * 4, y = 8 + k / 8 * 4;
            const bool shows = lobe_view_meets(&view, (struct rect){x, y, x + 4, y + 4});
            without += !shows;
            for (int i = 0; i < 8; i++) {
                float from[3], way[3];
                plan_camera_ray(&p, (float)x + 4 * random_unit(&r), (float)y + 4 * random_unit(&r),
                                from, way);
                if (!meets(&boxes.box[0], from, way)) continue;
                met++;
                assert_true(shows);
            }
        }
    }
    assert_true(met > 1000);
    assert_true(without > 2000 * 32 / 2);
}
