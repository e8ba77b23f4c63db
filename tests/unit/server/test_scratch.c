/* Memory that is taken and given back: kept, aligned, of the size that was asked for. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "server/reconstruct/scratch.h"

static void keeps_what_comes_back(void **state)
{
    (void)state;
    struct scratch *scratch;
    assert_int_equal(scratch_create(&scratch), 0);
    uint8_t *large = scratch_take(scratch, 3000000), *small = scratch_take(scratch, 1000);
    assert_non_null(large);
    assert_non_null(small);
    assert_ptr_not_equal(large, small);
    scratch_give(scratch, large);
    scratch_give(scratch, small);
    assert_ptr_equal(scratch_take(scratch, 2900000), large);
    assert_ptr_equal(scratch_take(scratch, 900), small);
    uint8_t *other = scratch_take(scratch, 900); /* the kept ones are out */
    assert_ptr_not_equal(other, small);
    scratch_give(scratch, other);
    scratch_give(scratch, small);
    scratch_give(scratch, large);
    scratch_destroy(&scratch);
    assert_null(scratch);
}

/* A small piece must not hold on to a large one. */
static void wastes_little(void **state)
{
    (void)state;
    struct scratch *scratch;
    assert_int_equal(scratch_create(&scratch), 0);
    void *large = scratch_take(scratch, 1 << 20);
    scratch_give(scratch, large);
    void *small = scratch_take(scratch, 100);
    assert_ptr_not_equal(small, large);
    scratch_give(scratch, small);
    scratch_destroy(&scratch);
}

static void every_byte_is_there(void **state)
{
    (void)state;
    struct scratch *scratch;
    assert_int_equal(scratch_create(&scratch), 0);
    struct scratch *const from[2] = {NULL, scratch};
    for (size_t bytes = 0; bytes < 5000000; bytes = 3 * bytes + 1) {
        for (int i = 0; i < 2; i++) {
            uint8_t *memory = scratch_take(from[i], bytes);
            assert_non_null(memory);
            assert_int_equal((uintptr_t)memory % 64, 0);
            memset(memory, 0xff, bytes);
            scratch_give(from[i], memory);
        }
    }
    assert_null(scratch_take(scratch, SIZE_MAX - 3));
    assert_null(scratch_take(NULL, SIZE_MAX - 3));
    scratch_give(scratch, NULL);
    scratch_destroy(&scratch);
    scratch_destroy(&scratch);
}

/* Many pieces given back at once do not pile up without end. */
static void forgets_the_oldest_habits(void **state)
{
    (void)state;
    struct scratch *scratch;
    void *pieces[200];
    assert_int_equal(scratch_create(&scratch), 0);
    for (size_t i = 0; i < 200; i++) pieces[i] = scratch_take(scratch, 64 * (i + 1));
    for (size_t i = 0; i < 200; i++) scratch_give(scratch, pieces[i]);
    for (size_t i = 0; i < 200; i++) {
        void *memory = scratch_take(scratch, 1000000 * (i % 3 + 1));
        assert_non_null(memory);
        scratch_give(scratch, memory);
    }
    scratch_destroy(&scratch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_what_comes_back),
        cmocka_unit_test(wastes_little),
        cmocka_unit_test(every_byte_is_there),
        cmocka_unit_test(forgets_the_oldest_habits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
