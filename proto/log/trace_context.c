#include "proto/log/trace_context.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

/* version-trace-parent-flags */
enum { AT_TRACE = 3, AT_PARENT = 36, AT_FLAGS = 53, SIZE = 55 };

void trace_context_source_init(struct trace_context_source *source)
{
    struct timespec now;
    if (getrandom(&source->state, sizeof source->state, 0) == sizeof source->state) return;
    clock_gettime(CLOCK_REALTIME, &now);
    source->state = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    source->state ^= (uint64_t)getpid() << 40;
}

/* SplitMix64 (Steele, Lea, Flood 2014); an id of zeros would be none. */
static uint64_t next(struct trace_context_source *source)
{
    uint64_t x;
    do {
        x = source->state += 0x9e3779b97f4a7c15u;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        x ^= x >> 31;
    } while (x == 0);
    return x;
}

/* Capital letters are not valid in the header. */
static bool is_hex(const char *text, size_t digits)
{
    return strspn(text, "0123456789abcdef") >= digits;
}

static bool is_zero(const char *text, size_t digits)
{
    return strspn(text, "0") >= digits;
}

/* A later version may go on after what this one knows, behind another dash. */
static bool is_valid(const char *header)
{
    const size_t size = strnlen(header, SIZE + 1);
    if (size < SIZE || !is_hex(header, 2) || !strncmp(header, "ff", 2)) return false;
    if (size > SIZE && (!strncmp(header, "00", 2) || header[SIZE] != '-')) return false;
    return header[AT_TRACE - 1] == '-' && header[AT_PARENT - 1] == '-' &&
           header[AT_FLAGS - 1] == '-' && is_hex(header + AT_TRACE, 32) &&
           is_hex(header + AT_PARENT, 16) && is_hex(header + AT_FLAGS, 2) &&
           !is_zero(header + AT_TRACE, 32) && !is_zero(header + AT_PARENT, 16);
}

/* The lowest bit of the flags; the others have no meaning yet. */
static bool is_sampled(const char *flags)
{
    const char digit = flags[1];
    return ((digit <= '9' ? digit - '0' : digit - 'a' + 10) & 1) != 0;
}

void trace_context_begin(struct trace_context_source *source, const char *header,
                         struct trace_context *out)
{
    *out = (struct trace_context){0};
    snprintf(out->request, sizeof out->request, "%016llx", (unsigned long long)next(source));
    if (header && is_valid(header)) {
        memcpy(out->id, header + AT_TRACE, TRACE_CONTEXT_ID_BYTES - 1);
        memcpy(out->parent, header + AT_PARENT, TRACE_CONTEXT_SPAN_BYTES - 1);
        out->sampled = is_sampled(header + AT_FLAGS);
        return;
    }
    const unsigned long long high = next(source), low = next(source);
    snprintf(out->id, sizeof out->id, "%016llx%016llx", high, low);
}

void trace_context_write(const struct trace_context *trace, char out[TRACE_CONTEXT_PARENT_BYTES])
{
    snprintf(out, TRACE_CONTEXT_PARENT_BYTES, "00-%s-%s-0%d", trace->id, trace->request,
             (int)trace->sampled);
}

void trace_context_keep(const struct trace_context *trace, char out[TRACE_CONTEXT_TEXT_BYTES])
{
    out[0] = '\0';
    if (!trace->request[0]) return;
    trace_context_write(trace, out);
    if (!trace->parent[0]) return;
    out[SIZE] = '-';
    memcpy(out + SIZE + 1, trace->parent, TRACE_CONTEXT_SPAN_BYTES);
}

bool trace_context_kept(const char *text, struct trace_context *out)
{
    const size_t size = strnlen(text, TRACE_CONTEXT_TEXT_BYTES),
                 whole = TRACE_CONTEXT_TEXT_BYTES - 1;
    const char *parent = size == whole ? text + SIZE + 1 : NULL;
    char head[TRACE_CONTEXT_PARENT_BYTES];
    *out = (struct trace_context){0};
    snprintf(head, sizeof head, "%s", text);
    if ((size != SIZE && !parent) || strncmp(head, "00", 2) != 0 || !is_valid(head)) return false;
    const size_t digits = TRACE_CONTEXT_SPAN_BYTES - 1;
    if (parent && (parent[-1] != '-' || !is_hex(parent, digits) || is_zero(parent, digits)))
        return false;
    memcpy(out->id, text + AT_TRACE, TRACE_CONTEXT_ID_BYTES - 1);
    memcpy(out->request, text + AT_PARENT, digits);
    if (parent) memcpy(out->parent, parent, digits);
    out->sampled = is_sampled(text + AT_FLAGS);
    return true;
}
