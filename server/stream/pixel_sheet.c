#include "server/stream/pixel_sheet.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

struct pixel_block *pixel_block_create(const struct image *image, const char *layer,
                                       enum pixels_format format, struct rect rect)
{
    uint8_t message[PIXELS_MESSAGE_BYTES];
    const size_t size_bytes = pixels_write_block(message, image, layer, format, rect, 0);
    struct pixel_block *block = size_bytes > 0 ? malloc(sizeof *block + size_bytes) : NULL;
    if (!block) return NULL;
    *block = (struct pixel_block){.refs = 1, .size_bytes = size_bytes};
    memcpy(block->bytes, message, size_bytes);
    return block;
}

void pixel_block_unref(struct pixel_block **block)
{
    if (*block && --(*block)->refs == 0) free(*block);
    *block = NULL;
}

/* In the sheet's place, with a reference of its own, if that is within `most_bytes` of all. */
static bool keep(struct pixel_sheet *sheet, struct pixel_block **place, struct pixel_block *block,
                 size_t most_bytes)
{
    struct pixel_budget *budget = sheet->budget;
    if (budget->kept_bytes > most_bytes || block->size_bytes > most_bytes - budget->kept_bytes)
        return false;
    budget->kept_bytes += block->size_bytes;
    block->refs++;
    *place = block;
    return true;
}

static void let_go(struct pixel_sheet *sheet, struct pixel_block **place)
{
    if (*place) sheet->budget->kept_bytes -= (*place)->size_bytes;
    pixel_block_unref(place);
}

struct pixel_sheet *pixel_sheet_join(struct pixel_sheet **list, struct pixel_budget *budget,
                                     const char *layer, enum pixels_format format)
{
    struct pixel_sheet *sheet = *list;
    if (strlen(layer) >= PIXEL_SHEET_LAYER_BYTES) return NULL;
    while (sheet && (sheet->format != format || strcmp(sheet->layer, layer) != 0))
        sheet = sheet->next;
    if (!sheet) {
        sheet = calloc(1, sizeof *sheet);
        if (!sheet) return NULL;
        memcpy(sheet->layer, layer, strlen(layer) + 1);
        sheet->format = format;
        sheet->budget = budget;
        sheet->next = *list;
        *list = sheet;
    }
    sheet->readers++;
    return sheet;
}

void pixel_sheet_clear(struct pixel_sheet *sheet)
{
    for (uint32_t i = 0; i < sheet->count; i++) let_go(sheet, &sheet->block[i]);
    free(sheet->block);
    sheet->block = NULL;
    sheet->count = 0;
}

void pixel_sheet_leave(struct pixel_sheet **list, struct pixel_sheet **sheet)
{
    struct pixel_sheet *s = *sheet;
    *sheet = NULL;
    if (!s || --s->readers > 0) return;
    while (*list != s) list = &(*list)->next;
    *list = s->next;
    pixel_sheet_clear(s);
    free(s);
}

/* Where the block is kept; NULL when there is no memory for places. */
static struct pixel_block **place_of(struct pixel_sheet *sheet, uint32_t count, uint32_t index)
{
    if (sheet->count != count) {
        pixel_sheet_clear(sheet);
        sheet->block = calloc(count, sizeof(struct pixel_block *));
        if (!sheet->block) return NULL;
        sheet->count = count;
    }
    return &sheet->block[index];
}

static struct pixel_block *with_ref(struct pixel_block *block)
{
    block->refs++;
    return block;
}

struct pixel_block *pixel_sheet_block(struct pixel_sheet *sheet, const struct image *image,
                                      const struct pixel_changes *changes, struct rect rect)
{
    uint32_t count, index = pixel_changes_block(changes, rect.x0, rect.y0, &count);
    struct pixel_block **place = place_of(sheet, count, index);
    const uint64_t changed = changes->revision[index];
    if (place && *place && (*place)->changed == changed) return with_ref(*place);
    if (!image) return NULL;
    struct pixel_block *block = pixel_block_create(image, sheet->layer, sheet->format, rect);
    if (!block) return NULL;
    block->changed = changed;
    sheet->made++;
    if (!place) return block;
    let_go(sheet, place);
    if (sheet->readers > 1) (void)keep(sheet, place, block, sheet->budget->shared_most_bytes);
    return block;
}

static int keep_block(struct pixel_sheet *sheet, const struct image *image,
                      const struct pixel_changes *changes, struct rect rect, size_t *room)
{
    uint32_t count, index = pixel_changes_block(changes, rect.x0, rect.y0, &count);
    struct pixel_block *block = pixel_sheet_block(sheet, image, changes, rect);
    struct pixel_block **place = place_of(sheet, count, index);
    int error = !block || !place ? ERR_MEMORY : block->size_bytes > *room ? ERR_LIMIT : 0;
    if (!error) *room -= block->size_bytes;
    if (!error && !*place && !keep(sheet, place, block, sheet->budget->most_bytes))
        error = ERR_LIMIT;
    pixel_block_unref(&block);
    return error;
}

int pixel_sheet_keep(struct pixel_sheet *sheet, const struct image *image,
                     const struct pixel_changes *changes, struct pixel_blocks *wanted, size_t *room)
{
    struct rect rect;
    int error = 0;
    for (uint32_t i = 0; i < sheet->count; i++)
        if (!pixel_blocks_has(wanted, i)) let_go(sheet, &sheet->block[i]);
    while (!error && pixel_blocks_take(wanted, &rect))
        error = keep_block(sheet, image, changes, rect, room);
    return error;
}
