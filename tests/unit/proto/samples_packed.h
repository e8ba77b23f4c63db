#pragma once
/* Sample buffers of a plan, packed in one way or the other, and unpacked. */
#include <string.h>

#include "tests/unit/proto/samples_case.h"
#include "tests/unit/unit.h"

static struct plan plan;
static enum packing packing = PACKING_QUICK; /* all is tried with each */
static const int32_t sizes[][2] = {{1, 1}, {7, 3}, {64, 64}, {33, 1}, {1, 19}};
#define SIZES (sizeof sizes / sizeof sizes[0])

#define BIT(plane) PLANE_BIT(plane)

static inline struct samples *create_pass(uint32_t pass, int32_t width, int32_t height)
{
    struct samples_layout layout;
    struct samples *s;
    assert_int_equal(samples_layout_init(&layout, &plan, pass, width, height), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    assert_int_equal((uintptr_t)s->data % 64, 0);
    return s;
}

static inline struct samples *create(int32_t width, int32_t height)
{
    return create_pass(0, width, height);
}

static inline void pack(struct samples *s, struct bytes_writer *w, uint64_t *dropped)
{
    bytes_writer_init(w);
    assert_int_equal(samples_pack(s, packing, w, dropped), 0);
    assert_false(w->failed);
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static inline int unpack_pass(const uint8_t *data, size_t size_bytes, uint32_t pass, int32_t width,
                              int32_t height, struct samples **out, struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    *out = NULL;
    const int error = samples_unpack(exact, size_bytes, &plan, pass, width, height, out, fault);
    assert_true((error == 0) == (*out != NULL));
    free(exact);
    return error;
}

static inline int unpack(const uint8_t *data, size_t size_bytes, int32_t width, int32_t height,
                         struct samples **out, struct fault *fault)
{
    return unpack_pass(data, size_bytes, 0, width, height, out, fault);
}
