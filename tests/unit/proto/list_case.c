#include "tests/unit/proto/list_case.h"

#define NUMBER_OF(list) (sizeof(list) / sizeof *(list))

void list_case_begin(struct list_case *c)
{
    plan_case(&c->plan);
    c->plan.camera.aperture_radius = 0.0f;
    c->plan.paths = (struct plan_paths){0};
    c->plan.lens_strata_per_axis = c->plan.lens_relight = 0;
    c->plan.planes = (c->plan.planes & ~(PLANES_PATH | PLANES_LENS_ALL)) | c->planes;
}

struct samples *list_case_create(const struct list_case *c, uint32_t count)
{
    struct samples_layout layout;
    struct samples *s;
    assert_int_equal(samples_layout_init(&layout, &c->plan, 0, LIST_WIDTH, LIST_HEIGHT), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    samples_case_fill(s, UINT64_MAX, 15, 1);
    for (uint32_t k = 0; k < 3; k++) /* all show a surface */
        for (size_t i = 0; i < LIST_WIDTH * LIST_HEIGHT; i++)
            samples_u16(s, PLANE_SUB_DEPTH, k)[i] = 0;
    if (count > 0) c->fill(s, count);
    return s;
}

void list_case_pack(const struct list_case *c, struct samples *s, struct bytes_writer *w)
{
    bytes_writer_init(w);
    assert_int_equal(samples_pack(s, c->packing, w, NULL), 0);
}

int list_case_unpack(const struct list_case *c, const uint8_t *data, size_t size_bytes,
                     struct samples **out, struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    *out = NULL;
    const int error =
        samples_unpack(exact, size_bytes, &c->plan, 0, LIST_WIDTH, LIST_HEIGHT, out, fault);
    assert_true((error == 0) == (*out != NULL));
    free(exact);
    return error;
}

static void expect_same(const struct sparse_list *back, const struct sparse_list *list)
{
    assert_true((back == NULL) == (list == NULL));
    if (!list) return;
    assert_int_equal(back->count, list->count);
    assert_int_equal(back->parts, list->parts);
    assert_int_equal(back->values, list->values);
    assert_memory_equal(back->words, list->words, sparse_list_bytes(list));
}

void list_case_round_trip(const struct list_case *c, struct samples *s)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    list_case_pack(c, s, &w);
    if (list_case_unpack(c, w.data, w.size_bytes, &back, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_memory_equal(&back->layout, &s->layout, sizeof s->layout);
    assert_memory_equal(back->data, s->data, s->layout.total_bytes);
    assert_int_equal(samples_bytes(back), s->layout.total_bytes + sparse_list_bytes(s->lone) +
                                              sparse_list_bytes(s->mixed));
    expect_same(back->lone, s->lone);
    expect_same(back->mixed, s->mixed);
    samples_destroy(&back);
    samples_destroy(&s);
    bytes_writer_fini(&w);
}

void list_case_round_trips(const struct list_case *c)
{
    const uint32_t counts[] = {0, 1, 2, 17, c->places};
    for (size_t i = 0; i < NUMBER_OF(counts); i++)
        list_case_round_trip(c, list_case_create(c, counts[i]));
}

/* The list's head lies before its packed bytes, which end the samples. */
static size_t head_of(const struct bytes_writer *w)
{
    for (size_t packed = 1; packed + 8 <= w->size_bytes; packed++) {
        uint32_t words[2];
        memcpy(words, w->data + w->size_bytes - packed - 8, sizeof words);
        if (words[0] == 9 && words[1] == packed) return w->size_bytes - packed - 8;
    }
    fail_msg("no list at the end");
    return 0;
}

void list_case_believe_no_size(struct list_case *c)
{
    const uint32_t counts[] = {0, 8, 10, c->places, c->places + 1, 0x7fffffff, 0xffffffff};
    static const uint32_t sizes[] = {0, 1, 15, 0x7fffffff, 0xffffffff};
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    list_case_begin(c);
    struct samples *s = list_case_create(c, 9);
    list_case_pack(c, s, &w);
    const size_t head = head_of(&w);
    for (size_t i = 0; i < NUMBER_OF(counts); i++) {
        const bool possible = counts[i] > 0 && counts[i] <= c->places;
        memcpy(w.data + head, &counts[i], 4);
        assert_int_equal(list_case_unpack(c, w.data, w.size_bytes, &back, &fault),
                         possible ? ERR_CORRUPT : ERR_LIMIT);
        assert_string_equal(fault.pointer, c->name);
    }
    memcpy(w.data + head, &(uint32_t){9}, 4);
    for (size_t i = 0; i < NUMBER_OF(sizes); i++) {
        memcpy(w.data + head + 4, &sizes[i], 4);
        assert_true(list_case_unpack(c, w.data, w.size_bytes, &back, &fault) != 0);
        assert_string_equal(fault.pointer, c->name);
    }
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

void list_case_cut(struct list_case *c)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    list_case_begin(c);
    struct samples *s = list_case_create(c, 9);
    list_case_pack(c, s, &w);
    for (size_t size_bytes = head_of(&w); size_bytes < w.size_bytes; size_bytes++)
        assert_int_equal(list_case_unpack(c, w.data, size_bytes, &back, &fault), ERR_TRUNCATED);
    const uint64_t planes = c->plan.planes;
    c->plan.planes &= ~c->planes; /* not asked for */
    assert_int_equal(list_case_unpack(c, w.data, w.size_bytes, &back, &fault), ERR_RANGE);
    c->plan.planes = planes;
    bytes_write_u8(&w, 0);
    assert_int_equal(list_case_unpack(c, w.data, w.size_bytes, &back, &fault), ERR_TRAILING);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}
