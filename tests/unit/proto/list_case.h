#pragma once
/* Sparse lists beside the planes of a tile of 7 x 3 pixels: what holds of both kinds. */
#include <string.h>

#include "tests/unit/proto/samples_case.h"
#include "tests/unit/unit.h"

enum { LIST_WIDTH = 7, LIST_HEIGHT = 3 };

struct list_case {
    const char *name; /* of the list, in faults */
    uint64_t planes;  /* the bits of lists in plans */
    uint32_t places;
    /* Adds `count` entries to samples, which have none. */
    void (*fill)(struct samples *s, uint32_t count);
    struct plan plan; /* light fields alone */
    enum packing packing;
};

/* Sets the plan. */
void list_case_begin(struct list_case *c);

struct samples *list_case_create(const struct list_case *c, uint32_t count);

void list_case_pack(const struct list_case *c, struct samples *s, struct bytes_writer *w);

/* Unpacks out of memory of exactly the size, so that a sanitizer sees a read beyond. */
int list_case_unpack(const struct list_case *c, const uint8_t *data, size_t size_bytes,
                     struct samples **out, struct fault *fault);

/* Expects that samples come back as they are, and frees them. */
void list_case_round_trip(const struct list_case *c, struct samples *s);

/* ... of 0 to all entries. */
void list_case_round_trips(const struct list_case *c);

/* Neither count nor size decides what is allocated or written. */
void list_case_believe_no_size(struct list_case *c);

/* Lists that are cut or not asked for fail, and so do bytes after them. */
void list_case_cut(struct list_case *c);

/* Packs 9 entries after a change of samples `s`, and expects a fault. */
#define LIST_EXPECT(c, change, expected, place)                                                    \
    do {                                                                                           \
        struct bytes_writer w;                                                                     \
        struct samples *back, *s;                                                                  \
        struct fault fault = {0};                                                                  \
        list_case_begin(c);                                                                        \
        s = list_case_create(c, 9);                                                                \
        change;                                                                                    \
        list_case_pack(c, s, &w);                                                                  \
        const int error = list_case_unpack(c, w.data, w.size_bytes, &back, &fault);                \
        if (error != (expected) || strcmp(fault.pointer, place) != 0)                              \
            fail_msg(#change " gives %s at \"%s\": %s", error_name(error), fault.pointer,          \
                     fault.detail);                                                                \
        samples_destroy(&back);                                                                    \
        bytes_writer_fini(&w);                                                                     \
        samples_destroy(&s);                                                                       \
    } while (0)
