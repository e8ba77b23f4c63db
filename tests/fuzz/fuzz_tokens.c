// sources: server/access/tokens.c
/* The file of tokens, and texts that claim to be one (what is behind a NUL). What is refused says
 * why; what is taken has names, tenants, roles and weights of the right kind, each token is found
 * by its hash, and one more can be added without the others changing. */
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/limits.h"
#include "server/access/tokens.h"

static char path[64];

static void must(bool holds)
{
    if (!holds) abort();
}

static void forget_file(void)
{
    (void)unlink(path);
}

static void put_file(const uint8_t *data, size_t size_bytes)
{
    if (!path[0]) {
        snprintf(path, sizeof path, "/dev/shm/fuzz-tokens-%d", (int)getpid());
        atexit(forget_file);
    }
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    must(fd >= 0 && write(fd, data, size_bytes) == (ssize_t)size_bytes);
    close(fd);
}

static void check(const struct tokens *tokens)
{
    must(tokens->count <= LIMIT_TOKENS);
    for (size_t i = 0; i < tokens->count; i++) {
        const struct token *t = &tokens->list[i];
        must(t->name[0] && tokens_is_tenant(t->tenant));
        must(t->role > ROLE_NONE && t->role < ROLE_COUNT);
        must(t->weight >= 1 && t->weight <= TENANT_WEIGHT_MAX);
        must(tokens_find_hash(tokens, &t->hash) == t);
    }
}

static void add_one(const struct tokens *before)
{
    struct token more = {.name = "one.more", .tenant = "one-more", .role = ROLE_VIEWER};
    struct tokens *after = NULL;
    struct fault fault = {0};
    digest_of("one more", 8, &more.hash);
    const int error = tokens_add(path, &more, &fault);
    if (error) {
        must(error == ERR_EXISTS || error == ERR_LIMIT);
        return;
    }
    must(tokens_read(path, &after, &fault) == 0 && after->count == before->count + 1);
    for (size_t i = 0; i < before->count; i++) {
        const struct token *a = &before->list[i], *b = tokens_find_hash(after, &a->hash);
        must(b && strcmp(a->name, b->name) == 0 && strcmp(a->tenant, b->tenant) == 0);
        must(a->role == b->role && a->weight == b->weight);
    }
    free(after);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    const uint8_t *nul = size_bytes ? memchr(data, 0, size_bytes) : NULL;
    const size_t file_bytes = nul ? (size_t)(nul - data) : size_bytes;
    struct tokens *tokens = NULL;
    struct fault fault = {0};
    put_file(data, file_bytes);
    if (tokens_read(path, &tokens, &fault) != 0) {
        must(fault.code < 0 && fault.detail[0] && !tokens);
        return 0;
    }
    check(tokens);
    if (nul) {
        const char *text = (const char *)nul + 1;
        const size_t bytes = size_bytes - file_bytes - 1;
        char *claim = malloc(bytes + 1);
        must(claim != NULL);
        memcpy(claim, text, bytes);
        claim[bytes] = '\0';
        const struct token *found = tokens_find(tokens, claim, bytes);
        must(!found || tokens_is_text(claim, bytes));
        free(claim);
    }
    add_one(tokens);
    free(tokens);
    return 0;
}
