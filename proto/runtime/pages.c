#include "proto/runtime/pages.h"

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

#define LINE_BYTES ((size_t)64)

/* Larger pieces have pages of their own, and all where a sanitizer watches their ends. */
#define CHUNK_BYTES (8 * PAGES_HUGE_BYTES)
#ifdef __SANITIZE_ADDRESS__
#define PIECE_MAX_BYTES 0
#else
#define PIECE_MAX_BYTES (CHUNK_BYTES / 4)
#endif

/* Pieces lie one behind the other. A chunk is freed, or begun anew, when all were given back. */
struct chunk {
    size_t used_bytes; /* with this */
    size_t pieces;
};

/* Before each piece, as long as a line. */
struct piece {
    _Alignas(LINE_BYTES) struct chunk *chunk; /* NULL: its pages are its own */
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static struct chunk *current; /* that pieces are taken from; NULL before the first */

void pages_prefer_huge(void *memory, size_t size_bytes)
{
    const uintptr_t unit = PAGES_HUGE_BYTES, at = (uintptr_t)memory;
    const uintptr_t first = (at + unit - 1) / unit * unit, end = (at + size_bytes) / unit * unit;
    if (first < end) madvise((char *)memory + (first - at), end - first, MADV_HUGEPAGE);
}

static void *allocate(size_t size_bytes, size_t unit_bytes)
{
    const size_t whole = (size_bytes + unit_bytes - 1) / unit_bytes * unit_bytes;
    void *memory = aligned_alloc(unit_bytes, whole);
    if (memory) pages_prefer_huge(memory, whole);
    return memory;
}

static struct piece *take_alone(size_t size_bytes)
{
    struct piece *piece = allocate(size_bytes, LINE_BYTES);
    if (piece) piece->chunk = NULL;
    return piece;
}

/* The caller holds the mutex. */
static struct piece *take_shared(size_t size_bytes)
{
    if (!current || current->used_bytes + size_bytes > CHUNK_BYTES) {
        struct chunk *next = allocate(CHUNK_BYTES, PAGES_HUGE_BYTES);
        if (!next) return NULL;
        if (current && current->pieces == 0) free(current);
        current = next;
        *current = (struct chunk){.used_bytes = LINE_BYTES};
    }
    struct piece *piece = (struct piece *)((char *)current + current->used_bytes);
    piece->chunk = current;
    current->used_bytes += size_bytes;
    current->pieces++;
    return piece;
}

void *pages_take(size_t size_bytes)
{
    struct piece *piece;
    if (size_bytes > SIZE_MAX / 2) return NULL;
    const size_t whole = sizeof *piece + (size_bytes + LINE_BYTES - 1) / LINE_BYTES * LINE_BYTES;
    if (whole > PIECE_MAX_BYTES) {
        piece = take_alone(whole);
    } else {
        pthread_mutex_lock(&mutex);
        piece = take_shared(whole);
        pthread_mutex_unlock(&mutex);
    }
    return piece ? piece + 1 : NULL;
}

void pages_give(void *memory)
{
    if (!memory) return;
    struct piece *piece = (struct piece *)memory - 1;
    struct chunk *chunk = piece->chunk;
    if (!chunk) {
        free(piece);
        return;
    }
    pthread_mutex_lock(&mutex);
    chunk->used_bytes = --chunk->pieces > 0 ? chunk->used_bytes : LINE_BYTES;
    if (chunk->pieces == 0 && chunk != current) free(chunk);
    pthread_mutex_unlock(&mutex);
}
