#pragma once
/* Bearer tokens and their roles, from a file that holds their SHA-256 alone.
 *
 * {"tokens": [{"name": "ana-laptop", "tenant": "studio", "role": "submitter", "sha256": "64
 * hexadecimal digits"}], "tenants": {"studio": {"weight": 2}}}
 *
 * A token is "sw_" and 64 random hexadecimal digits, or any other text of 20 to 256 of the letters
 * that RFC 6750 allows in one. Since it cannot be guessed, its plain hash needs no salt. Tokens of
 * one tenant see the same jobs. Among tenants with work at the same priority, one of weight 2 gets
 * twice the share of one of weight 1. A tenant that "tenants" (which may be missing) does not name
 * has weight 1. */
#include <stddef.h>

#include "proto/digest.h"
#include "proto/error.h"
#include "server/store/job_store.h"

/* Each may do what those before it may. */
enum role {
    ROLE_NONE,      /* no token: health, contract, the viewer's files */
    ROLE_VIEWER,    /* look at the tenant's jobs, at workers, at figures */
    ROLE_SUBMITTER, /* upload, submit, steer, cancel: the tenant's own */
    ROLE_ADMIN,     /* all of that for every tenant's jobs; workers */
    ROLE_COUNT
};

#define TENANT_WEIGHT_MAX 100

#define TOKEN_NAME_BYTES 65
#define TOKEN_TEXT_BYTES 68 /* of a token that tokens_make makes, with its end */

struct token {
    char name[TOKEN_NAME_BYTES]; /* for people: as a tenant's, with capitals and '.' */
    char tenant[JOB_OWNER_BYTES];
    enum role role;
    uint32_t weight; /* of its tenant: 1 to TENANT_WEIGHT_MAX */
    struct digest hash;
};

struct tokens {
    size_t count;
    struct token list[]; /* no two hashes and no two names are equal */
};

const char *role_name(enum role role);
/* Reads a role's name. False for any that no token may have, "none" among them. */
bool role_from_name(const char *name, enum role *out);

/* Reads the file. Only its owner may write it, and only its owner and group may read it. *out is
 * freed with free. *fault says what to do. ERR_NOT_FOUND, ERR_IO, ERR_STATE (rights), ERR_LIMIT,
 * ERR_SYNTAX and other errors of the document. */
int tokens_read(const char *path, struct tokens **out, struct fault *fault);

/* Finds a token by its text; NULL: none. Takes the same time whether there is one or not. */
const struct token *tokens_find(const struct tokens *tokens, const char *text, size_t size_bytes);
const struct token *tokens_find_hash(const struct tokens *tokens, const struct digest *hash);

/* Returns whether a text may name a tenant: 1 to 64 of a-z, 0-9, '-' and '_', which are safe in a
 * header and beside an idempotency key. */
bool tokens_is_tenant(const char *text);

/* Returns whether a text may be a token at all. It need not end with a NUL. */
bool tokens_is_text(const char *text, size_t size_bytes);

/* Makes a new random token. ERR_IO: the system gives no random numbers. */
int tokens_make(char out[TOKEN_TEXT_BYTES]);

/* Adds a token to the file, which is created if it is missing, and replaced as a whole. ERR_EXISTS
 * for a name that is there already; else as tokens_read. */
int tokens_add(const char *path, const struct token *token, struct fault *fault);
