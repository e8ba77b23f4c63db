/* Formats one line of the log from untrusted bytes. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "proto/log/log.h"

#define END_BYTES 4 /* more than the longest end: "\"}\n" */

/* What does not fit is left out, a character at a time; `full` holds from then on. */
struct line {
    char *out;
    size_t used;
    bool full;
};

static void put(struct line *l, const char *text, size_t n)
{
    l->full |= l->used + n > LOG_LINE_BYTES - END_BYTES;
    if (l->full) return;
    memcpy(l->out + l->used, text, n);
    l->used += n;
}

static void put_text(struct line *l, const char *text)
{
    put(l, text, strlen(text));
}

/* Bytes of the UTF-8 character at `at` (RFC 3629); 0: it is none. */
static size_t utf8_size(const unsigned char *at)
{
    const size_t n = at[0] < 0x80                    ? 1
                     : at[0] >= 0xc2 && at[0] < 0xe0 ? 2
                     : at[0] >= 0xe0 && at[0] < 0xf0 ? 3
                     : at[0] >= 0xf0 && at[0] < 0xf5 ? 4
                                                     : 0;
    for (size_t i = 1; i < n; i++)
        if ((at[i] & 0xc0) != 0x80) return 0;
    if ((at[0] == 0xe0 && at[1] < 0xa0) || (at[0] == 0xed && at[1] > 0x9f) ||
        (at[0] == 0xf0 && at[1] < 0x90) || (at[0] == 0xf4 && at[1] > 0x8f))
        return 0;
    return n;
}

/* C1 controls move the cursor of some terminals as C0 do. */
static bool is_control(const unsigned char *at, size_t n)
{
    return (n == 1 && (at[0] < 0x20 || at[0] == 0x7f)) || (n == 2 && at[0] == 0xc2 && at[1] < 0xa0);
}

/* Escapes text as inside a JSON string. With `quotes`, quotes and backslashes are escaped, too. */
static void put_escaped(struct line *l, const char *text, bool quotes)
{
    char code[8];
    for (const unsigned char *at = (const unsigned char *)text; *at && !l->full;) {
        const size_t n = utf8_size(at);
        if (n == 0) {
            put_text(l, "\\ufffd");
        } else if (is_control(at, n)) {
            snprintf(code, sizeof code, "\\u%04x", n == 2 ? at[1] : at[0]);
            put_text(l, code);
        } else {
            const bool marked = quotes && (*at == '"' || *at == '\\');
            snprintf(code, sizeof code, "%s%.*s", marked ? "\\" : "", (int)n, at);
            put_text(l, code);
        }
        at += n ? n : 1;
    }
}

static bool needs_quotes(const char *text)
{
    for (const unsigned char *at = (const unsigned char *)text; *at; at++)
        if (*at <= 0x20 || *at >= 0x7f || strchr("\"\\=", *at)) return true;
    return false;
}

/* Puts the end of a line, for which END_BYTES are reserved even if the line was cut. */
static void put_closed(struct line *l, const char *text)
{
    put_escaped(l, text, true);
    l->out[l->used++] = '"';
}

static void put_number(struct line *l, double number)
{
    char text[32];
    const bool whole = fabs(number) < 9e15 && number == floor(number);
    snprintf(text, sizeof text, whole ? "%.0f" : "%.6g", number);
    put_text(l, isfinite(number) ? text : "null");
}

static void put_json(struct line *l, const struct log_field *f)
{
    const size_t before = l->used;
    put_text(l, ",\"");
    put_text(l, f->key);
    put_text(l, f->text ? "\":\"" : "\":");
    if (f->text && !l->full) {
        put_closed(l, f->text);
        return;
    }
    if (!f->text) put_number(l, f->number);
    if (l->full) l->used = before;
}

static void put_plain(struct line *l, const struct log_field *f)
{
    put_text(l, " ");
    if (f->text && !strcmp(f->key, "detail")) {
        put_escaped(l, f->text, false);
        return;
    }
    const bool quoted = f->text && needs_quotes(f->text);
    put_text(l, f->key);
    put_text(l, quoted ? "=\"" : "=");
    if (quoted && !l->full)
        put_closed(l, f->text);
    else if (!quoted && f->text)
        put_text(l, f->text);
    else if (!quoted)
        put_number(l, f->number);
}

static void put_field(struct line *l, enum log_format format, const struct log_field *f)
{
    if (l->full || (f->text && !f->text[0])) return;
    if (format == LOG_JSON)
        put_json(l, f);
    else
        put_plain(l, f);
}

static void put_head(struct line *l, enum log_format format, int64_t at_ms, enum log_level level,
                     const char *what)
{
    char at[40];
    struct tm parts = {0};
    const time_t seconds = (time_t)(at_ms / 1000);
    gmtime_r(&seconds, &parts);
    const size_t n = strftime(at, sizeof at, "%Y-%m-%dT%H:%M:%S", &parts);
    snprintf(at + n, sizeof at - n, ".%03dZ", (int)(at_ms % 1000));
    put_text(l, format == LOG_JSON ? "{\"time\":\"" : "");
    put_text(l, at);
    put_text(l, format == LOG_JSON ? "\",\"level\":\"" : " ");
    put_text(l, log_level_name(level));
    put_text(l, format == LOG_JSON ? "\",\"message\":\"" : " ");
    put_escaped(l, what, format == LOG_JSON);
    put_text(l, format == LOG_JSON ? "\"" : "");
}

size_t log_line(enum log_format format, int64_t at_ms, enum log_level level, const char *what,
                const struct trace_context *trace, const struct log_field *fields, size_t count,
                char out[LOG_LINE_BYTES])
{
    struct line l = {.out = out};
    put_head(&l, format, at_ms, level, what);
    if (trace) {
        put_field(&l, format, &(struct log_field){"request", trace->request, 0});
        put_field(&l, format, &(struct log_field){"trace", trace->id, 0});
        put_field(&l, format, &(struct log_field){"parent", trace->parent, 0});
    }
    for (size_t i = 0; i < count; i++) put_field(&l, format, &fields[i]);
    if (format == LOG_JSON) out[l.used++] = '}';
    out[l.used++] = '\n';
    return l.used;
}
