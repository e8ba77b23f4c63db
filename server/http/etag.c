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

/* One tag at *at, quotes included; moves *at behind it. NULL at the end or where it is malformed.
 */
static const char *next_tag(const char **at, size_t *size_bytes)
{
    const char *p = *at + strspn(*at, " \t,");
    if (p[0] == 'W' && p[1] == '/') p += 2;
    if (*p != '"') return NULL;
    const char *end = strchr(p + 1, '"');
    if (!end) return NULL;
    *size_bytes = (size_t)(end + 1 - p);
    *at = end + 1;
    return p;
}

bool etag_listed(const char *list, const char *etag)
{
    size_t size_bytes = 0, want = 0;
    const char *tag = etag, *wanted = next_tag(&tag, &want);
    if (strcmp(list, "*") == 0) return true;
    for (const char *at = list; wanted && (tag = next_tag(&at, &size_bytes));)
        if (size_bytes == want && memcmp(tag, wanted, want) == 0) return true;
    return false;
}
