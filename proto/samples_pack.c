/* Sample buffers as bytes: planes that hold nothing are left out, the rest is compressed. */
#include <stdlib.h>
#include <string.h>

#include "proto/packing.h"
#include "proto/plane_filter.h"
#include "proto/samples_layout.h"

#define TRIAL_PART      16         /* of a tile's rows: what a shuffle is chosen by */
#define TRIAL_MIN_BYTES (3u << 16) /* of a group for which that is worth its time */

static bool is_zero(const uint8_t *data, size_t size_bytes)
{
    if (size_bytes == 0) return true;
    return data[0] == 0 && memcmp(data, data + 1, size_bytes - 1) == 0;
}

static size_t component_bytes(const struct samples_layout *layout, enum samples_group group)
{
    return (size_t)layout->width_px * (size_t)layout->height_px * samples_element_bytes(group);
}

/* Bits past the last stratum mean nothing; equal samples must give equal bytes. */
static void clear_surplus_bits(struct samples *s)
{
    const size_t area = (size_t)s->layout.width_px * (size_t)s->layout.height_px;
    for (uint32_t k = 0; k < s->layout.light_count; k++) {
        const uint32_t mask = samples_visibility_mask(&s->layout, k);
        if (mask == 0xff) continue;
        uint8_t *last = samples_light_visibility(s, k, (s->layout.light_strata[k] - 1) / 8);
        for (size_t i = 0; last && i < area; i++) last[i] &= (uint8_t)mask;
    }
}

/* Lays out the planes that hold something. Returns how many were dropped. */
static uint64_t layout_of_filled(const struct samples *s, struct samples_layout *filled)
{
    uint64_t dropped = 0;
    *filled = s->layout;
    for (uint32_t i = 0; i < s->layout.slots; i++) {
        if (s->layout.offset[i] == SAMPLES_ABSENT) continue;
        if (!is_zero(s->data + s->layout.offset[i], samples_slot_bytes(&s->layout, i))) continue;
        samples_layout_drop(filled, i);
        dropped++;
    }
    if (!s->lone) filled->planes &= ~PLANE_BIT(LONE);
    if (!s->mixed) filled->planes &= ~PLANE_BIT(MIXED);
    return dropped;
}

/* Copies the planes that both layouts have. */
static void copy_planes(struct samples *to, const struct samples *from)
{
    const uint32_t *a = to->layout.offset, *b = from->layout.offset;
    for (uint32_t i = 0; i < to->layout.slots; i++)
        if (a[i] != SAMPLES_ABSENT && b[i] != SAMPLES_ABSENT)
            memcpy(to->data + a[i], from->data + b[i], samples_slot_bytes(&to->layout, i));
}

static void write_head(struct bytes_writer *w, const struct samples_layout *layout)
{
    bytes_write_u16(w, (uint16_t)layout->width_px);
    bytes_write_u16(w, (uint16_t)layout->height_px);
    bytes_write_u64(w, layout->planes);
    bytes_write_raw(w, layout->light_planes, layout->light_count);
}

/* Writes a list of `count` entries. */
static int write_list(struct bytes_writer *w, const struct sparse_list *list, enum packing packing)
{
    const size_t size_bytes = sparse_list_bytes(list);
    uint8_t *room = malloc(size_bytes + 1);
    if (!room) return ERR_MEMORY;
    const size_t packed =
        packing_pack(packing, PACKING_BYTES, list->words, size_bytes, sizeof *list->words, room);
    bytes_write_u32(w, list->count);
    bytes_write_u32(w, (uint32_t)packed);
    bytes_write_raw(w, room, packed);
    free(room);
    return w->failed ? ERR_MEMORY : 0;
}

static uint32_t group_components(const struct samples_layout *layout, enum samples_group group)
{
    return (uint32_t)(layout->group_bytes[group] / component_bytes(layout, group));
}

/* Filters a group's components, and says by what each. */
static void filter_group(const struct samples_layout *layout, enum samples_group group,
                         const uint8_t *data, uint8_t *filtered, struct bytes_writer *w)
{
    const uint32_t element = samples_element_bytes(group);
    const size_t each = component_bytes(layout, group);
    for (uint32_t c = 0; c < group_components(layout, group); c++) {
        const uint8_t *numbers = data + c * each;
        const enum plane_filter filter =
            plane_filter_choose(numbers, element, layout->width_px, layout->height_px);
        plane_filter_apply(filter, numbers, element, layout->width_px, layout->height_px,
                           filtered + c * each);
        bytes_write_u8(w, (uint8_t)filter);
    }
}

/* Chooses the shuffle by which some rows of a group's components pack best. room has the group's
 * size. */
static enum packing_shuffle choose_shuffle(const struct samples_layout *layout,
                                           enum samples_group group, const uint8_t *data,
                                           uint8_t *room)
{
    const uint32_t element = samples_element_bytes(group);
    const uint32_t count = group_components(layout, group);
    const size_t each = component_bytes(layout, group), row = each / (size_t)layout->height_px;
    const size_t rows = (size_t)layout->height_px / TRIAL_PART, size = count * rows * row;
    const uint8_t *from = data + (size_t)layout->height_px / 2 * row;
    uint8_t *out = room + size;
    if (layout->group_bytes[group] < TRIAL_MIN_BYTES) return PACKING_BYTES;
    for (uint32_t c = 0; c < count; c++) memcpy(room + c * rows * row, from + c * each, rows * row);
    const size_t bits = packing_pack(PACKING_SMALL, PACKING_BITS, room, size, element, out);
    const size_t bytes = packing_pack(PACKING_SMALL, PACKING_BYTES, room, size, element, out);
    return bits < bytes ? PACKING_BITS : PACKING_BYTES;
}

/* filtered, room: of total_bytes each. */
static void write_small(struct bytes_writer *w, const struct samples *s, enum samples_group group,
                        const uint8_t *data, uint8_t *filtered, uint8_t *room)
{
    const uint32_t element = samples_element_bytes(group);
    filter_group(&s->layout, group, data, filtered, w);
    const enum packing_shuffle shuffle = choose_shuffle(&s->layout, group, filtered, room);
    const size_t packed =
        packing_pack(PACKING_SMALL, shuffle, filtered, s->layout.group_bytes[group], element, room);
    bytes_write_u32(w, (uint32_t)packed);
    bytes_write_raw(w, room, packed);
}

static void write_quick(struct bytes_writer *w, const struct samples *s, enum samples_group group,
                        const uint8_t *data, uint8_t *room)
{
    for (uint32_t c = 0; c < group_components(&s->layout, group); c++)
        bytes_write_u8(w, PLANE_FILTER_NONE);
    const size_t packed =
        packing_pack(PACKING_QUICK, PACKING_BYTES, data, s->layout.group_bytes[group],
                     samples_element_bytes(group), room);
    bytes_write_u32(w, (uint32_t)packed);
    bytes_write_raw(w, room, packed);
}

static int write_groups(struct bytes_writer *w, const struct samples *s, enum packing packing)
{
    const size_t size = ((size_t)s->layout.total_bytes + 16) / 16 * 16; /* aligned for numbers */
    uint8_t *room = malloc(packing == PACKING_SMALL ? 2 * size : size);
    const uint8_t *at = s->data;
    if (!room) return ERR_MEMORY;
    for (uint32_t group = 0; group < SAMPLES_GROUP_COUNT; group++) {
        if (packing == PACKING_SMALL)
            write_small(w, s, group, at, room + size, room);
        else
            write_quick(w, s, group, at, room);
        at += s->layout.group_bytes[group];
    }
    free(room);
    return w->failed ? ERR_MEMORY : 0;
}

int samples_pack(struct samples *s, enum packing packing, struct bytes_writer *w, uint64_t *dropped)
{
    struct samples_layout filled;
    struct samples *compact = NULL;
    clear_surplus_bits(s);
    const uint64_t empty = layout_of_filled(s, &filled);
    if (dropped) *dropped = empty;
    if (empty > 0) {
        int error = samples_layout_place(&filled);
        if (!error) error = samples_create(&filled, &compact);
        if (error) return error;
        copy_planes(compact, s);
    }
    write_head(w, &filled);
    int error = write_groups(w, compact ? compact : s, packing);
    if (!error && s->lone) error = write_list(w, s->lone, packing);
    if (!error && s->mixed) error = write_list(w, s->mixed, packing);
    samples_destroy(&compact);
    return error;
}

/* Reads sizes and masks, and lays out the planes that were sent. */
static int read_head(struct bytes_reader *r, const struct plan *plan, uint32_t pass,
                     int32_t width_px, int32_t height_px, struct samples_layout *layout,
                     struct fault *fault)
{
    uint8_t light_planes[LIMIT_LIGHTS] = {0};
    const int32_t width = bytes_read_u16(r), height = bytes_read_u16(r);
    const uint64_t planes = bytes_read_u64(r);
    bytes_read_raw(r, light_planes, plan->light_count);
    if (r->failed) return fault_set(fault, ERR_TRUNCATED, "", "the samples end within their head");
    if (width != width_px || height != height_px)
        return fault_set(fault, ERR_MISMATCH, "", "%d x %d samples for a tile of %d x %d", width,
                         height, width_px, height_px);
    const int error =
        samples_layout_subset(layout, plan, pass, width_px, height_px, planes, light_planes);
    if (error)
        return fault_set(fault, error, "planes",
                         "planes 0x%llx are not all in the plan's 0x%llx for pass %u",
                         (unsigned long long)planes, (unsigned long long)plan->planes, pass);
    return 0;
}

/* A list's head. The count is believed when it is one that a tile can have: at most `most`. */
struct list_head {
    const char *name;
    uint32_t count, packed_bytes;
    const uint8_t *packed;
};

static int read_list_head(struct bytes_reader *r, uint32_t most, struct list_head *h,
                          struct fault *fault)
{
    h->count = bytes_read_u32(r);
    h->packed_bytes = bytes_read_u32(r);
    h->packed = bytes_borrow(r, h->packed_bytes);
    if (r->failed)
        return fault_set(fault, ERR_TRUNCATED, h->name, "its %u bytes are not all there",
                         h->packed_bytes);
    if (h->count == 0 || h->count > most)
        return fault_set(fault, ERR_LIMIT, h->name, "%u entries, not 1 to %u", h->count, most);
    return 0;
}

static int unpack_list(const struct list_head *h, uint32_t *words, size_t size_bytes,
                       struct fault *fault)
{
    if (packing_unpack(h->packed, h->packed_bytes, words, size_bytes)) return 0;
    return fault_set(fault, ERR_CORRUPT, h->name, "%u packed bytes do not unpack to %zu",
                     h->packed_bytes, size_bytes);
}

static int read_list(struct bytes_reader *r, const char *name, uint32_t places, uint32_t values,
                     struct sparse_list **out, struct fault *fault)
{
    struct list_head h = {.name = name};
    const int error = read_list_head(r, places, &h, fault);
    if (error) return error;
    if (sparse_list_create(values, h.count, out) != 0)
        return fault_set(fault, ERR_MEMORY, name, "no memory for %u entries", h.count);
    return unpack_list(&h, (*out)->words, sparse_list_bytes(*out), fault);
}

static int read_lists(struct bytes_reader *r, struct samples *s, struct fault *fault)
{
    const struct samples_layout *l = &s->layout;
    int error = 0;
    if (l->planes & PLANE_BIT(LONE))
        error = read_list(r, "lone", samples_lone_places(l), lone_words(l->lone_parts) - 1,
                          &s->lone, fault);
    if (s->lone) s->lone->parts = l->lone_parts;
    if (!error && l->planes & PLANE_BIT(MIXED))
        error = read_list(r, "mixed", samples_mixed_places(l), l->mixed_values, &s->mixed, fault);
    return error;
}

static const char *const group_names[SAMPLES_GROUP_COUNT] = {"group 4", "group 2", "group 1"};

/* Takes the filters of a group's components off. */
static int undo_filters(const struct samples *s, enum samples_group group, const uint8_t *filters,
                        uint8_t *data, struct fault *fault)
{
    const size_t each = component_bytes(&s->layout, group);
    for (uint32_t c = 0; c < group_components(&s->layout, group); c++) {
        if (filters[c] >= PLANE_FILTER_COUNT)
            return fault_set(fault, ERR_CORRUPT, group_names[group],
                             "component %u: there is no filter %u", c, filters[c]);
        plane_filter_undo(filters[c], data + c * each, samples_element_bytes(group),
                          s->layout.width_px, s->layout.height_px);
    }
    return 0;
}

static int read_group(struct bytes_reader *r, const struct samples *s, enum samples_group group,
                      uint8_t *data, struct fault *fault)
{
    const size_t size_bytes = s->layout.group_bytes[group];
    const uint8_t *filters = bytes_borrow(r, group_components(&s->layout, group));
    const uint32_t packed_bytes = bytes_read_u32(r);
    const uint8_t *packed = bytes_borrow(r, packed_bytes);
    if (r->failed)
        return fault_set(fault, ERR_TRUNCATED, group_names[group], "its %u bytes are not all there",
                         packed_bytes);
    if (!packing_unpack(packed, packed_bytes, data, size_bytes))
        return fault_set(fault, ERR_CORRUPT, group_names[group],
                         "%u packed bytes do not unpack to %zu", packed_bytes, size_bytes);
    return undo_filters(s, group, filters, data, fault);
}

static int read_groups(struct bytes_reader *r, struct samples *s, struct fault *fault)
{
    uint8_t *at = s->data;
    for (uint32_t group = 0; group < SAMPLES_GROUP_COUNT; group++) {
        const int error = read_group(r, s, group, at, fault);
        if (error) return error;
        at += s->layout.group_bytes[group];
    }
    const int error = read_lists(r, s, fault);
    if (error) return error;
    if (bytes_finish(r))
        return fault_set(fault, ERR_TRAILING, "", "%zu bytes follow the samples", bytes_left(r));
    return 0;
}

static void place_group(const struct samples *sent, enum samples_group group, struct samples *all)
{
    for (uint32_t i = 0; i < all->layout.slots; i++) {
        const uint32_t to = all->layout.offset[i], from = sent->layout.offset[i];
        const size_t size_bytes = samples_slot_bytes(&all->layout, i);
        if (to == SAMPLES_ABSENT || samples_group(samples_plane(i)->type) != group) continue;
        if (from == SAMPLES_ABSENT)
            memset(all->data + to, 0, size_bytes);
        else
            memmove(all->data + to, sent->data + from, size_bytes);
    }
}

/* Puts what was sent, which lies at the end of the same memory, among all planes of the pass. They
 * are filled in the order in which they lie: none ends behind where those that follow were sent. */
static void place_all(const struct samples *sent, struct samples *all)
{
    for (uint32_t group = 0; group < SAMPLES_GROUP_COUNT; group++) place_group(sent, group, all);
    all->lone = sent->lone;
    all->mixed = sent->mixed;
}

/* Reads the samples into the end of their memory, checks them and puts them in place. */
static int read_samples(struct bytes_reader *r, const struct samples_layout *layout,
                        struct samples *all, struct fault *fault)
{
    const size_t head = all->layout.total_bytes - layout->total_bytes;
    struct samples sent = {.layout = *layout, .data = all->data + (head + 3) / 4 * 4};
    int error = read_groups(r, &sent, fault);
    if (!error) error = samples_check(&sent, fault);
    if (!error) {
        place_all(&sent, all);
        return 0;
    }
    sparse_list_destroy(&sent.lone);
    sparse_list_destroy(&sent.mixed);
    return error;
}

int samples_unpack(const void *data, size_t size_bytes, const struct plan *plan, uint32_t pass,
                   int32_t width_px, int32_t height_px, struct samples **out, struct fault *fault)
{
    struct bytes_reader r;
    struct samples_layout sent = {0}, all;
    struct samples *s = NULL;
    bytes_reader_init(&r, data, size_bytes);
    int error = read_head(&r, plan, pass, width_px, height_px, &sent, fault);
    if (error) return error;
    /* Sized by the plan and the tile, not by what the bytes declare. Groups fill it, or it goes. */
    error = samples_layout_init(&all, plan, pass, width_px, height_px);
    if (!error) error = samples_create_unset(&all, &s);
    if (error) return fault_set(fault, error, "", "no memory for %u bytes", all.total_bytes);
    error = read_samples(&r, &sent, s, fault);
    if (error) {
        samples_destroy(&s);
        return error;
    }
    *out = s;
    return 0;
}
