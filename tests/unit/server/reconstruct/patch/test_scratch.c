/* Memory that is taken and given back: kept, aligned, of the size that was asked for. */
#include <string.h>

#include "server/reconstruct/patch/scratch.h"
#include "tests/unit/unit.h"

TEST(keeps_what_comes_back)
{
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

TEST(every_byte_is_there)
{
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

/* The largest pieces go first, and none that is out. */
TEST(holds_no_more_than_asked)
{
    struct scratch *scratch;
    assert_int_equal(scratch_create(&scratch), 0);
    uint8_t *out = scratch_take(scratch, 6000000), *small = scratch_take(scratch, 1000);
    scratch_give(scratch, scratch_take(scratch, 3000000));
    scratch_give(scratch, small);
    scratch_trim(scratch, 100000);
    assert_ptr_equal(scratch_take(scratch, 1000), small);
    memset(out, 0xff, 6000000);
    scratch_give(scratch, small);
    scratch_give(scratch, out);
    scratch_trim(scratch, SIZE_MAX);
    assert_ptr_equal(scratch_take(scratch, 6000000), out);
    scratch_give(scratch, out);
    scratch_trim(scratch, 0);
    scratch_trim(scratch, 0);
    scratch_destroy(&scratch);
}

/* The same sizes over and over, in another order each time: soon nothing new is needed. */
TEST(comes_to_rest)
{
    struct scratch *scratch;
    void *pieces[5], *known[5] = {0};
    size_t count = 0;
    assert_int_equal(scratch_create(&scratch), 0);
    for (size_t turn = 0; turn < 100; turn++) {
        for (size_t i = 0; i < 5; i++)
            pieces[i] = scratch_take(scratch, (size_t)1000 << (i * turn % 7));
        for (size_t i = 0; i < 5; i++) scratch_give(scratch, pieces[i]);
        if (turn < 50) continue;
        for (size_t i = 0; i < 5; i++) {
            size_t k = 0;
            while (k < count && known[k] != pieces[i]) k++;
            assert_true(k < 5);
            if (k == count) known[count++] = pieces[i];
        }
    }
    scratch_destroy(&scratch);
}
