#include "server/import/scene/warnings.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

void warnings_add(struct warnings *w, const char *place, const char *format, ...)
{
    char sentence[LIMIT_DETAIL_BYTES];
    va_list args;
    va_start(args, format);
    vsnprintf(sentence, sizeof sentence, format, args);
    va_end(args);
    for (uint32_t i = 0; i < w->count; i++) {
        if (strcmp(w->list[i].sentence, sentence) != 0) continue;
        w->list[i].more++;
        return;
    }
    if (w->count == LIMIT_WARNINGS - 1) { /* the last one tells of those that are left out */
        w->dropped++;
        return;
    }
    struct warning *warning = &w->list[w->count++];
    memcpy(warning->sentence, sentence, sizeof sentence);
    snprintf(warning->place, sizeof warning->place, "%s", place);
    warning->more = 0;
}

void warnings_text(const struct warnings *w, uint32_t index, char out[WARNING_TEXT_BYTES])
{
    const struct warning *warning = &w->list[index];
    char more[48] = "";
    if (warning->more > 0) snprintf(more, sizeof more, " and %" PRIu64 " more", warning->more);
    if (warning->place[0] == 0)
        snprintf(out, WARNING_TEXT_BYTES, "%s", warning->sentence);
    else
        snprintf(out, WARNING_TEXT_BYTES, "%s%s: %s", warning->place, more, warning->sentence);
    text_make_printable(out);
}

/* Length of the UTF-8 character at `at`, 0 when there is none. Overlong forms, surrogates and
 * numbers above U+10FFFF are none. */
static size_t utf8_length(const unsigned char *at)
{
    if (at[0] >= 0x20 && at[0] < 0x7f) return 1;
    size_t length = at[0] >= 0xc2 && at[0] <= 0xdf   ? 2
                    : at[0] >= 0xe0 && at[0] <= 0xef ? 3
                    : at[0] >= 0xf0 && at[0] <= 0xf4 ? 4
                                                     : 0;
    for (size_t i = 1; i < length; i++)
        if ((at[i] & 0xc0) != 0x80) return 0;
    if (at[0] == 0xe0 && at[1] < 0xa0) return 0;
    if (at[0] == 0xed && at[1] > 0x9f) return 0;
    if (at[0] == 0xf0 && at[1] < 0x90) return 0;
    if (at[0] == 0xf4 && at[1] > 0x8f) return 0;
    return length;
}

void text_make_printable(char *text)
{
    for (char *at = text; *at != 0;) {
        size_t length = utf8_length((const unsigned char *)at);
        if (length == 0) *at = '?';
        at += length == 0 ? 1 : length;
    }
}
