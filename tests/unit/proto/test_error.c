/* The table of errors: unique, append-only numbers, names and sentences; faults that always end. */
#include <string.h>

#include "proto/error.h"
#include "tests/unit/unit.h"

static const int numbers[] = {
#define ERROR(name, number, text) number,
#include "proto/error.def"
#undef ERROR
};
#define COUNT (sizeof numbers / sizeof *numbers)

TEST(numbers_are_a_sequence)
{
    for (size_t i = 0; i < COUNT; i++) assert_int_equal(numbers[i], -(int)i);
}

/* These travel: a changed number breaks old peers. */
TEST(numbers_stay)
{
    assert_int_equal(ERR_OK, 0);
    assert_int_equal(ERR_INCOMPLETE, -1);
    assert_int_equal(ERR_VERSION, -7);
    assert_int_equal(ERR_MISMATCH, -14);
    assert_int_equal(ERR_FULL, -24);
    assert_int_equal(ERR_NO_SPACE, -25);
    assert_int_equal(ERR_QUOTA, -26);
}

TEST(names_and_sentences)
{
    assert_string_equal(error_name(ERR_RANGE), "RANGE");
    assert_string_equal(error_name(ERR_OK), "OK");
    assert_string_equal(error_name(1), "UNKNOWN");
    assert_string_equal(error_name(-(int)COUNT), "UNKNOWN");
    assert_string_equal(error_text(ERR_CHECKSUM), "the checksum does not match");
    assert_true(strlen(error_text(12345)) > 0);
    for (size_t i = 0; i < COUNT; i++) {
        assert_string_not_equal(error_name(numbers[i]), "UNKNOWN");
        assert_true(strlen(error_text(numbers[i])) > 0);
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(error_name(numbers[i]), error_name(numbers[j]));
    }
}

TEST(fault_is_filled)
{
    struct fault fault;
    int code = fault_set(&fault, ERR_RANGE, "/image/width", "%d is above %d", 20000, 16384);
    assert_int_equal(code, ERR_RANGE);
    assert_int_equal(fault.code, ERR_RANGE);
    assert_string_equal(fault.pointer, "/image/width");
    assert_string_equal(fault.detail, "20000 is above 16384");
    assert_int_equal(fault_set(NULL, ERR_IO, "x", "y"), ERR_IO);
    fault_set(&fault, ERR_IO, NULL, "disk");
    assert_string_equal(fault.pointer, "");
}

TEST(fault_is_terminated)
{
    char text[2000];
    memset(text, 'p', sizeof text);
    text[sizeof text - 1] = '\0';
    struct fault fault;
    fault_set(&fault, ERR_RANGE, text, "%s", text);
    assert_int_equal(strlen(fault.pointer), LIMIT_POINTER_BYTES - 1);
    assert_int_equal(strlen(fault.detail), LIMIT_DETAIL_BYTES - 1);
}

/* Places and sentences go into JSON: a cut must not leave half a character behind. */
TEST(cuts_between_characters)
{
    char text[1200] = "";
    for (size_t i = 0; i < 1199 / 3; i++) memcpy(text + 3 * i, "\xe2\x82\xac", 4);
    struct fault fault;
    for (size_t skip = 0; skip < 3; skip++) {
        fault_set(&fault, ERR_RANGE, text + 3, "%.*s%s", (int)skip, "ab", text);
        size_t length = strlen(fault.detail);
        assert_true(length > LIMIT_DETAIL_BYTES - 4);
        assert_int_equal((length - skip) % 3, 0);
        assert_int_equal(strlen(fault.pointer) % 3, 0);
    }
}
