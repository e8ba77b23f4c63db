/* Byte ranges and entity tags (RFC 9110, sections 8.8 and 14). */
#include "server/http/etag.h"
#include "server/http/range.h"
#include "tests/unit/unit.h"

TEST(ranges)
{
    static const struct {
        const char *header;
        uint64_t file_bytes;
        enum range_kind kind;
        uint64_t first_byte, size_bytes;
    } cases[] = {
        {NULL, 10, RANGE_WHOLE, 0, 10},
        {"bytes=0-0", 10, RANGE_PART, 0, 1},
        {"bytes=0-9", 10, RANGE_PART, 0, 10},
        {"Bytes=2-", 10, RANGE_PART, 2, 8},
        {"bytes=2-99", 10, RANGE_PART, 2, 8},
        {"bytes=-3", 10, RANGE_PART, 7, 3},
        {"bytes=-30", 10, RANGE_PART, 0, 10},
        {"bytes=9-99999999999999999999999", 10, RANGE_PART, 9, 1},
        {"bytes=10-", 10, RANGE_UNSATISFIABLE, 0, 0},
        {"bytes=99999999999999999999999-", 10, RANGE_UNSATISFIABLE, 0, 0},
        {"bytes=-0", 10, RANGE_UNSATISFIABLE, 0, 0},
        {"bytes=0-", 0, RANGE_UNSATISFIABLE, 0, 0},
        {"bytes=-5", 0, RANGE_UNSATISFIABLE, 0, 0},
        {"bytes=5-2", 10, RANGE_WHOLE, 0, 10},
        {"bytes=", 10, RANGE_WHOLE, 0, 10},
        {"bytes=-", 10, RANGE_WHOLE, 0, 10},
        {"bytes=x-2", 10, RANGE_WHOLE, 0, 10},
        {"bytes=0-1,4-5", 10, RANGE_WHOLE, 0, 10},
        {"lines=0-1", 10, RANGE_WHOLE, 0, 10},
        {"bytes=0 - 1", 10, RANGE_WHOLE, 0, 10},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct range r = range_read(cases[i].header, cases[i].file_bytes);
        assert_int_equal(r.kind, cases[i].kind);
        if (r.kind == RANGE_UNSATISFIABLE) continue;
        assert_int_equal(r.first_byte, cases[i].first_byte);
        assert_int_equal(r.size_bytes, cases[i].size_bytes);
    }
}

TEST(tags)
{
    assert_true(etag_listed("*", "\"a\""));
    assert_true(etag_listed("\"a\"", "\"a\""));
    assert_true(etag_listed("\"x\", W/\"a\" ,\"y\"", "\"a\""));
    assert_false(etag_listed("\"x\", \"y\"", "\"a\""));
    assert_true(etag_matches("*", "\"a\""));
    assert_true(etag_matches("W/\"a\", \"a\"", "\"a\""));
    assert_false(etag_matches("W/\"a\"", "\"a\""));
    assert_false(etag_matches("\"b\", a", "\"a\""));
    assert_false(etag_listed("a", "\"a\""));
    assert_false(etag_listed("\"a", "\"a\""));
    assert_false(etag_listed("", "\"a\""));
    assert_false(etag_listed("\"ab\"", "\"a\""));
    char tag[ETAG_BYTES];
    etag_of_bytes("", 0, tag);
    assert_string_equal(tag,
                        "\"e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855\"");
}
