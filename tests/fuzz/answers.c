#include "tests/fuzz/answers.h"

#include <ctype.h>
#include <jansson.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* What is left to read. */
struct rest {
    const char *at, *end;
};

struct head {
    int status;
    bool has_length, has_type, is_chunked, closes, is_problem;
    size_t length_bytes;
};

enum reading { READ_WHOLE, READ_CUT, READ_WRONG };

static size_t left(const struct rest *r)
{
    return (size_t)(r->end - r->at);
}

static enum reading read_line(struct rest *r, struct rest *line)
{
    const char *end = left(r) ? memmem(r->at, left(r), "\r\n", 2) : NULL;
    *line = (struct rest){r->at, end ? end : r->end};
    for (const char *c = line->at; c < line->end; c++)
        if ((unsigned char)*c < 0x20 && *c != '\t' && !(c + 1 == r->end && *c == '\r'))
            return READ_WRONG;
    if (!end) return READ_CUT;
    r->at = end + 2;
    return READ_WHOLE;
}

static bool is_status_line(const struct rest *line, struct head *head)
{
    if (left(line) < 13 || memcmp(line->at, "HTTP/1.", 7) != 0) return false;
    if ((line->at[7] != '0' && line->at[7] != '1') || line->at[8] != ' ' || line->at[12] != ' ')
        return false;
    for (int i = 9; i < 12; i++)
        if (!isdigit((unsigned char)line->at[i])) return false;
    head->status = atoi(line->at + 9);
    head->closes = line->at[7] == '0';
    return head->status >= 100 && head->status < 600;
}

static bool says(const struct rest *value, const char *text)
{
    return left(value) == strlen(text) && strncasecmp(value->at, text, strlen(text)) == 0;
}

static bool read_length(const struct rest *value, struct head *head)
{
    if (head->has_length || left(value) == 0 || left(value) > 18) return false;
    head->has_length = true;
    for (const char *c = value->at; c < value->end; c++) {
        if (!isdigit((unsigned char)*c)) return false;
        head->length_bytes = head->length_bytes * 10 + (size_t)(*c - '0');
    }
    return true;
}

static bool read_field(const struct rest *line, struct head *head)
{
    const char *colon = memchr(line->at, ':', left(line));
    if (!colon || colon == line->at) return false;
    for (const char *c = line->at; c < colon; c++)
        if (!isalnum((unsigned char)*c) && *c != '-') return false;
    const struct rest name = {line->at, colon};
    struct rest value = {colon + 1, line->end};
    while (value.at < value.end && *value.at == ' ') value.at++;
    if (says(&name, "Content-Length")) return read_length(&value, head);
    if (says(&name, "Transfer-Encoding")) {
        if (head->is_chunked || !says(&value, "chunked")) return false;
        head->is_chunked = true;
    }
    if (says(&name, "Connection") && says(&value, "close")) head->closes = true;
    if (says(&name, "Content-Type")) {
        head->has_type = true;
        head->is_problem = says(&value, "application/problem+json");
    }
    return true;
}

static enum reading read_head(struct rest *r, struct head *head)
{
    struct rest line;
    enum reading reading = read_line(r, &line);
    *head = (struct head){0};
    if (reading != READ_WHOLE) return reading;
    if (!is_status_line(&line, head)) return READ_WRONG;
    while ((reading = read_line(r, &line)) == READ_WHOLE && left(&line) > 0)
        if (!read_field(&line, head)) return READ_WRONG;
    return reading == READ_WHOLE && head->has_length && head->is_chunked ? READ_WRONG : reading;
}

static enum reading read_chunks(struct rest *r)
{
    for (;;) {
        struct rest line;
        size_t bytes = 0;
        enum reading reading = read_line(r, &line);
        if (reading != READ_WHOLE) return reading;
        if (left(&line) == 0 || left(&line) > 8) return READ_WRONG;
        for (const char *c = line.at; c < line.end; c++) {
            if (!isxdigit((unsigned char)*c)) return READ_WRONG;
            bytes =
                bytes * 16 + (size_t)(isdigit((unsigned char)*c) ? *c - '0' : (*c | 32) - 'a' + 10);
        }
        if (left(r) < bytes) return READ_CUT;
        r->at += bytes;
        if ((reading = read_line(r, &line)) != READ_WHOLE) return reading;
        if (left(&line) > 0) return READ_WRONG; /* more than the chunk's bytes, or a trailer */
        if (bytes == 0) return READ_WHOLE;
    }
}

static bool is_problem(const char *text, size_t size_bytes, int status)
{
    json_t *body = json_loadb(text, size_bytes, 0, NULL);
    const bool holds = json_integer_value(json_object_get(body, "status")) == status &&
                       json_is_string(json_object_get(body, "type")) &&
                       json_is_string(json_object_get(body, "title"));
    json_decref(body);
    return holds;
}

static bool begins_anew(const struct rest *r)
{
    return left(r) == 0 || (left(r) >= 7 && memcmp(r->at, "HTTP/1.", 7) == 0);
}

static enum reading read_body(struct rest *r, const struct head *head, bool may_lack_it)
{
    if (head->status < 200 || head->status == 204 || head->status == 304) return READ_WHOLE;
    if (may_lack_it && begins_anew(r)) return READ_WHOLE;
    if (head->is_chunked) return read_chunks(r);
    if (!head->has_length) {
        if (!head->closes) return READ_WRONG;
        r->at = r->end;
        return READ_WHOLE;
    }
    if (left(r) < head->length_bytes) return READ_CUT;
    if (head->is_problem && !is_problem(r->at, head->length_bytes, head->status)) return READ_WRONG;
    r->at += head->length_bytes;
    return READ_WHOLE;
}

/* libmicrohttpd 0.9.75 sends the head of an answer of its own twice where it refuses a field that
 * it reads itself, such as a Content-Length that is no number; then it closes. */
static void pass_head_again(struct rest *r, const struct head *head, const char *begin)
{
    const size_t bytes = (size_t)(r->at - begin);
    if (head->closes && !head->has_type && left(r) >= bytes && memcmp(begin, r->at, bytes) == 0)
        r->at += bytes;
}

bool answers_are_whole(const char *text, size_t size_bytes, bool may_lack_bodies, bool may_be_cut)
{
    if (size_bytes == 0) return true;
    struct rest r = {text, text + size_bytes};
    while (left(&r) > 0) {
        struct head head;
        const char *begin = r.at;
        enum reading reading = read_head(&r, &head);
        if (reading == READ_WHOLE) pass_head_again(&r, &head, begin);
        if (reading == READ_WHOLE) reading = read_body(&r, &head, may_lack_bodies);
        if (reading != READ_WHOLE) return reading == READ_CUT && may_be_cut;
        if (head.closes && left(&r) > 0) return false; /* nothing may follow */
    }
    return true;
}
