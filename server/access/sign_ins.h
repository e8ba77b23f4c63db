#pragma once
/* Browsers that have signed in: a random cookie stands for a token until it is signed out, its
 * hours are over, or the server ends. Only its hash is kept, and in memory alone.
 *
 * A token has SIGN_INS_OF_TOKEN places at most, of which its own oldest goes when one more comes:
 * who signs in again and again pushes nobody else out. When all places are taken, the oldest goes
 * of the token that has most. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/digest.h"

#define SIGN_IN_TEXT_BYTES 65          /* 64 hexadecimal digits and the end */
#define SIGN_IN_S          (12 * 3600) /* how long one usually holds */
#define SIGN_INS_MOST      1024
#define SIGN_INS_OF_TOKEN  64

struct sign_in {
    struct digest cookie, token; /* hashes */
    uint64_t until_s;            /* of a clock that never goes back */
    uint64_t number;             /* from 1, none comes twice; 0: the place is free */
};

struct sign_ins {
    uint64_t hold_s; /* how long those last that come */
    uint64_t last_number;
    struct sign_in list[SIGN_INS_MOST];
};

/* Which sign-in something came by: looked up once, and then asked for at no cost. */
struct sign_in_ref {
    size_t place;
    uint64_t number; /* 0: by none */
};

/* None yet. */
void sign_ins_init(struct sign_ins *s, uint64_t hold_s);

/* ERR_IO: the system gives no random numbers. */
int sign_ins_add(struct sign_ins *s, const struct digest *token, uint64_t now_s,
                 char cookie[SIGN_IN_TEXT_BYTES]);
/* The hash of the token that the cookie stands for, or NULL; and which sign-in that is. */
const struct digest *sign_ins_find(const struct sign_ins *s, const char *cookie, uint64_t now_s,
                                   struct sign_in_ref *ref);
/* Has it neither been removed nor pushed out, nor is its time over? */
bool sign_ins_holds(const struct sign_ins *s, const struct sign_in_ref *ref, uint64_t now_s);
void sign_ins_remove(struct sign_ins *s, const char *cookie);
/* Removes those of tokens that are not wanted. */
void sign_ins_sweep(struct sign_ins *s, bool (*is_wanted)(void *ctx, const struct digest *token),
                    void *ctx);
