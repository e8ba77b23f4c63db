#pragma once
/* Sign-ins of browsers. A random cookie stands for a token until it is signed out, its hours are
 * over, or the server ends. Only its hash is kept, and in memory alone.
 *
 * A token has SIGN_INS_OF_TOKEN places at most. One more sign-in replaces its own oldest, so that
 * repeated sign-ins push out no other token's. When all places are taken, the oldest of the token
 * with the most goes. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/digest.h"

#define SIGN_IN_TEXT_BYTES 65          /* 64 hexadecimal digits and the end */
#define SIGN_IN_S          (12 * 3600) /* default of how long one holds */
#define SIGN_INS_MAX       1024
#define SIGN_INS_OF_TOKEN  64

struct sign_in {
    struct digest cookie, token; /* hashes */
    uint64_t until_s;            /* by a monotonic clock */
    uint64_t number;             /* from 1, never repeated; 0: the place is free */
};

struct sign_ins {
    uint64_t hold_s; /* how long new ones hold */
    uint64_t last_number;
    struct sign_in list[SIGN_INS_MAX];
};

/* A reference to a sign-in, looked up once and then checked at no cost. */
struct sign_in_ref {
    size_t place;
    uint64_t number; /* 0: by none */
};

/* Sets an empty table. */
void sign_ins_init(struct sign_ins *s, uint64_t hold_s);

/* Adds a sign-in with a new random cookie. ERR_IO: the system gives no random numbers. */
int sign_ins_add(struct sign_ins *s, const struct digest *token, uint64_t now_s,
                 char cookie[SIGN_IN_TEXT_BYTES]);
/* Returns the hash of the token that the cookie stands for, or NULL; *ref is the sign-in. */
const struct digest *sign_ins_find(const struct sign_ins *s, const char *cookie, uint64_t now_s,
                                   struct sign_in_ref *ref);
/* Returns whether it still holds: not removed, not pushed out, its time not over. */
bool sign_ins_holds(const struct sign_ins *s, const struct sign_in_ref *ref, uint64_t now_s);
void sign_ins_remove(struct sign_ins *s, const char *cookie);
/* Removes the sign-ins of unwanted tokens. */
void sign_ins_sweep(struct sign_ins *s, bool (*is_wanted)(void *ctx, const struct digest *token),
                    void *ctx);
