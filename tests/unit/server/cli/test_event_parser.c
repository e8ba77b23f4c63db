/* Server-Sent Events: the same events whatever the pieces that the bytes come in. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "server/cli/client/event_parser.h"
#include "tests/unit/proto/json_memory.h"
#include "tests/unit/unit.h"

struct seen {
    char text[512];
    int stop_after;
    int count;
};

static bool note(void *ctx, const char *name, const json_t *data)
{
    struct seen *seen = ctx;
    char *json = json_dumps(data, JSON_COMPACT | JSON_ENCODE_ANY);
    size_t used = strlen(seen->text);
    snprintf(seen->text + used, sizeof seen->text - used, "%s=%s;", name, json ? json : "none");
    free(json);
    return ++seen->count != seen->stop_after;
}

static const char stream[] = ": hello\n\n"
                             "id: 7\nevent: state\ndata: {\"state\":\"running\"}\n\n"
                             "event:progress\r\ndata:{\"fraction\":\r\ndata:0.5}\r\n\r\n"
                             "retry: 100\n\n"
                             "data: 1\n\n";
static const char expected[] =
    "state={\"state\":\"running\"};progress={\"fraction\":0.5};message=1;";

ALL_TESTS(fail_when_told, fail_no_more);

TEST(test_any_pieces)
{
    for (size_t piece = 1; piece <= sizeof stream - 1; piece++) {
        struct seen seen = {0};
        struct event_parser parser;
        event_parser_init(&parser, note, &seen);
        for (size_t at = 0; at < sizeof stream - 1; at += piece) {
            size_t n = sizeof stream - 1 - at < piece ? sizeof stream - 1 - at : piece;
            assert_true(event_parser_feed(&parser, stream + at, n));
        }
        assert_string_equal(seen.text, expected);
        assert_string_equal(parser.last_id, "7");
        assert_int_equal(parser.events, 3);
        event_parser_fini(&parser);
    }
}

TEST(test_stop)
{
    struct seen seen = {.stop_after = 1};
    struct event_parser parser;
    event_parser_init(&parser, note, &seen);
    assert_false(event_parser_feed(&parser, stream, sizeof stream - 1));
    assert_true(parser.stopped);
    assert_int_equal(seen.count, 1);
    event_parser_fini(&parser);
}

static bool feed(struct event_parser *parser, const char *text)
{
    return event_parser_feed(parser, text, strlen(text));
}

/* What has not been seen whole is asked for again. */
TEST(test_restart_forgets_the_unfinished)
{
    struct seen seen = {0};
    struct event_parser parser;
    event_parser_init(&parser, note, &seen);
    assert_true(feed(&parser, "id: 2\ndata: 1\n\n"));
    assert_true(feed(&parser, "id: 3\nevent: state\ndata: {\"a\""));
    assert_string_equal(parser.last_id, "2");
    event_parser_restart(&parser);
    assert_true(feed(&parser, "data: 2\n\n"));
    assert_string_equal(seen.text, "message=1;message=2;");
    assert_string_equal(parser.last_id, "2");
    assert_true(feed(&parser, "id: 4\n\n")); /* without data, seen as well */
    assert_string_equal(parser.last_id, "4");
    event_parser_fini(&parser);
}

TEST(test_no_json_is_no_data)
{
    struct seen seen = {0};
    struct event_parser parser;
    event_parser_init(&parser, note, &seen);
    assert_true(feed(&parser, "id: 1\ndata: {\"a\":1,\"a\":2}\n\ndata: {\n\n"));
    assert_string_equal(seen.text, "message=none;message=none;");
    assert_int_equal(parser.error, 0);
    assert_string_equal(parser.last_id, "1");
    event_parser_fini(&parser);
}

/* 16 MiB in one event, of lines that are each within it. */
TEST(test_an_event_is_not_endless)
{
    enum { LINE = 1 << 20 };
    int seen = 0;
    struct event_parser parser;
    char *line = malloc(LINE + 1);
    memset(line, '7', LINE);
    memcpy(line, "data:", 5);
    line[LINE - 1] = '\n';
    line[LINE] = '\0';
    event_parser_init(&parser, NULL, &seen);
    int lines = 0;
    while (lines < 20 && feed(&parser, line)) lines++;
    assert_int_equal(lines, 16);
    assert_int_equal(parser.error, ERR_LIMIT);
    event_parser_restart(&parser);
    assert_int_equal(parser.error, 0);
    event_parser_fini(&parser);
    free(line);
}

static bool count(void *ctx, const char *name, const json_t *data)
{
    (void)name;
    assert_non_null(data);
    ++*(int *)ctx;
    return true;
}

/* The server is asked for it again. */
TEST(test_no_event_without_its_data)
{
    static const char text[] =
        "id: 5\ndata: {\"state\":\"a string that is a long one, of more than thirty bytes\"}\n\n";
    unsigned k = 0;
    bool fed;
    do {
        int seen = 0;
        struct event_parser parser;
        event_parser_init(&parser, count, &seen);
        until_failure = ++k;
        fed = event_parser_feed(&parser, text, sizeof text - 1);
        assert_int_equal(fed, until_failure > 0); /* it did not come to that */
        until_failure = 0;
        assert_int_equal(seen, fed);
        assert_string_equal(parser.last_id, fed ? "5" : "");
        assert_int_equal(parser.error, fed ? 0 : ERR_MEMORY);
        assert_false(parser.stopped);
        event_parser_fini(&parser);
    } while (!fed);
    assert_true(k > 5);
}
