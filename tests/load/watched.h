#pragma once
/* What watchers saw: how late news came, and the blocks of a feed. */
#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCKS_MAX   4096
#define DELAYS_MAX   (1u << 22)
#define HEADER_BYTES 32u
#define BLOCK_PX     64

struct delays {
    float *ms;
    size_t count;
};

struct watched_feed {
    uint8_t header[HEADER_BYTES];
    size_t header_bytes;
    uint64_t block_left, revision;
    unsigned at, blocks, distinct;
    bool whole; /* the last message said: all there is has been sent */
    uint32_t width_px, height_px;
    uint64_t *hash; /* by block; owned */
    uint8_t *seen;  /* by block; owned */
    bool hashed;    /* whether pixels are compared */
};

static inline void fail(const char *what)
{
    fprintf(stderr, "watchers: %s: %s\n", what, strerror(errno));
    exit(1);
}

static inline void *must(void *memory)
{
    if (!memory) fail("memory");
    return memory;
}

/* ---- delays ---- */

static inline void note_delay(struct delays *d, double ms)
{
    if (!d->ms) d->ms = must(malloc(DELAYS_MAX * sizeof *d->ms));
    if (d->count < DELAYS_MAX) d->ms[d->count++] = (float)ms;
}

static inline int by_size(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static inline double quantile(struct delays *d, double q)
{
    if (d->count == 0) return -1;
    qsort(d->ms, d->count, sizeof *d->ms, by_size);
    return d->ms[(size_t)(q * (double)(d->count - 1))];
}

/* ---- feeds ---- */

static inline uint64_t little(const uint8_t *p, int bytes)
{
    uint64_t v = 0;
    for (int i = bytes; i-- > 0;) v = v << 8 | p[i];
    return v;
}

static inline void on_size(struct watched_feed *c, uint32_t width_px, uint32_t height_px)
{
    c->whole = c->blocks > 0;
    if (c->width_px == width_px && c->height_px == height_px) return;
    c->width_px = width_px;
    c->height_px = height_px;
    c->distinct = 0;
    memset(c->seen, 0, BLOCKS_MAX);
}

static inline void on_header(struct watched_feed *c)
{
    const uint8_t *h = c->header;
    const uint32_t format = (uint32_t)little(h + 6, 2), x = (uint32_t)little(h + 8, 4);
    const uint32_t y = (uint32_t)little(h + 12, 4), w = (uint32_t)little(h + 16, 4);
    const uint32_t rows = (uint32_t)little(h + 20, 4);
    c->header_bytes = 0;
    if (memcmp(h, "SWPX", 4) != 0 || format != 1) fail("a feed has lost its place");
    c->revision = little(h + 24, 8);
    if (w == 0) {
        if (rows == 0) on_size(c, x, y);
        return;
    }
    c->whole = false;
    c->at = y / BLOCK_PX * ((c->width_px + BLOCK_PX - 1) / BLOCK_PX) + x / BLOCK_PX;
    if (c->at >= BLOCKS_MAX) fail("a picture too large for this program");
    c->blocks++;
    c->distinct += !c->seen[c->at];
    c->seen[c->at] = 1;
    c->hash[c->at] = UINT64_C(14695981039346656037);
    c->block_left = (uint64_t)w * rows * 6;
}

static inline void take_pixels(struct watched_feed *c, const char *data, size_t bytes)
{
    while (bytes > 0) {
        size_t n;
        if (c->block_left > 0) {
            n = bytes < c->block_left ? bytes : (size_t)c->block_left;
            for (size_t i = 0; c->hashed && i < n; i++)
                c->hash[c->at] = (c->hash[c->at] ^ (uint8_t)data[i]) * UINT64_C(1099511628211);
            c->block_left -= n;
        } else {
            n = HEADER_BYTES - c->header_bytes < bytes ? HEADER_BYTES - c->header_bytes : bytes;
            memcpy(c->header + c->header_bytes, data, n);
            c->header_bytes += n;
            if (c->header_bytes == HEADER_BYTES) on_header(c);
        }
        data += n;
        bytes -= n;
    }
}

static inline unsigned blocks_of(const struct watched_feed *c)
{
    return ((c->width_px + BLOCK_PX - 1) / BLOCK_PX) * ((c->height_px + BLOCK_PX - 1) / BLOCK_PX);
}
