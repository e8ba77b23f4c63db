#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "proto/runtime/pages.h"
#include "tests/unit/unit.h"

enum { PIECES = 40 };
#define MEGABYTE ((size_t)1 << 20)

static size_t size_of(size_t k)
{
    static const size_t sizes[] = {
        1, 63, 64, 5000, (size_t)1 << 20, (size_t)3 << 20, (size_t)9 << 20};
    return sizes[k % (sizeof sizes / sizeof sizes[0])];
}

static bool holds(const uint8_t *piece, size_t size_bytes, uint8_t value)
{
    return piece[0] == value && memcmp(piece, piece + 1, size_bytes - 1) == 0;
}

TEST(pieces_lie_apart)
{
    uint8_t *pieces[PIECES];
    for (size_t k = 0; k < PIECES; k++) {
        pieces[k] = pages_take(size_of(k));
        memset(pieces[k], (int)k, size_of(k));
    }
    bool apart = true, aligned = true;
    for (size_t k = 0; k < PIECES; k++) {
        apart &= holds(pieces[k], size_of(k), (uint8_t)k);
        aligned &= (uintptr_t)pieces[k] % 64 == 0;
    }
    assert_true(apart);
    assert_true(aligned);
    for (size_t k = 0; k < PIECES; k += 2) pages_give(pieces[k]);
    for (size_t k = 1; k < PIECES; k += 2) apart &= holds(pieces[k], size_of(k), (uint8_t)k);
    assert_true(apart);
    for (size_t k = 1; k < PIECES; k += 2) pages_give(pieces[k]);
}

TEST(what_was_given_back_is_taken_again)
{
    void *first = pages_take(MEGABYTE);
    pages_give(first);
    bool same = true;
    for (int k = 0; k < 100; k++) {
        void *next = pages_take(MEGABYTE);
        same &= next == first;
        pages_give(next);
    }
#ifdef __SANITIZE_ADDRESS__ /* which keeps what was freed apart */
    same = true;
#endif
    assert_true(same);
}

TEST(too_much_is_none)
{
    assert_null(pages_take(SIZE_MAX));
    assert_null(pages_take(SIZE_MAX - 100));
    pages_give(NULL);
}

static void *take_many(void *value)
{
    const uint8_t own = *(const uint8_t *)value;
    bool all = true;
    for (size_t k = 0; k < 2000; k++) {
        const size_t size_bytes = size_of(k % 4);
        uint8_t *piece = pages_take(size_bytes);
        memset(piece, own, size_bytes);
        all &= holds(piece, size_bytes, own);
        pages_give(piece);
    }
    return all ? value : NULL;
}

TEST(threads_share_them)
{
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    uint8_t own[THREADS];
    void *kept = NULL;
    for (uint8_t t = 0; t < THREADS; t++) {
        own[t] = (uint8_t)(10 + t);
        assert_int_equal(pthread_create(&threads[t], NULL, take_many, &own[t]), 0);
    }
    for (int t = 0; t < THREADS; t++) {
        pthread_join(threads[t], &kept);
        assert_ptr_equal(kept, &own[t]);
    }
}
