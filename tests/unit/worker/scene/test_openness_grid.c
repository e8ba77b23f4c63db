/* Cells of scenes: where they lie, also in scenes of odd extents. */
#include <math.h>

#include "tests/random.h"
#include "tests/unit/worker/scene/room_fixture.h"
#include "worker/scene/openness_grid.h"

static struct room_fixture r;
static struct openness_grid g;

static void build(void)
{
    room_fixture_build(&r);
    openness_grid_init(&g, r.scene);
    assert_true(g.cells >= 1 && g.cells <= OPENNESS_CELLS_MAX);
}

static uint32_t cell(float x, float y, float z)
{
    const uint32_t at = openness_grid_cell(&g, (const float[3]){x, y, z});
    assert_true(at < g.cells);
    return at;
}

static void check_finite(const struct openness_box *b)
{
    for (int k = 0; k < 3; k++) {
        assert_true(isfinite(b->low[k]) && isfinite(b->per_cell[k]) && b->per_cell[k] >= 0.0f);
        assert_true(b->size[k] >= 1);
    }
}

/* Of places all over, and of what is no place. */
static void check_places(float reach)
{
    struct random numbers = {5};
    const float odd[] = {0.0f, -0.0f, INFINITY, -INFINITY, NAN, 3e38f, -3e38f, 1e-40f};
    check_finite(&g.whole);
    check_finite(&g.dense);
    for (int i = 0; i < 1000; i++) {
        float p[3];
        for (int k = 0; k < 3; k++) p[k] = reach * (2.0f * random_unit(&numbers) - 1.0f);
        (void)cell(p[0], p[1], p[2]);
    }
    for (size_t i = 0; i < 8 * 8 * 8; i++) (void)cell(odd[i % 8], odd[i / 8 % 8], odd[i / 64]);
}

TEST(a_room_is_some_six_cells_long)
{
    room_fixture_begin(&r);
    room_fixture_add_room(&r);
    build();
    assert_int_equal(g.dense.first, 0);
    assert_int_equal(g.cells, g.whole.size[0] * g.whole.size[1] * g.whole.size[2]);
    assert_true(g.whole.size[0] >= 6 && g.whole.size[0] == g.whole.size[2]);
    assert_true(g.whole.size[1] < g.whole.size[0]);
    assert_true(cell(-1.9f, 0.1f, -1.9f) == 0 && cell(1.9f, 2.9f, 1.9f) == g.cells - 1);
    assert_true(cell(-1.9f, 0.1f, -1.9f) == cell(-9, -9, -9));
    check_places(5.0f);
    room_fixture_close(&r);
}

static void check_inner_cells(void)
{
    assert_true(g.dense.first > 0);
    assert_int_equal(g.cells, g.dense.first + g.dense.size[0] * g.dense.size[1] * g.dense.size[2]);
    assert_true(cell(-1.9f, 1, 0) != cell(0, 1, 0) && cell(0, 1, 0) != cell(1.9f, 1, 0));
    assert_true(cell(0, 1, -1.9f) != cell(0, 1, 0) && cell(0, 1, -1.9f) >= g.dense.first);
    assert_true(cell(400, 0, 0) < g.dense.first && cell(400, 0, 0) != cell(-400, 0, 0));
}

TEST(a_wide_plane_leaves_the_room_its_cells)
{
    room_fixture_begin(&r);
    room_fixture_add_room(&r);
    fixture_panel(r.parts, 0, (float[]){0, -0.1f, 0}, (float[]){500, 0, 0}, (float[]){0, 0, 500});
    build();
    check_inner_cells();
    check_places(600.0f);
    room_fixture_close(&r);
}

/* Seven instances beside one of as many triangles as all others together. */
TEST(a_dome_of_many_triangles_leaves_the_room_its_cells)
{
    room_fixture_begin(&r);
    room_fixture_add_room(&r);
    fixture_mesh(r.parts, 0, 0);
    for (int i = 0; i < 18; i++) {
        const float c = 500.0f * cosf((float)i), s = 500.0f * sinf((float)i);
        const uint32_t first = fixture_vertex(r.parts, c, 0, s);
        fixture_vertex(r.parts, c, 100, s);
        fixture_vertex(r.parts, c * 0.9f, 400, s * 0.9f);
        fixture_triangle(r.parts, first, first + 1, first + 2);
    }
    fixture_place(r.parts, r.parts->mesh_count - 1);
    build();
    check_inner_cells();
    check_places(600.0f);
    room_fixture_close(&r);
}

/* Instances are asked through their transforms. */
TEST(placed_rooms_are_found_where_they_stand)
{
    room_fixture_begin(&r);
    fixture_panel(r.parts, 0, (float[]){0, 0, 0}, (float[]){1000, 0, 0}, (float[]){0, 0, 1000});
    const uint32_t mesh = fixture_mesh(r.parts, 0, 0);
    for (int i = 0; i < 6; i++)
        fixture_quad(r.parts, (float[]){0, 0.1f * (float)i, 0}, (float[]){1, 0, 0},
                     (float[]){0, 0, 1});
    fixture_place_at(r.parts, mesh, (const float[]){1, 0, 0, 700, 0, 1, 0, 0, 0, 0, 1, 0});
    fixture_place_at(r.parts, mesh, (const float[]){1, 0, 0, 702, 0, 1, 0, 0, 0, 0, 1, 0});
    build();
    assert_true(cell(700, 0.1f, 0) >= g.dense.first && g.dense.first > 0);
    assert_true(cell(0, 0.1f, 0) < g.dense.first);
    room_fixture_close(&r);
}

TEST(odd_extents_have_cells)
{
    static const float triangles[][9] = {{1, 2, 3, 1, 2, 4, 1, 3, 3},         /* flat along x */
                                         {1, 2, 3, 1, 2, 3, 1, 2, 3},         /* a point */
                                         {0, 0, 0, 1e20f, 0, 0, 0, 1e20f, 0}, /* huge */
                                         {0, 0, 0, 1e-30f, 0, 0, 0, 1e-30f, 0}};
    for (size_t i = 0; i <= sizeof triangles / sizeof triangles[0]; i++) {
        room_fixture_begin(&r);
        if (i > 0) {
            const float *t = triangles[i - 1];
            fixture_mesh(r.parts, 0, 0);
            for (int k = 0; k < 3; k++)
                fixture_vertex(r.parts, t[3 * k], t[3 * k + 1], t[3 * k + 2]);
            fixture_triangle(r.parts, 0, 1, 2);
            fixture_place(r.parts, 0);
        }
        build();
        check_places(i == 3 ? 2e20f : 5.0f);
        room_fixture_close(&r);
    }
}
