/* Problem documents (RFC 9457), and which fault becomes which. */
#include <string.h>

#include "server/http/problem.h"
#include "tests/unit/unit.h"

static const char *text(const json_t *body, const char *name)
{
    return json_string_value(json_object_get(body, name));
}

TEST(members)
{
    json_t *body = problem_json(PROBLEM_INVALID, "width is 0", "/image/width");
    assert_string_equal(text(body, "type"), "urn:shearwater:problem:invalid-document");
    assert_string_equal(text(body, "title"), "The document cannot be accepted");
    assert_int_equal(json_integer_value(json_object_get(body, "status")), 422);
    assert_string_equal(text(body, "detail"), "width is 0");
    assert_string_equal(text(body, "pointer"), "/image/width");
    json_decref(body);
    body = problem_json(PROBLEM_NOT_FOUND, NULL, "");
    assert_int_equal(json_object_size(body), 3);
    json_decref(body);
}

TEST(details_that_are_no_utf8)
{
    json_t *body = problem_json(PROBLEM_INVALID, "cut \xc3", "/\xff/a");
    assert_string_equal(text(body, "detail"), "cut ?");
    assert_string_equal(text(body, "pointer"), "/?/a");
    json_decref(body);
}

TEST(slugs_are_unique)
{
    for (int i = 0; i < PROBLEM_COUNT; i++) {
        const struct problem *p = problem_of((enum problem_id)i);
        assert_true(p->status >= 400 && p->status < 600);
        assert_int_equal(strspn(p->slug, "abcdefghijklmnopqrstuvwxyz-"), strlen(p->slug));
        for (int j = 0; j < i; j++)
            assert_string_not_equal(p->slug, problem_of((enum problem_id)j)->slug);
    }
}

TEST(faults)
{
    static const struct {
        int code;
        const char *pointer;
        enum problem_id problem;
    } cases[] = {
        {ERR_SYNTAX, "", PROBLEM_SYNTAX},
        {ERR_SYNTAX, "/scene/asset", PROBLEM_INVALID},
        {ERR_LIMIT, "", PROBLEM_SYNTAX},
        {ERR_LIMIT, "/lights", PROBLEM_INVALID},
        {ERR_TYPE, "", PROBLEM_INVALID},
        {ERR_UNKNOWN_MEMBER, "/x", PROBLEM_INVALID},
        {ERR_UNSUPPORTED, "/lens", PROBLEM_INVALID},
        {ERR_NOT_FOUND, "/scene/asset", PROBLEM_MISSING_ASSET},
        {ERR_MISMATCH, "", PROBLEM_KEY_REUSED},
        {ERR_MISMATCH, "/scene/asset", PROBLEM_INVALID},
        {ERR_FULL, "", PROBLEM_BUSY},
        {ERR_MEMORY, "", PROBLEM_OUT_OF_MEMORY},
        {ERR_IO, "", PROBLEM_STORAGE},
        {ERR_NO_SPACE, "", PROBLEM_DISK_FULL},
        {ERR_STATE, "", PROBLEM_DRAINING},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct fault fault = {.code = cases[i].code};
        strcpy(fault.pointer, cases[i].pointer);
        assert_int_equal(problem_of_document(&fault), cases[i].problem);
    }
}
