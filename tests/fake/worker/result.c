#include "tests/fake/worker/result.h"

#include <math.h>

#include "proto/samples.h"
#include "tests/fake/worker/link.h"

static const struct plan *plan_of(const struct fake *f, uint64_t frame_id)
{
    for (uint64_t i = 0; i < FAKE_FRAMES && i < f->frame_count; i++)
        if (f->frames[i].id == frame_id) return &f->frames[i].plan;
    return NULL;
}

static void put_nan(struct samples *s)
{
    const uint16_t half_nan = 0x7e00;
    if (s->layout.planes & PLANE_BIT(DEPTH))
        samples_f32(s, PLANE_DEPTH, 0)[0] = NAN;
    else if (s->layout.planes & PLANES_PATH)
        samples_f32(s, (enum plane_id)__builtin_ctz(s->layout.planes & PLANES_PATH), 0)[0] = NAN;
    else if (s->layout.planes & PLANE_BIT(EMISSION))
        samples_u16(s, PLANE_EMISSION, 0)[0] = half_nan;
    else if (s->layout.planes & PLANE_BIT(INDIRECT_MEAN))
        samples_u16(s, PLANE_INDIRECT_MEAN, 0)[0] = half_nan;
    else
        samples_light_irradiance(s, 0)[0] = NAN;
}

/* Lone sub-samples whose places do not ascend, or whose light is not finite, by turns. */
static void put_lone(struct samples *s, uint64_t turn)
{
    if (s->layout.lone_parts == 0 || lone_create(s->layout.lone_parts, 2, &s->lone) != 0) return;
    s->lone->words[1] = turn % 2;
    for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
        if (turn % 2 && lone_values(s->lone, part, 0)) lone_values(s->lone, part, 0)[1] = INFINITY;
}

void result_pack(struct fake *f, const struct message_tile *tile, int32_t width, int32_t height,
                 enum lie lie, struct bytes_writer *out)
{
    struct samples_layout layout;
    struct samples *s = NULL;
    uint64_t dropped = 0;
    const struct plan *plan = plan_of(f, tile->frame_id);
    bytes_writer_init(out);
    if (!plan || samples_layout_init(&layout, plan, tile->pass.number, width, height) != 0 ||
        samples_create(&layout, &s) != 0)
        return;
    if (lie == LIE_NAN) put_nan(s);
    if (lie == LIE_LONE) put_lone(s, f->answers);
    samples_pack(s, PACKING_QUICK, out, &dropped);
    samples_destroy(&s);
}

void result_send(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                 const struct bytes_writer *packed)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = (uint32_t)packed->size_bytes};
    message_encode_result(&w, &m);
    f->answers++;
    link_send_message(f, MESSAGE_RESULT, request_id, &w, packed->data, packed->size_bytes);
}

/* Packed once for a frame and size: an echo must be cheaper than what it measures. */
const struct bytes_writer *result_zero_samples(struct fake *f, const struct message_tile *tile)
{
    int32_t width = rect_width(tile->rect), height = rect_height(tile->rect);
    if (f->packed.data && f->packed_frame == tile->frame_id &&
        f->packed_pass == tile->pass.number && f->packed_width == width &&
        f->packed_height == height)
        return &f->packed;
    bytes_writer_fini(&f->packed);
    result_pack(f, tile, width, height, LIE_NONE, &f->packed);
    f->packed_frame = tile->frame_id;
    f->packed_pass = tile->pass.number;
    f->packed_width = width;
    f->packed_height = height;
    return &f->packed;
}

void result_whole(struct fake *f, uint64_t request_id, const struct message_tile *tile,
                  struct bytes_writer *whole)
{
    const struct bytes_writer *packed = result_zero_samples(f, tile);
    struct bytes_writer head;
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    bytes_writer_init(&head);
    bytes_writer_init(whole);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = (uint32_t)packed->size_bytes};
    message_encode_result(&head, &m);
    wire_frame_header(header, MESSAGE_RESULT, request_id, head.data, (uint32_t)head.size_bytes,
                      packed->data, (uint32_t)packed->size_bytes);
    bytes_write_raw(whole, header, sizeof header);
    bytes_write_raw(whole, head.data, head.size_bytes);
    bytes_write_raw(whole, packed->data, packed->size_bytes);
    bytes_writer_fini(&head);
}
