#pragma once
/* What an instruction of vectors reads from memory or writes there: how many bytes, where, and
 * whether they lie across two cache lines. What lies beside the code is left out, and so are
 * numbers in general registers; roofline_probe.h leaves out the stack. After Intel's manual, volume
 * 2, chapter 2: ModR/M, SIB, displacements, which EVEX scales by what is accessed. Compressions,
 * expansions, scatters and moves of single words, which no kernel has, are not told apart. */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <ucontext.h>

#define ACCESS_LINE 64

struct probe_instruction {
    int map, prefix; /* 1: 0F, 2: 0F 38; 0 none, 1: 66, 2: F3, 3: F2 */
    int length;      /* of vectors: 0 .. 2 of 128, 256, 512 bits */
    bool wide;       /* W */
    uint8_t code;
    bool memory;          /* has an operand there */
    const uint8_t *modrm; /* NULL: no vectors */
    int base, index;      /* 8: of the upper registers */
    bool scaled, repeats; /* EVEX: displacements of one byte are scaled; one number for all lanes */
};

struct access {
    int bytes, count; /* 0: none; of gathers one a lane */
    bool writes;
    uintptr_t at;
};

/* Of 0F: arithmetic, moves, comparisons; not cmov, jumps, moves of masks, bit operations, emms and
 * vzeroupper, which have no operand. */
static inline bool access_is_vector(const struct probe_instruction *i)
{
    const uint8_t c = i->code;
    if (!i->modrm || i->map == 0 || i->map > 3) return false;
    if (i->map > 1) return c < 0xf0;
    return (c >= 0x10 && c <= 0x17) || (c >= 0x28 && c <= 0x2f) ||
           (c >= 0x50 && c <= 0x7f && c != 0x77) || c == 0xc2 || (c >= 0xc4 && c <= 0xc6) ||
           c >= 0xd0;
}

/* Numbers from wherever lanes say. */
static inline bool access_gathers(const struct probe_instruction *i)
{
    return i->map == 2 && i->code >= 0x90 && i->code < 0x94;
}

static inline int access_bytes_1(const struct probe_instruction *i, int all)
{
    const uint8_t c = i->code;
    const int number = i->wide ? 8 : 4;
    if (c == 0x13 || c == 0x17 || c == 0xd6) return 8;
    if (c == 0x12 && i->prefix == 3) return i->length == 0 ? 8 : all; /* each other number, twice */
    if (c == 0x12 || c == 0x16) return i->prefix < 2 ? 8 : all;
    if (c == 0x2e || c == 0x2f) return i->prefix ? 8 : 4;
    if (c == 0x2a || c == 0x6e || (c == 0x7b && i->prefix >= 2)) return number;
    if (c == 0x7e) return i->prefix == 2 ? 8 : number;
    if (c == 0xe6) return i->prefix == 2 ? all / 2 : all;
    if (c == 0x5a && i->prefix == 0) return all / 2;
    if (c == 0x5b) return all;
    if (c < 0x60 || c == 0xc2) return i->prefix == 2 ? 4 : i->prefix == 3 ? 8 : all;
    if (c >= 0xd0 && c != 0xe3 && (c & 15) >= 1 && (c & 15) <= 3)
        return 16; /* shifts by a vector's first */
    return all;
}

static inline int access_bytes_2(const struct probe_instruction *i, int all)
{
    static const uint8_t parts[6] = {2, 4, 8, 2, 4, 2}; /* bytes to words, ... */
    const uint8_t c = i->code, low = c & 15, high = c >> 4;
    if (i->prefix == 2 && high >= 1 && high <= 3 && low < 6) return all / parts[low];
    if (c == 0x18 || c == 0x58) return 4;
    if (c == 0x19 || c == 0x59) return 8;
    if (c == 0x1a || c == 0x5a) return 16;
    if (c == 0x1b || c == 0x5b) return 32;
    if (c == 0x78 || c == 0x79) return c - 0x77;
    if (c == 0x13 && i->prefix == 1) return all / 2;
    if ((high == 2 || high == 3) && low < 6) return all / parts[low];
    if (access_gathers(i)) return c & 1 ? 8 : 4;
    if (high >= 9 && high <= 11 && low >= 9 && (low & 1)) return i->wide ? 8 : 4;
    return all;
}

static inline int access_bytes_3(const struct probe_instruction *i, int all)
{
    const uint8_t c = i->code;
    if (c == 0x14 || c == 0x15 || c == 0x20) return c == 0x15 ? 2 : 1;
    if (c == 0x16 || c == 0x22) return i->wide ? 8 : 4;
    if (c == 0x17 || c == 0x21 || c == 0x0a) return 4;
    if (c == 0x0b) return 8;
    if (c == 0x18 || c == 0x38 || c == 0x19 || c == 0x39) return 16;
    if (c == 0x1a || c == 0x3a || c == 0x1b || c == 0x3b) return 32;
    return c == 0x1d ? all / 2 : all;
}

static inline int access_bytes(const struct probe_instruction *i)
{
    const int all = 16 << i->length;
    if (i->repeats) return i->wide ? 8 : 4;
    return i->map == 1   ? access_bytes_1(i, all)
           : i->map == 2 ? access_bytes_2(i, all)
                         : access_bytes_3(i, all);
}

static inline bool access_writes(const struct probe_instruction *i)
{
    const uint8_t c = i->code;
    if (i->map == 1)
        return c == 0x11 || c == 0x13 || c == 0x17 || c == 0x29 || c == 0x2b || c == 0x7f ||
               c == 0xd6 || c == 0xe7 || (c == 0x7e && i->prefix == 1);
    if (i->map == 2)
        return c == 0x2e || c == 0x2f || c == 0x8a || c == 0x8b || c == 0x8e ||
               (i->prefix == 2 && c >= 0x10 && c < 0x40);
    return (c >= 0x14 && c <= 0x17) || c == 0x19 || c == 0x39 || c == 0x1b || c == 0x3b ||
           c == 0x1d;
}

static inline uintptr_t access_register(const ucontext_t *c, int number)
{
    static const int order[16] = {REG_RAX, REG_RCX, REG_RDX, REG_RBX, REG_RSP, REG_RBP,
                                  REG_RSI, REG_RDI, REG_R8,  REG_R9,  REG_R10, REG_R11,
                                  REG_R12, REG_R13, REG_R14, REG_R15};
    return (uintptr_t)c->uc_mcontext.gregs[order[number]];
}

/* The address; false: beside the code, or a number alone. */
static inline bool access_find(const struct probe_instruction *i, const ucontext_t *c, int bytes,
                               uintptr_t *at)
{
    enum { NO_INDEX = 4, NO_BASE = 5 };
    const uint8_t *m = i->modrm;
    const int mod = *m >> 6;
    const bool sib = (*m & 7) == 4;
    int base = (*m & 7) | i->base;
    uintptr_t more = 0;
    if (mod == 3 || (mod == 0 && (*m & 7) == NO_BASE)) return false;
    if (sib) {
        const int index = (m[1] >> 3 & 7) | i->index;
        base = (m[1] & 7) | i->base;
        if (index != NO_INDEX && !access_gathers(i))
            more = access_register(c, index) << (m[1] >> 6);
        if ((m[1] & 7) == NO_BASE && mod == 0) return false; /* a number alone */
    }
    const uint8_t *number = m + 1 + sib;
    int32_t far = 0;
    if (mod == 1) far = (int8_t)*number * (i->scaled ? bytes : 1);
    if (mod == 2) memcpy(&far, number, sizeof far);
    *at = access_register(c, base) + more + (uintptr_t)(intptr_t)far;
    return true;
}

static inline struct access access_of(const struct probe_instruction *i, const ucontext_t *c)
{
    struct access out = {0};
    if (!access_is_vector(i) || !i->memory) return out;
    const int bytes = access_bytes(i);
    if (!access_find(i, c, bytes, &out.at)) return out;
    const bool gathers = access_gathers(i);
    if (gathers) out.at = 0; /* wherever */
    out.bytes = bytes;
    out.count = gathers ? (16 << i->length) / (i->wide || (i->code & 1) ? 8 : 4) : 1;
    out.writes = access_writes(i);
    return out;
}

/* Lines that loads bring: of those across two, both. */
static inline int access_lines(const struct access *a)
{
    return a->count * ((int)(a->at % ACCESS_LINE) + a->bytes > ACCESS_LINE ? 2 : 1);
}
