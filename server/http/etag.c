#include "server/http/etag.h"

#include <stdio.h>
#include <string.h>

void etag_of_digest(const struct digest *digest, char out[ETAG_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(digest, hex);
    snprintf(out, ETAG_BYTES, "\"%s\"", hex);
}

void etag_of_bytes(const void *data, size_t size_bytes, char out[ETAG_BYTES])
{
    struct digest digest;
    digest_of(data, size_bytes, &digest);
    etag_of_digest(&digest, out);
}

/* Returns the tag at *at, with its quotes, and moves *at behind it. NULL at the end or if it is
 * malformed. */
static const char *next_tag(const char **at, size_t *size_bytes, bool *weak)
{
    const char *p = *at + strspn(*at, " \t,");
    *weak = p[0] == 'W' && p[1] == '/';
    if (*weak) p += 2;
    if (*p != '"') return NULL;
    const char *end = strchr(p + 1, '"');
    if (!end) return NULL;
    *size_bytes = (size_t)(end + 1 - p);
    *at = end + 1;
    return p;
}

static bool is_listed(const char *list, const char *etag, bool strongly)
{
    size_t size_bytes = 0, want = 0;
    bool weak, wanted_weak;
    const char *tag = etag, *wanted = next_tag(&tag, &want, &wanted_weak);
    if (strcmp(list, "*") == 0) return true;
    for (const char *at = list; wanted && (tag = next_tag(&at, &size_bytes, &weak));)
        if (!(strongly && weak) && size_bytes == want && memcmp(tag, wanted, want) == 0)
            return true;
    return false;
}

bool etag_listed(const char *list, const char *etag)
{
    return is_listed(list, etag, false);
}

bool etag_matches(const char *list, const char *etag)
{
    return is_listed(list, etag, true);
}
