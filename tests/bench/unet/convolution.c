#include "tests/bench/unet/convolution.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/bench/threads.h"
#include "tests/bench/unet/convolution_kernels.h"

enum { TAPS = 9, LANES = CONVOLUTION_LANES };

static int32_t blocks_of(const struct convolution *c)
{
    return (c->outputs + LANES - 1) / LANES;
}

static size_t block_floats(const struct convolution *c)
{
    return TAPS * LANES * (size_t)c->inputs;
}

static bool fits(const struct tza_tensor *weight, const struct tza_tensor *bias)
{
    return weight->rank == 4 && strcmp(weight->layout, "oihw") == 0 && weight->sizes[2] == 3 &&
           weight->sizes[3] == 3 && bias->rank == 1 && bias->sizes[0] == weight->sizes[0];
}

/* Puts weights in the order in which the kernel reads them. */
static void arrange(struct convolution *c, const float *oihw)
{
    for (int32_t o = 0; o < c->outputs; o++) {
        float *block = c->weights + (size_t)(o / LANES) * block_floats(c);
        for (int32_t i = 0; i < c->inputs; i++)
            for (int32_t tap = 0; tap < TAPS; tap++)
                block[(tap * c->inputs + i) * LANES + o % LANES] =
                    oihw[(o * c->inputs + i) * TAPS + tap];
    }
}

int convolution_init(struct convolution *c, const struct tza *tza, const char *name,
                     struct fault *fault)
{
    char weight_name[TZA_NAME_BYTES], bias_name[TZA_NAME_BYTES];
    snprintf(weight_name, sizeof weight_name, "%s.weight", name);
    snprintf(bias_name, sizeof bias_name, "%s.bias", name);
    const struct tza_tensor *weight = tza_find(tza, weight_name), *bias = tza_find(tza, bias_name);
    *c = (struct convolution){0};
    if (!weight || !bias)
        return fault_set(fault, ERR_MISSING, name, "the archive lacks the layer %s", name);
    if (!fits(weight, bias))
        return fault_set(fault, ERR_MISMATCH, name, "%s is no layer of 3 by 3 windows", name);
    c->outputs = (int32_t)weight->sizes[0];
    c->inputs = (int32_t)weight->sizes[1];
    c->weights = calloc((size_t)blocks_of(c) * block_floats(c), sizeof *c->weights);
    c->bias = calloc((size_t)blocks_of(c) * LANES, sizeof *c->bias);
    if (!c->weights || !c->bias)
        return fault_set(fault, ERR_MEMORY, name, "no memory for %s", name);
    memcpy(c->bias, bias->values, bias->count * sizeof *c->bias);
    arrange(c, weight->values);
    return 0;
}

void convolution_fini(struct convolution *c)
{
    free(c->weights);
    free(c->bias);
    *c = (struct convolution){0};
}

struct run {
    const struct convolution *layer;
    const struct tensor *in;
    struct tensor *out;
    atomic_int next; /* row that no thread has begun */
};

static void run_row(const struct run *run, int32_t y)
{
    const struct convolution *c = run->layer;
    const struct convolution_kernels *kernels = KERNELS_BEST(convolution_kernels);
    struct convolution_row row = {
        .width = run->in->width, .channels = c->inputs, .stride = run->out->channels};
    for (int i = 0; i < 3; i++) row.inputs[i] = tensor_at(run->in, -1, y + i - 1);
    for (int32_t block = 0; block < blocks_of(c); block++) {
        row.weights = c->weights + (size_t)block * block_floats(c);
        row.bias = c->bias + block * LANES;
        row.output = tensor_at(run->out, 0, y) + block * LANES;
        kernels->row(&row);
    }
}

static void *run_rows(void *ctx)
{
    struct run *run = ctx;
    for (int32_t y; (y = atomic_fetch_add(&run->next, 1)) < run->in->height;) run_row(run, y);
    return NULL;
}

int convolution_run(const struct convolution *c, const struct tensor *in, struct tensor *out)
{
    struct run run = {.layer = c, .in = in, .out = out};
    *out = (struct tensor){0};
    if (in->channels != c->inputs) return ERR_MISMATCH;
    int rc = tensor_init(out, in->width, in->height, blocks_of(c) * LANES);
    if (rc) return rc;
    const int error = c->threads > 0 ? run_on_cores(c->threads, run_rows, &run)
                                     : run_on_all_cores(run_rows, &run);
    return error ? ERR_MEMORY : 0;
}
