/* traceparent as it comes from outside (W3C Trace Context, section 3.2). */
#include <string.h>

#include "proto/log/trace_context.h"
#include "tests/unit/unit.h"

#define ID   "4bf92f3577b34da6a3ce929d0e0e4736"
#define SPAN "00f067aa0ba902b7"

TEST(valid)
{
    static const struct {
        const char *header;
        bool sampled;
    } cases[] = {
        {"00-" ID "-" SPAN "-01", true},      {"00-" ID "-" SPAN "-00", false},
        {"00-" ID "-" SPAN "-ff", true},      {"00-" ID "-" SPAN "-0a", false},
        {"01-" ID "-" SPAN "-01-more", true}, {"fe-" ID "-" SPAN "-01", true},
    };
    struct trace_context_source source = {7};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct trace_context t;
        trace_context_begin(&source, cases[i].header, &t);
        assert_string_equal(t.id, ID);
        assert_string_equal(t.parent, SPAN);
        assert_int_equal(t.sampled, cases[i].sampled);
        assert_int_equal(strlen(t.request), 16);
        assert_string_not_equal(t.request, SPAN);
    }
}

TEST(invalid)
{
    static const char *const cases[] = {
        NULL,
        "",
        "00",
        "00-" ID "-" SPAN "-0",
        "00-" ID "-" SPAN "-01-more",
        "00-" ID "-" SPAN "-011",
        "01-" ID "-" SPAN "-01more",
        "ff-" ID "-" SPAN "-01",
        "0g-" ID "-" SPAN "-01",
        "00_" ID "-" SPAN "-01",
        "00-" ID "_" SPAN "-01",
        "00-" ID "-" SPAN "_01",
        "00-" ID "-" SPAN "-0g",
        "00-4BF92f3577b34da6a3ce929d0e0e4736-" SPAN "-01",
        "00-4bf92f3577b34da6a3ce929d0e0e473\n-" SPAN "-01",
        "00-00000000000000000000000000000000-" SPAN "-01",
        "00-" ID "-0000000000000000-01",
        "00-" ID "-00F067aa0ba902b7-01",
        " 00-" ID "-" SPAN "-01",
        "\xff\xfe\"\n",
    };
    struct trace_context_source source = {7};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct trace_context t;
        trace_context_begin(&source, cases[i], &t);
        assert_string_not_equal(t.id, ID);
        assert_int_equal(strspn(t.id, "0123456789abcdef"), 32);
        assert_string_equal(t.parent, "");
        assert_false(t.sampled);
    }
}

TEST(goes_on)
{
    struct trace_context_source source = {1};
    struct trace_context first, second;
    char header[TRACE_CONTEXT_PARENT_BYTES];
    trace_context_begin(&source, "00-" ID "-" SPAN "-01", &first);
    trace_context_write(&first, header);
    assert_int_equal(strlen(header), 55);
    trace_context_begin(&source, header, &second);
    assert_string_equal(second.id, ID);
    assert_string_equal(second.parent, first.request);
    assert_true(second.sampled);
    assert_string_not_equal(second.request, first.request);
}

TEST(is_kept)
{
    struct trace_context_source source = {3};
    struct trace_context begun, continued, none = {0}, back;
    char text[TRACE_CONTEXT_TEXT_BYTES];
    trace_context_begin(&source, NULL, &begun);
    trace_context_begin(&source, "00-" ID "-" SPAN "-01", &continued);
    const struct trace_context *all[] = {&begun, &continued};
    for (size_t i = 0; i < 2; i++) {
        trace_context_keep(all[i], text);
        assert_int_equal(strlen(text), i ? 72 : 55);
        assert_true(trace_context_kept(text, &back));
        assert_memory_equal(&back, all[i], sizeof back);
    }
    trace_context_keep(&none, text);
    assert_string_equal(text, "");
    static const char *const wrong[] = {"",
                                        "x",
                                        "00-" ID "-" SPAN "-0",
                                        "00-" ID "-" SPAN "-01-",
                                        "01-" ID "-" SPAN "-01",
                                        "00-" ID "-" SPAN "-01-0000000000000000",
                                        "00-" ID "-" SPAN "-01-00f067aa0ba902bg",
                                        "00-" ID "-" SPAN "-01_" SPAN,
                                        "00-" ID "-" SPAN "-01-" SPAN "0",
                                        "00-" ID "-0000000000000000-01"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_false(trace_context_kept(wrong[i], &back));
        assert_memory_equal(&back, &none, sizeof back);
    }
}
