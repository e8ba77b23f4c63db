#pragma once
/* Browsers that have signed in: a random cookie stands for a token until it is signed out, its
 * hours are over, or the server ends. Only its hash is kept, and in memory alone. */
#include <stdint.h>

#include "proto/digest.h"

#define SIGN_IN_TEXT_BYTES 65          /* 64 hexadecimal digits and the end */
#define SIGN_IN_S          (12 * 3600) /* how long one holds */
#define SIGN_INS_MOST      1024        /* the oldest goes when one more comes */

struct sign_in {
    struct digest cookie, token; /* hashes */
    uint64_t until_s;            /* of a clock that never goes back; 0: free */
};

struct sign_ins {
    struct sign_in list[SIGN_INS_MOST];
};

/* ERR_IO: the system gives no random numbers. */
int sign_ins_add(struct sign_ins *s, const struct digest *token, uint64_t now_s,
                 char cookie[SIGN_IN_TEXT_BYTES]);
/* The hash of the token that the cookie stands for, or NULL. */
const struct digest *sign_ins_find(const struct sign_ins *s, const char *cookie, uint64_t now_s);
void sign_ins_remove(struct sign_ins *s, const char *cookie);
