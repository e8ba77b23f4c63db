#include "server/access/sign_ins.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "proto/error.h"

int sign_ins_add(struct sign_ins *s, const struct digest *token, uint64_t now_s,
                 char cookie[SIGN_IN_TEXT_BYTES])
{
    uint8_t random[(SIGN_IN_TEXT_BYTES - 1) / 2];
    struct sign_in *oldest = s->list;
    if (gnutls_rnd(GNUTLS_RND_KEY, random, sizeof random) != 0) return ERR_IO;
    for (size_t i = 0; i < sizeof random; i++) sprintf(cookie + 2 * i, "%02x", random[i]);
    for (size_t i = 1; i < SIGN_INS_MOST; i++)
        if (s->list[i].until_s < oldest->until_s) oldest = &s->list[i];
    *oldest = (struct sign_in){.token = *token, .until_s = now_s + SIGN_IN_S};
    digest_of(cookie, SIGN_IN_TEXT_BYTES - 1, &oldest->cookie);
    return 0;
}

/* SIGN_INS_MOST when there is none; looks at all of them in any case. */
static size_t place_of(const struct sign_ins *s, const char *cookie)
{
    struct digest hash;
    size_t found = SIGN_INS_MOST;
    if (strnlen(cookie, SIGN_IN_TEXT_BYTES) != SIGN_IN_TEXT_BYTES - 1) return found;
    digest_of(cookie, SIGN_IN_TEXT_BYTES - 1, &hash);
    for (size_t i = 0; i < SIGN_INS_MOST; i++)
        if (gnutls_memcmp(s->list[i].cookie.bytes, hash.bytes, DIGEST_BYTES) == 0) found = i;
    return found;
}

const struct digest *sign_ins_find(const struct sign_ins *s, const char *cookie, uint64_t now_s)
{
    size_t at = place_of(s, cookie);
    return at < SIGN_INS_MOST && s->list[at].until_s > now_s ? &s->list[at].token : NULL;
}

void sign_ins_remove(struct sign_ins *s, const char *cookie)
{
    size_t at = place_of(s, cookie);
    if (at < SIGN_INS_MOST) s->list[at] = (struct sign_in){0};
}
