/* Layers beside plain loops over windows, by every instruction set that this machine has. */
#include "tests/bench/unet/convolution.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/bench/unet/archive.h"
#include "tests/unit/unit.h"

enum { INPUTS = 9, OUTPUTS = 35, WIDTH = 17, HEIGHT = 3, TAPS = 9 };

static float weights[OUTPUTS * INPUTS * TAPS], bias[OUTPUTS];

static struct archive_tensor tensors[2] = {
    {.name = "l.weight", .layout = "oihw", .sizes = {OUTPUTS, INPUTS, 3, 3}, .values = weights},
    {.name = "l.bias", .layout = "x", .sizes = {OUTPUTS}, .values = bias}};

static uint32_t last = 3;

static float signed_random(void)
{
    last = last * 1664525u + 1013904223u;
    return (float)(last >> 8) * 0x1p-23f - 1.0f;
}

static int make_layer(struct convolution *layer)
{
    struct bytes_writer w;
    struct tza tza;
    struct fault fault = {0};
    for (size_t i = 0; i < sizeof weights / sizeof *weights; i++) weights[i] = signed_random();
    for (size_t i = 0; i < OUTPUTS; i++) bias[i] = signed_random();
    tensors[0].type = tensors[1].type = 'f';
    archive_write(tensors, 2, &w);
    assert_int_equal(tza_parse(w.data, w.size_bytes, &tza, &fault), 0);
    int rc = convolution_init(layer, &tza, "l", &fault);
    tza_fini(&tza);
    bytes_writer_fini(&w);
    return rc;
}

/* By double sums over the window, zero outside. */
static double expected(const struct tensor *in, int32_t x, int32_t y, int32_t o)
{
    double sum = (double)bias[o];
    for (int32_t tap = 0; tap < TAPS; tap++) {
        const int32_t u = x + tap % 3 - 1, v = y + tap / 3 - 1;
        if (u < 0 || u >= WIDTH || v < 0 || v >= HEIGHT) continue;
        for (int32_t i = 0; i < INPUTS; i++)
            sum += (double)weights[(o * INPUTS + i) * TAPS + tap] * (double)tensor_at(in, u, v)[i];
    }
    return sum > 0 ? sum : 0;
}

static void assert_layer(const struct convolution *layer, const struct tensor *in)
{
    struct tensor out;
    assert_int_equal(convolution_run(layer, in, &out), 0);
    assert_int_equal(out.channels, 48);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++)
            for (int32_t o = 0; o < out.channels; o++) {
                const double want = o < OUTPUTS ? expected(in, x, y, o) : 0;
                assert_true(fabs((double)tensor_at(&out, x, y)[o] - want) < 2e-5);
            }
    /* The border stays zero, whatever blocks of pixels pass the row's end. */
    for (int32_t y = -1; y <= HEIGHT; y++)
        for (int32_t o = 0; o < out.channels; o++) {
            assert_true(tensor_at(&out, -1, y)[o] == 0.0f);
            assert_true(tensor_at(&out, WIDTH, y)[o] == 0.0f);
        }
    tensor_fini(&out);
}

TEST(layers_are_sums_over_windows)
{
    static const char *const sets[] = {"sse4.2", "avx2", "avx512"};
    struct convolution layer;
    struct tensor in;
    assert_int_equal(make_layer(&layer), 0);
    assert_int_equal(tensor_init(&in, WIDTH, HEIGHT, INPUTS), 0);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++)
            for (int32_t i = 0; i < INPUTS; i++) tensor_at(&in, x, y)[i] = signed_random();
    for (int i = 0; i < 3; i++) {
        setenv("SHEARWATER_ISA", sets[i], 1);
        assert_layer(&layer, &in);
    }
    unsetenv("SHEARWATER_ISA");
    tensor_fini(&in);
    convolution_fini(&layer);
}

TEST(layers_of_other_shapes_are_refused)
{
    struct convolution layer;
    struct tensor in, out;
    assert_int_equal(make_layer(&layer), 0);
    assert_int_equal(tensor_init(&in, WIDTH, HEIGHT, INPUTS + 1), 0);
    assert_int_equal(convolution_run(&layer, &in, &out), ERR_MISMATCH);
    tensor_fini(&in);
    convolution_fini(&layer);
    tensors[1].sizes[0] = OUTPUTS - 1;
    assert_int_equal(make_layer(&layer), ERR_MISMATCH);
    convolution_fini(&layer);
    tensors[1].sizes[0] = OUTPUTS;
    tensors[0].layout = "iohw";
    assert_int_equal(make_layer(&layer), ERR_MISMATCH);
    convolution_fini(&layer);
    tensors[0].layout = "oihw";
    tensors[1].name = "other.bias";
    assert_int_equal(make_layer(&layer), ERR_MISSING);
    convolution_fini(&layer);
    tensors[1].name = "l.bias";
}
