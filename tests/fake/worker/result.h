#pragma once
/* Results of the fake worker: samples that hold nothing, validly packed, or that lie. */
#include "tests/fake/worker/fake.h"

enum lie {
    LIE_NONE,
    LIE_NAN,  /* a sample that is not finite */
    LIE_LONE, /* lone sub-samples out of order, or with light that is not finite */
};

/* Leaves `out`, which the caller frees, empty where the tile's frame is not known. */
void result_pack(struct fake *f, const struct message_tile *tile, int32_t width, int32_t height,
                 enum lie lie, struct bytes_writer *out);
/* Belongs to the fake, until the next call. */
const struct bytes_writer *result_zero_samples(struct fake *f, const struct message_tile *tile);
void result_send(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                 const struct bytes_writer *packed);
/* The frame of a right result, byte by byte, which the caller frees. */
void result_whole(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                  struct bytes_writer *whole);
