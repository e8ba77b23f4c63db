#include "server/http/range.h"

#include <stddef.h>
#include <string.h>
#include <strings.h>

/* Digits at *at, saturated; false when there are none. */
static bool read_digits(const char **at, uint64_t *out)
{
    const char *p = *at;
    uint64_t n = 0;
    for (; *p >= '0' && *p <= '9'; p++) {
        uint64_t digit = (uint64_t)(*p - '0');
        n = n > (UINT64_MAX - digit) / 10 ? UINT64_MAX : n * 10 + digit;
    }
    bool any = p != *at;
    *at = p;
    *out = n;
    return any;
}

static struct range suffix(uint64_t last_bytes, uint64_t file_bytes)
{
    if (last_bytes == 0 || file_bytes == 0) return (struct range){.kind = RANGE_UNSATISFIABLE};
    uint64_t size = last_bytes < file_bytes ? last_bytes : file_bytes;
    return (struct range){RANGE_PART, file_bytes - size, size};
}

struct range range_read(const char *header, uint64_t file_bytes)
{
    const struct range whole = {RANGE_WHOLE, 0, file_bytes};
    uint64_t first = 0, last = UINT64_MAX;
    if (!header || strncasecmp(header, "bytes=", 6) != 0) return whole;
    const char *at = header + 6;
    bool has_first = read_digits(&at, &first);
    if (*at++ != '-') return whole;
    bool has_last = read_digits(&at, &last);
    if (*at || (!has_first && !has_last)) return whole;
    if (!has_first) return suffix(last, file_bytes);
    if (has_last && last < first) return whole;
    if (first >= file_bytes) return (struct range){.kind = RANGE_UNSATISFIABLE};
    if (!has_last || last >= file_bytes) last = file_bytes - 1;
    return (struct range){RANGE_PART, first, last - first + 1};
}
