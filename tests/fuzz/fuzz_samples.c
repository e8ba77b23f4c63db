// sources: tests/unit/proto/plan_case.c
/* The sample buffer, for a plan with every plane. Input: the tile's width and height less one as
 * bytes (modulo 16; the highest bit of the width's asks for a later pass, that of the height's for
 * small packing), then the packed samples. What unpacks must pack and unpack to the same data. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/samples.h"
#include "tests/unit/proto/plan_case.h"

static struct samples *unpack(const uint8_t *data, size_t size_bytes, const struct plan *plan,
                              uint32_t pass, int32_t width, int32_t height)
{
    struct samples *s = NULL;
    struct fault fault = {0};
    const int error = samples_unpack(data, size_bytes, plan, pass, width, height, &s, &fault);
    if ((error == 0) != (s != NULL)) abort();
    if (error && (fault.code != error || fault.detail[0] == '\0')) abort();
    return s;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static struct plan plan;
    struct bytes_writer w;
    if (size_bytes < 2) return 0;
    plan_case(&plan);
    plan.planes |= PLANE_BIT(LENS_SECOND_SET) | PLANE_BIT(LONE);
    const int32_t width = data[0] % 16 + 1, height = data[1] % 16 + 1;
    const uint32_t pass = data[0] >> 7;
    struct samples *s = unpack(data + 2, size_bytes - 2, &plan, pass, width, height);
    if (!s) return 0;
    bytes_writer_init(&w);
    const enum packing packing = data[1] >> 7 ? PACKING_SMALL : PACKING_QUICK;
    if (samples_pack(s, packing, &w, NULL)) abort();
    struct samples *again = unpack(w.data, w.size_bytes, &plan, pass, width, height);
    if (!again || again->layout.total_bytes != s->layout.total_bytes) abort();
    if (memcmp(again->data, s->data, s->layout.total_bytes) != 0) abort();
    if (sparse_list_bytes(again->lone) != sparse_list_bytes(s->lone)) abort();
    if (s->lone && memcmp(again->lone->words, s->lone->words, sparse_list_bytes(s->lone)) != 0)
        abort();
    samples_destroy(&again);
    samples_destroy(&s);
    bytes_writer_fini(&w);
    return 0;
}
