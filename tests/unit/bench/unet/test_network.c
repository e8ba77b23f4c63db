/* A network whose answer is known: its layers pass one channel on, so that each level adds the
 * largest number of larger cells, and the last but one moves the picture. */
#include "tests/bench/unet/network.h"

#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/bench/unet/archive.h"
#include "tests/unit/unit.h"

enum { SIDE = 32, TAPS = 9, MIDDLE = 4, RIGHT_ABOVE = 2, MAX_INPUTS = 32 + 9 };

/* Output `to` is the sum of the inputs a and b through one tap; all others are zero. */
struct wiring {
    const char *name;
    uint32_t inputs, outputs, a, b, to, tap;
};

/* The second block of lanes and others than the first are in use. */
static const struct wiring wirings[NETWORK_LAYERS] = {
    {"enc_conv0", 9, 32, 2, 2, 17, MIDDLE},       {"enc_conv1", 32, 16, 17, 17, 3, MIDDLE},
    {"enc_conv2", 16, 16, 3, 3, 0, MIDDLE},       {"enc_conv3", 16, 16, 0, 0, 15, MIDDLE},
    {"enc_conv4", 16, 16, 15, 15, 1, MIDDLE},     {"enc_conv5a", 16, 32, 1, 1, 31, MIDDLE},
    {"enc_conv5b", 32, 16, 31, 31, 4, MIDDLE},    {"dec_conv4a", 32, 16, 4, 31, 0, MIDDLE},
    {"dec_conv4b", 16, 16, 0, 0, 0, MIDDLE},      {"dec_conv3a", 32, 16, 0, 16, 0, MIDDLE},
    {"dec_conv3b", 16, 16, 0, 0, 0, MIDDLE},      {"dec_conv2a", 32, 16, 0, 19, 0, MIDDLE},
    {"dec_conv2b", 16, 16, 0, 0, 0, MIDDLE},      {"dec_conv1a", 25, 16, 0, 18, 0, MIDDLE},
    {"dec_conv1b", 16, 16, 0, 0, 5, RIGHT_ABOVE}, {"dec_conv0", 16, 3, 5, 5, 1, MIDDLE}};

static const float zeros[32];

static float *weights_of(const struct wiring *w)
{
    float *weights = calloc((size_t)w->outputs * w->inputs * TAPS, sizeof *weights);
    assert_non_null(weights);
    weights[(w->to * w->inputs + w->a) * TAPS + w->tap] = 1;
    weights[(w->to * w->inputs + w->b) * TAPS + w->tap] = 1;
    return weights;
}

/* Leaves out the layers from `count` on. */
static int make_network(struct network *network, uint32_t count)
{
    static char names[2 * NETWORK_LAYERS][32];
    struct archive_tensor tensors[2 * NETWORK_LAYERS];
    struct bytes_writer w;
    struct tza tza;
    struct fault fault = {0};
    for (uint32_t i = 0; i < count; i++) {
        const struct wiring *of = &wirings[i];
        snprintf(names[2 * i], sizeof *names, "%s.weight", of->name);
        snprintf(names[2 * i + 1], sizeof *names, "%s.bias", of->name);
        tensors[2 * i] = (struct archive_tensor){
            names[2 * i], "oihw", {of->outputs, of->inputs, 3, 3}, 'h', weights_of(of)};
        tensors[2 * i + 1] =
            (struct archive_tensor){names[2 * i + 1], "x", {of->outputs}, 'h', zeros};
    }
    archive_write(tensors, 2 * count, &w);
    assert_int_equal(tza_parse(w.data, w.size_bytes, &tza, &fault), 0);
    int rc = network_init(network, &tza, &fault);
    for (uint32_t i = 0; i < count; i++) free((void *)tensors[2 * i].values);
    tza_fini(&tza);
    bytes_writer_fini(&w);
    return rc;
}

static float input(int32_t x, int32_t y)
{
    return (float)((x * 7 + y * 13) % 29) + 1;
}

/* The largest input of the cell of so many pixels that has (x, y). */
static float cell_maximum(int32_t x, int32_t y, int32_t cell)
{
    float most = 0;
    for (int32_t v = y / cell * cell; v < (y / cell + 1) * cell; v++)
        for (int32_t u = x / cell * cell; u < (x / cell + 1) * cell; u++)
            most = input(u, v) > most ? input(u, v) : most;
    return most;
}

/* All levels together. */
static float expected(int32_t x, int32_t y)
{
    float sum = 0;
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE) return 0;
    for (int32_t cell = 1; cell <= 16; cell *= 2) sum += cell_maximum(x, y, cell);
    return sum;
}

TEST(a_network_gives_its_known_answer)
{
    struct network network;
    struct tensor in, out;
    struct fault fault = {0};
    assert_int_equal(make_network(&network, NETWORK_LAYERS), 0);
    assert_int_equal(tensor_init(&in, SIDE, SIDE, NETWORK_INPUTS), 0);
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) tensor_at(&in, x, y)[2] = input(x, y);
    assert_int_equal(network_run(&network, &in, &out, &fault), 0);
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            assert_true(tensor_at(&out, x, y)[0] == 0.0f);
            assert_true(tensor_at(&out, x, y)[1] == expected(x + 1, y - 1));
            assert_true(tensor_at(&out, x, y)[2] == 0.0f);
        }
    tensor_fini(&in);
    tensor_fini(&out);
    network_fini(&network);
}

TEST(what_does_not_fit_is_refused)
{
    struct network network;
    struct tensor in, out;
    struct fault fault = {0};
    assert_int_equal(make_network(&network, NETWORK_LAYERS - 1), ERR_MISSING);
    network_fini(&network);
    assert_int_equal(make_network(&network, NETWORK_LAYERS), 0);
    assert_int_equal(tensor_init(&in, SIDE, SIDE + 8, NETWORK_INPUTS), 0);
    assert_int_equal(network_run(&network, &in, &out, &fault), ERR_MISMATCH);
    tensor_fini(&in);
    assert_int_equal(tensor_init(&in, SIDE, SIDE, NETWORK_INPUTS - 1), 0);
    assert_int_equal(network_run(&network, &in, &out, &fault), ERR_MISMATCH);
    tensor_fini(&in);
    network_fini(&network);
}
