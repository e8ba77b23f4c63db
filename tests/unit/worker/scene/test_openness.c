/* What is learned of a room with a window, and by how many threads. */
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/worker/scene/room_fixture.h"
#include "worker/scene/openness.h"

static struct room_fixture r;
static struct openness *o;

static void learn_alone(void)
{
    room_fixture_build(&r);
    o = openness_create(r.scene);
    assert_non_null(o);
    openness_learn(o);
}

static void close(void)
{
    openness_destroy(&o);
    room_fixture_close(&r);
}

/* Of a place; NULL: it is open. */
static const float *open_at(float x, float y, float z)
{
    const uint32_t cell = openness_grid_cell(openness_grid(o), (const float[3]){x, y, z});
    const uint16_t number = openness_numbers(o)[cell];
    assert_true(number <= openness_cells(o));
    return number > 0 ? openness_of(o, number - 1u) : NULL;
}

/* The mean over columns and rows of the directions around +y: column 16 is +x, 0 is -x. */
static float mean_of(const float *open, uint32_t u, uint32_t v, uint32_t columns, uint32_t rows)
{
    float sum = 0.0f;
    for (uint32_t j = v; j < v + rows; j++)
        for (uint32_t i = u; i < u + columns; i++) sum += open[j * OPENNESS_U + i % OPENNESS_U];
    return sum / (float)(columns * rows);
}

TEST(a_room_is_open_through_its_window)
{
    room_fixture_begin(&r);
    room_fixture_add_room(&r);
    learn_alone();
    assert_true(openness_cells(o) > 100);
    const float *middle = open_at(0.1f, 1.6f, 0.1f);
    assert_non_null(middle);
    assert_true(mean_of(middle, 15, 7, 2, 1) > 0.8f);
    assert_true(mean_of(middle, 24, 0, 16, 16) == 0.0f);
    assert_true(mean_of(middle, 0, 0, 32, 16) < 0.1f);
    /* From beside the window's wall it is seen aslant. */
    const float *aside = open_at(1.6f, 1.6f, -1.8f);
    assert_non_null(aside);
    assert_true(mean_of(aside, 18, 5, 6, 5) > mean_of(aside, 10, 5, 6, 5) + 0.2f);
    for (uint32_t i = 0; i < openness_cells(o) * OPENNESS_BINS; i++)
        assert_true(openness_of(o, 0)[i] >= 0.0f && openness_of(o, 0)[i] <= 1.0f);
    close();
}

TEST(places_outdoors_are_open)
{
    room_fixture_begin(&r);
    room_fixture_add_room(&r);
    fixture_panel(r.parts, 0, (float[]){0, 0, 0}, (float[]){12, 0, 0}, (float[]){0, 0, 12});
    learn_alone();
    assert_null(open_at(8, 1, 8));
    assert_null(open_at(-8, 2, 8));
    assert_null(open_at(0, 2, -90));
    assert_non_null(open_at(0, 1, 0));
    close();
}

static pthread_barrier_t start;

static void *learn(void *openness)
{
    pthread_barrier_wait(&start);
    openness_learn(openness);
    return NULL;
}

TEST(threads_that_learn_at_once_learn_the_same)
{
    static const int threads[] = {2, 7};
    room_fixture_begin(&r);
    room_fixture_add_room(&r);
    learn_alone();
    for (int k = 0; k < 40; k++) {
        struct openness *other = openness_create(r.scene);
        pthread_t id[7];
        pthread_barrier_init(&start, NULL, (unsigned)threads[k % 2]);
        for (int i = 0; i < threads[k % 2]; i++)
            assert_int_equal(pthread_create(&id[i], NULL, learn, other), 0);
        for (int i = 0; i < threads[k % 2]; i++) pthread_join(id[i], NULL);
        pthread_barrier_destroy(&start);
        openness_learn(other);
        assert_int_equal(openness_cells(other), openness_cells(o));
        assert_memory_equal(openness_numbers(other), openness_numbers(o),
                            openness_grid(o)->cells * sizeof(uint16_t));
        assert_memory_equal(openness_of(other, 0), openness_of(o, 0),
                            openness_cells(o) * OPENNESS_BINS * sizeof(float));
        openness_destroy(&other);
    }
    close();
}

/* Nothing to see, nothing that has an extent, and more than floats can square. */
TEST(odd_scenes_are_learned)
{
    for (int i = 0; i < 4; i++) {
        const float size = i == 3 ? 1e20f : 1.0f;
        room_fixture_begin(&r);
        if (i == 1) fixture_mesh(r.parts, 0, 0);
        if (i == 1)
            for (int k = 0; k < 3; k++) fixture_vertex(r.parts, 1, 2, 3);
        if (i == 1) fixture_triangle(r.parts, 0, 1, 2);
        if (i == 1) fixture_place(r.parts, 0);
        if (i > 1)
            fixture_panel(r.parts, 0, (float[]){0, 0, 0}, (float[]){size, 0, 0},
                          (float[]){0, 0, size});
        learn_alone();
        for (uint32_t k = 0; k < openness_cells(o) * OPENNESS_BINS; k++)
            assert_true(openness_of(o, 0)[k] >= 0.0f && openness_of(o, 0)[k] <= 1.0f);
        (void)open_at(0, 0, 0);
        if (i == 2) assert_null(open_at(0, 0, 0));
        close();
    }
}
