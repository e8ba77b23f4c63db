#include "server/cli/tev/tev_packet.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

/* Little-endian, as every CPU that Embree runs on here. */
static void put(struct tev_packet *p, const void *from, size_t bytes)
{
    if (p->error) return;
    if (p->size_bytes + bytes > UINT32_MAX) {
        p->error = ERR_LIMIT;
        return;
    }
    if (p->size_bytes + bytes > p->held_bytes) {
        const size_t held = 2 * (p->size_bytes + bytes);
        uint8_t *grown = realloc(p->data, held);
        if (!grown) {
            p->error = ERR_MEMORY;
            return;
        }
        p->data = grown;
        p->held_bytes = held;
    }
    memcpy(p->data + p->size_bytes, from, bytes);
    p->size_bytes += bytes;
}

static void put_u8(struct tev_packet *p, uint8_t v)
{
    put(p, &v, 1);
}

static void put_i32(struct tev_packet *p, int32_t v)
{
    put(p, &v, sizeof v);
}

static void put_text(struct tev_packet *p, const char *text)
{
    put(p, text, strlen(text) + 1);
}

/* No packet takes the focus from what the person looks at. */
static void begin(struct tev_packet *p, enum tev_kind kind, const char *name)
{
    p->size_bytes = 0;
    p->error = 0;
    put_i32(p, 0); /* the length, told at the end */
    put_u8(p, (uint8_t)kind);
    put_u8(p, 0);
    put_text(p, name);
}

static int finish(struct tev_packet *p)
{
    const uint32_t length = (uint32_t)p->size_bytes;
    if (!p->error) memcpy(p->data, &length, sizeof length);
    return p->error;
}

void tev_packet_fini(struct tev_packet *p)
{
    free(p->data);
    *p = (struct tev_packet){.data = NULL};
}

int tev_packet_create(struct tev_packet *p, const char *name, int32_t width_px, int32_t height_px,
                      const char *const *channels, uint32_t count)
{
    begin(p, TEV_CREATE_IMAGE, name);
    put_i32(p, width_px);
    put_i32(p, height_px);
    put_i32(p, (int32_t)count);
    for (uint32_t c = 0; c < count; c++) put_text(p, channels[c]);
    return finish(p);
}

int tev_packet_update(struct tev_packet *p, const char *name, struct rect rect,
                      const char *const *channels, uint32_t count, const int64_t *offset,
                      const int64_t *stride, const float *numbers, size_t held)
{
    begin(p, TEV_UPDATE_IMAGE_V3, name);
    put_i32(p, (int32_t)count);
    for (uint32_t c = 0; c < count; c++) put_text(p, channels[c]);
    put_i32(p, rect.x0);
    put_i32(p, rect.y0);
    put_i32(p, rect_width(rect));
    put_i32(p, rect_height(rect));
    put(p, offset, count * sizeof *offset);
    put(p, stride, count * sizeof *stride);
    put(p, numbers, held * sizeof *numbers);
    return finish(p);
}
