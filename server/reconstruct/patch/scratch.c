#include "server/reconstruct/patch/scratch.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "proto/error.h"
#include "proto/runtime/pages.h"

#define LINE_BYTES 64u
#define SLACK      4 /* a piece may be larger than what is asked for by 1/4 */

/* Before each piece; as long as a line, so that the piece starts on one. */
struct piece {
    _Alignas(LINE_BYTES) size_t bytes; /* of what follows */
    struct piece *next;                /* among those given back, the latest first */
};
_Static_assert(sizeof(struct piece) == LINE_BYTES, "one line");

struct scratch {
    pthread_mutex_t mutex;
    struct piece *free; /* never more pieces than were taken at once */
};

int scratch_create(struct scratch **out)
{
    struct scratch *s = *out = calloc(1, sizeof *s);
    if (!s) return ERR_MEMORY;
    if (pthread_mutex_init(&s->mutex, NULL) == 0) return 0;
    free(s);
    *out = NULL;
    return ERR_MEMORY;
}

static void free_all(struct piece *first)
{
    for (struct piece *next; first; first = next) {
        next = first->next;
        free(first);
    }
}

void scratch_destroy(struct scratch **scratch)
{
    struct scratch *s = *scratch;
    if (!s) return;
    free_all(s->free);
    pthread_mutex_destroy(&s->mutex);
    free(s);
    *scratch = NULL;
}

static struct piece *allocate(size_t asked, bool kept)
{
    const size_t bytes = kept ? asked + asked / SLACK : asked;
    const size_t unit = kept && bytes >= PAGES_HUGE_BYTES ? PAGES_HUGE_BYTES : LINE_BYTES;
    if (asked > SIZE_MAX / 4) return NULL;
    const size_t size = (sizeof(struct piece) + bytes + unit - 1) / unit * unit;
    struct piece *piece = aligned_alloc(unit, size);
    if (!piece) return NULL;
    pages_prefer_huge(piece, size);
    piece->bytes = size - sizeof *piece;
    return piece;
}

/* The smallest piece that fits is best, else the largest. */
static bool is_better(const struct piece *piece, const struct piece *best, size_t bytes)
{
    const bool fits = piece->bytes >= bytes, best_fits = best->bytes >= bytes;
    if (fits != best_fits) return fits;
    return fits ? piece->bytes < best->bytes : piece->bytes > best->bytes;
}

/* Returns whether a piece fits as closely as a new one would. */
static bool is_close(const struct piece *piece, size_t bytes)
{
    return piece->bytes >= bytes && piece->bytes - bytes <= bytes / SLACK;
}

/* Takes the best piece out of the list; NULL when it is empty. Most are of one size, so that a
 * close one soon ends the search. */
static struct piece *take_best(struct scratch *s, size_t bytes)
{
    struct piece **best = &s->free;
    for (struct piece **at = best; *at && !is_close(*best, bytes); at = &(*at)->next)
        if (is_better(*at, *best, bytes)) best = at;
    struct piece *piece = *best;
    if (piece) *best = piece->next;
    return piece;
}

void *scratch_take(struct scratch *s, size_t bytes)
{
    struct piece *piece = NULL;
    if (s) {
        pthread_mutex_lock(&s->mutex);
        piece = take_best(s, bytes);
        pthread_mutex_unlock(&s->mutex);
    }
    if (!piece || piece->bytes < bytes) { /* a larger piece takes the place of the largest */
        free(piece);
        piece = allocate(bytes, s != NULL);
    }
    return piece ? piece + 1 : NULL;
}

void scratch_give(struct scratch *s, void *memory)
{
    if (!memory) return;
    struct piece *piece = (struct piece *)memory - 1;
    if (!s) {
        free(piece);
        return;
    }
    pthread_mutex_lock(&s->mutex);
    piece->next = s->free;
    s->free = piece;
    pthread_mutex_unlock(&s->mutex);
}

static size_t held_bytes(const struct scratch *s)
{
    size_t bytes = 0;
    for (const struct piece *piece = s->free; piece; piece = piece->next) bytes += piece->bytes;
    return bytes;
}

void scratch_trim(struct scratch *s, size_t most_bytes)
{
    struct piece *gone = NULL;
    pthread_mutex_lock(&s->mutex);
    for (size_t held = held_bytes(s); held > most_bytes;) {
        struct piece *largest = take_best(s, SIZE_MAX); /* none fits: the largest is best */
        held -= largest->bytes;
        largest->next = gone;
        gone = largest;
    }
    pthread_mutex_unlock(&s->mutex);
    free_all(gone);
}
