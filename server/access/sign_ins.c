#include "server/access/sign_ins.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <string.h>

#include "proto/error.h"

void sign_ins_init(struct sign_ins *s, uint64_t hold_s)
{
    memset(s, 0, sizeof *s);
    s->hold_s = hold_s;
}

/* -- places -- */

/* Returns the older of two, of which the first may be NULL. */
static struct sign_in *older(struct sign_in *a, struct sign_in *b)
{
    return a && a->number < b->number ? a : b;
}

static struct sign_in *oldest_of(struct sign_ins *s, const struct digest *token, size_t *count)
{
    struct sign_in *oldest = NULL;
    *count = 0;
    for (size_t i = 0; i < SIGN_INS_MAX; i++) {
        struct sign_in *one = &s->list[i];
        if (one->number == 0 || !digest_equal(&one->token, token)) continue;
        oldest = older(oldest, one);
        ++*count;
    }
    return oldest;
}

/* Returns the oldest sign-in of a full list. */
static struct sign_in *oldest_of_max(struct sign_ins *s)
{
    struct sign_in *chosen = NULL;
    size_t most = 0;
    for (size_t i = 0; i < SIGN_INS_MAX; i++) {
        size_t count;
        struct sign_in *oldest = oldest_of(s, &s->list[i].token, &count);
        if (count == most) oldest = older(chosen, oldest);
        if (count >= most) chosen = oldest;
        if (count >= most) most = count;
    }
    return chosen;
}

/* Finds a free place. It ends sign-ins whose time is over, so that their hashes are not kept. */
static struct sign_in *find_free(struct sign_ins *s, uint64_t now_s)
{
    struct sign_in *found = NULL;
    for (size_t i = 0; i < SIGN_INS_MAX; i++) {
        struct sign_in *one = &s->list[i];
        if (one->number != 0 && one->until_s <= now_s) *one = (struct sign_in){0};
        if (one->number == 0) found = one;
    }
    return found;
}

static struct sign_in *make_room(struct sign_ins *s, const struct digest *token, uint64_t now_s)
{
    size_t own_count;
    struct sign_in *free_one = find_free(s, now_s);
    struct sign_in *own = oldest_of(s, token, &own_count);
    if (own_count >= SIGN_INS_OF_TOKEN) return own;
    return free_one ? free_one : oldest_of_max(s);
}

/* -- cookies -- */

int sign_ins_add(struct sign_ins *s, const struct digest *token, uint64_t now_s,
                 char cookie[SIGN_IN_TEXT_BYTES])
{
    uint8_t random[(SIGN_IN_TEXT_BYTES - 1) / 2];
    if (gnutls_rnd(GNUTLS_RND_KEY, random, sizeof random) != 0) return ERR_IO;
    for (size_t i = 0; i < sizeof random; i++) sprintf(cookie + 2 * i, "%02x", random[i]);
    struct sign_in *place = make_room(s, token, now_s);
    *place =
        (struct sign_in){.token = *token, .until_s = now_s + s->hold_s, .number = ++s->last_number};
    digest_of(cookie, SIGN_IN_TEXT_BYTES - 1, &place->cookie);
    return 0;
}

/* Returns the place of a sign-in, SIGN_INS_MAX when there is none. It looks at all of them in any
 * case. */
static size_t place_of(const struct sign_ins *s, const char *cookie)
{
    struct digest hash;
    size_t found = SIGN_INS_MAX;
    if (strnlen(cookie, SIGN_IN_TEXT_BYTES) != SIGN_IN_TEXT_BYTES - 1) return found;
    digest_of(cookie, SIGN_IN_TEXT_BYTES - 1, &hash);
    for (size_t i = 0; i < SIGN_INS_MAX; i++)
        if (gnutls_memcmp(s->list[i].cookie.bytes, hash.bytes, DIGEST_BYTES) == 0) found = i;
    return found;
}

const struct digest *sign_ins_find(const struct sign_ins *s, const char *cookie, uint64_t now_s,
                                   struct sign_in_ref *ref)
{
    const size_t at = place_of(s, cookie);
    *ref = (struct sign_in_ref){.place = at, .number = at < SIGN_INS_MAX ? s->list[at].number : 0};
    return sign_ins_holds(s, ref, now_s) ? &s->list[at].token : NULL;
}

bool sign_ins_holds(const struct sign_ins *s, const struct sign_in_ref *ref, uint64_t now_s)
{
    if (ref->number == 0 || ref->place >= SIGN_INS_MAX) return false;
    const struct sign_in *one = &s->list[ref->place];
    return one->number == ref->number && one->until_s > now_s;
}

void sign_ins_remove(struct sign_ins *s, const char *cookie)
{
    size_t at = place_of(s, cookie);
    if (at < SIGN_INS_MAX) s->list[at] = (struct sign_in){0};
}

void sign_ins_sweep(struct sign_ins *s, bool (*is_wanted)(void *ctx, const struct digest *token),
                    void *ctx)
{
    for (size_t i = 0; i < SIGN_INS_MAX; i++) {
        struct sign_in *one = &s->list[i];
        if (one->number != 0 && !is_wanted(ctx, &one->token)) *one = (struct sign_in){0};
    }
}
