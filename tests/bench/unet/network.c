#include "tests/bench/unet/network.h"

enum layer {
    ENC_0,
    ENC_1,
    ENC_2,
    ENC_3,
    ENC_4,
    ENC_5A,
    ENC_5B,
    DEC_4A,
    DEC_4B,
    DEC_3A,
    DEC_3B,
    DEC_2A,
    DEC_2B,
    DEC_1A,
    DEC_1B,
    DEC_0,
};

static const char *const names[NETWORK_LAYERS] = {
    "enc_conv0",  "enc_conv1",  "enc_conv2",  "enc_conv3",  "enc_conv4",  "enc_conv5a",
    "enc_conv5b", "dec_conv4a", "dec_conv4b", "dec_conv3a", "dec_conv3b", "dec_conv2a",
    "dec_conv2b", "dec_conv1a", "dec_conv1b", "dec_conv0"};

#define LEVELS 4 /* of halved sizes */

int network_init(struct network *n, const struct tza *tza, struct fault *fault)
{
    int rc = 0;
    *n = (struct network){0};
    for (int i = 0; i < NETWORK_LAYERS && !rc; i++)
        rc = convolution_init(&n->layers[i], tza, names[i], fault);
    return rc;
}

void network_fini(struct network *n)
{
    for (int i = 0; i < NETWORK_LAYERS; i++) convolution_fini(&n->layers[i]);
}

void network_set_threads(struct network *n, int32_t threads)
{
    for (int i = 0; i < NETWORK_LAYERS; i++) n->layers[i].threads = threads;
}

/* Replaces *t by what a layer makes of it. */
static int apply(const struct network *n, enum layer layer, struct tensor *t)
{
    struct tensor out;
    int rc = convolution_run(&n->layers[layer], t, &out);
    tensor_fini(t);
    *t = out;
    return rc;
}

/* levels[0] is the input; of each further level it is what goes down, and is looked at again. */
static int descend(const struct network *n, struct tensor levels[LEVELS + 1])
{
    struct tensor t;
    int rc = convolution_run(&n->layers[ENC_0], &levels[0], &t);
    for (int i = 1; i <= LEVELS && !rc; i++) {
        if (i == 1)
            rc = apply(n, ENC_1, &t);
        else
            rc = convolution_run(&n->layers[ENC_1 + i - 1], &levels[i - 1], &t);
        if (!rc) rc = tensor_pool(&t, &levels[i]);
    }
    if (rc) tensor_fini(&t);
    return rc;
}

/* Makes *t as large as `beside`, and passes both through two layers. */
static int ascend(const struct network *n, enum layer first, const struct tensor *beside,
                  struct tensor *t)
{
    struct tensor both;
    int rc = tensor_upsample(t, beside, &both);
    *t = both;
    if (!rc) rc = apply(n, first, t);
    if (!rc) rc = apply(n, first + 1, t);
    return rc;
}

int network_run(const struct network *n, const struct tensor *in, struct tensor *out,
                struct fault *fault)
{
    static const enum layer decoders[LEVELS] = {DEC_1A, DEC_2A, DEC_3A, DEC_4A};
    struct tensor levels[LEVELS + 1] = {*in};
    int rc = in->width % NETWORK_MULTIPLE || in->height % NETWORK_MULTIPLE ? ERR_MISMATCH : 0;
    if (!rc) rc = descend(n, levels);
    *out = levels[LEVELS];
    if (!rc) rc = apply(n, ENC_5A, out);
    if (!rc) rc = apply(n, ENC_5B, out);
    for (int i = LEVELS - 1; i >= 0 && !rc; i--) rc = ascend(n, decoders[i], &levels[i], out);
    if (!rc) rc = apply(n, DEC_0, out);
    for (int i = 1; i < LEVELS; i++) tensor_fini(&levels[i]);
    if (!rc) return 0;
    tensor_fini(out);
    return fault_set(fault, rc, "", "the network does not run: %s", error_text(rc));
}
