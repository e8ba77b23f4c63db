#pragma once
/* What a kernel computes, counted instruction by instruction: the processor traps after each (its
 * trap flag), and the one that comes next is looked at. So counts are of what runs, in whichever
 * instruction set, and cannot fall behind the code.
 *
 * Counted are numbers that arithmetic works on: an addition, subtraction, multiplication, minimum,
 * maximum or comparison is one operation a lane, a fused multiplication and addition two, and one
 * of `fused`; divisions and square roots are counted by themselves, and so are additions,
 * multiplications, shifts and comparisons of whole numbers in vectors. Lanes that a mask throws
 * away count: they are computed. Conversions, logic, shuffles and loads are no arithmetic, but take
 * slots of the vector units as well: those are counted, too, one an instruction that does more than
 * move to or from memory. */
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <ucontext.h>
#include <x86intrin.h>

#define PROBE_TRAP UINT64_C(0x100)

struct probe_counts {
    double operations, fused, whole, divisions, roots, slots, instructions;
};

static struct probe_counts probe_found;
static volatile sig_atomic_t probe_on;

struct probe_instruction {
    int map, prefix; /* 1: 0F, 2: 0F 38; 0 none, 1: 66, 2: F3, 3: F2 */
    int length;      /* of vectors: 0 .. 2 of 128, 256, 512 bits */
    bool wide;       /* W */
    uint8_t code;
    bool memory; /* has an operand there */
};

/* Prefixes of the old encoding, then 0F and a map. */
static inline void probe_read_old(const uint8_t *p, struct probe_instruction *out)
{
    bool repeat = false;
    for (;; p++) {
        if (*p == 0xf3 || *p == 0xf2)
            out->prefix = *p == 0xf3 ? 2 : 3, repeat = true;
        else if (*p == 0x66 && !repeat)
            out->prefix = 1;
        else if (*p != 0x66 && *p != 0x2e && *p != 0x3e && *p != 0x64 && *p != 0x65)
            break;
    }
    if ((*p & 0xf0) == 0x40) p++; /* REX */
    if (*p != 0x0f) return;
    out->map = p[1] == 0x38 ? 2 : p[1] == 0x3a ? 3 : 1;
    out->code = out->map == 1 ? p[1] : p[2];
    out->memory = p[out->map == 1 ? 2 : 3] < 0xc0;
}

static inline struct probe_instruction probe_read(const uint8_t *p)
{
    struct probe_instruction i = {0};
    if (p[0] == 0xc5)
        i = (struct probe_instruction){1, p[1] & 3, p[1] >> 2 & 1, false, p[2], p[3] < 0xc0};
    else if (p[0] == 0xc4)
        i = (struct probe_instruction){p[1] & 31, p[2] & 3, p[2] >> 2 & 1,
                                       p[2] >> 7, p[3],     p[4] < 0xc0};
    else if (p[0] == 0x62)
        i = (struct probe_instruction){p[1] & 7,  p[2] & 3, p[3] >> 5 & 3,
                                       p[2] >> 7, p[4],     p[5] < 0xc0};
    else
        probe_read_old(p, &i);
    return i;
}

/* Does it work on whole numbers in vectors? */
static inline bool probe_is_whole(const struct probe_instruction *i)
{
    const uint8_t c = i->code;
    if (i->prefix != 1) return false;
    if (i->map == 1) /* compare, shift, add, subtract, multiply */
        return (c >= 0x64 && c <= 0x66) || (c >= 0x74 && c <= 0x76) || (c >= 0x71 && c <= 0x73) ||
               (c >= 0xd1 && c <= 0xd5) || (c >= 0xe1 && c <= 0xe5) || (c >= 0xf1 && c <= 0xf5) ||
               (c >= 0xf8 && c <= 0xfe);
    if (i->map == 2) /* compare, multiply, least, most, magnitude, shift by lanes */
        return c == 0x29 || c == 0x37 || c == 0x28 || (c >= 0x38 && c <= 0x40) ||
               (c >= 0x1c && c <= 0x1e) || (c >= 0x45 && c <= 0x47);
    return i->map == 3 && (c == 0x1e || c == 0x1f || c == 0x3e || c == 0x3f);
}

/* Does it take a slot of the vector units: is it of vectors, and no load, store or move? Moves of
 * masks and looks at them are left out. */
static inline bool probe_takes_slot(const struct probe_instruction *i)
{
    const uint8_t c = i->code;
    if (i->map == 0 || i->map > 3) return false;
    if (i->map == 1)
        return !(c < 0x10 || c == 0x10 || c == 0x11 || c == 0x28 || c == 0x29 || c == 0x2b ||
                 c == 0x6f || c == 0x77 || c == 0x7f || c == 0xe7 || (c >= 0x18 && c <= 0x1f) ||
                 (c >= 0x40 && c < 0x50 && i->length == 0 && i->prefix != 1) ||
                 (c >= 0x80 && c < 0xc2));
    if (i->map == 2) /* broadcasts of memory are loads; from 0xf0 on: of general registers */
        return !(i->memory && ((c >= 0x18 && c <= 0x1b) || (c >= 0x58 && c <= 0x5b))) && c < 0xf0;
    return c < 0xf0;
}

static inline void probe_count(const struct probe_instruction *i)
{
    probe_found.slots += probe_takes_slot(i);
    if (probe_is_whole(i)) probe_found.whole += 4 << i->length;
    const double lanes = i->prefix == 0 ? 4 << i->length : i->prefix == 1 ? 2 << i->length : 1;
    const int low = i->code & 15, high = i->code >> 4;
    if (i->map == 1) {
        switch (i->code) {
        case 0x58: /* add */
        case 0x59: /* mul */
        case 0x5c: /* sub */
        case 0x5d: /* min */
        case 0x5f: /* max */
        case 0xc2: /* cmp */
            probe_found.operations += lanes;
            break;
        case 0x2e: /* ucomis, comis */
        case 0x2f:
            probe_found.operations += 1;
            break;
        case 0x5e:
            probe_found.divisions += lanes;
            break;
        case 0x51:
            probe_found.roots += lanes;
            break;
        default:
            break;
        }
    } else if (i->map == 2 && i->prefix == 1 && low >= 6 &&
               (high == 9 || high == 10 || high == 11)) {
        const bool scalar = low >= 8 && (low & 1);
        const double many = scalar ? 1 : (i->wide ? 2 : 4) << i->length;
        probe_found.operations += 2 * many;
        probe_found.fused += many;
    }
}

static void probe_trapped(int signal, siginfo_t *info, void *context)
{
    ucontext_t *c = context;
    (void)signal, (void)info;
    if (!probe_on) {
        c->uc_mcontext.gregs[REG_EFL] &= ~(long long)PROBE_TRAP;
        return;
    }
    const struct probe_instruction next =
        probe_read((const uint8_t *)(uintptr_t)c->uc_mcontext.gregs[REG_RIP]);
    probe_count(&next);
    probe_found.instructions++;
}

static inline void probe_begin(void)
{
    const struct sigaction action = {.sa_sigaction = probe_trapped, .sa_flags = SA_SIGINFO};
    sigaction(SIGTRAP, &action, NULL);
    probe_on = 1;
    __asm__ volatile("" ::: "memory"); /* counts change behind the compiler's back */
    __writeeflags(__readeflags() | PROBE_TRAP);
}

static inline void probe_end(void)
{
    __asm__ volatile("" ::: "memory");
    probe_on = 0; /* the next trap is the last */
    __asm__ volatile("" ::: "memory");
}

/* -- the probe on instructions whose counts are known -- */

static inline bool probe_counts_are(double operations, double fused, double divisions, double roots,
                                    double whole, double slots)
{
    const struct probe_counts c = probe_found;
    probe_found = (struct probe_counts){0};
    return c.operations == operations && c.fused == fused && c.divisions == divisions &&
           c.roots == roots && c.whole == whole && c.slots == slots;
}

static inline bool probe_is_right(const char *isa)
{
    probe_found = (struct probe_counts){0};
    probe_begin();
    __asm__ volatile("addps %%xmm1, %%xmm0\n mulsd %%xmm9, %%xmm8\n minps %%xmm1, %%xmm2\n"
                     "ucomiss %%xmm1, %%xmm0\n cmpltps %%xmm1, %%xmm2\n andps %%xmm1, %%xmm2\n"
                     "divps %%xmm1, %%xmm3\n sqrtss %%xmm1, %%xmm4\n paddd %%xmm1, %%xmm4" ::
                         : "xmm0", "xmm2", "xmm3", "xmm4", "xmm8", "cc", "memory");
    probe_end();
    if (!probe_counts_are(4 + 1 + 4 + 1 + 4, 0, 4, 1, 4, 9)) return false;
    if (!strcmp(isa, "sse4.2")) return true;
    probe_begin();
    __asm__ volatile("vaddps %%ymm1, %%ymm0, %%ymm2\n vmulpd %%ymm9, %%ymm8, %%ymm10\n"
                     "vfmadd231ps %%ymm1, %%ymm0, %%ymm2\n vfmadd231sd %%xmm1, %%xmm0, %%xmm2\n"
                     "vdivps %%ymm1, %%ymm0, %%ymm3\n vsqrtpd %%ymm1, %%ymm4\n"
                     "vpmulld %%ymm1, %%ymm0, %%ymm2\n vmovups %%ymm2, -32(%%rsp)\n"
                     "vbroadcastss -32(%%rsp), %%ymm2\n vmovaps %%ymm2, %%ymm3" ::
                         : "xmm2", "xmm3", "xmm4", "xmm10", "memory");
    probe_end();
    if (!probe_counts_are(8 + 4 + 16 + 2, 8 + 1, 8, 4, 8, 7)) return false;
    if (strcmp(isa, "avx512") != 0) return true;
    probe_begin();
    __asm__ volatile("vaddps %%zmm1, %%zmm0, %%zmm18\n vmulpd %%zmm1, %%zmm0, %%zmm2\n"
                     "vfmadd231ps %%zmm1, %%zmm0, %%zmm2\n vcmpps $1, %%zmm1, %%zmm0, %%k1\n"
                     "vdivps %%zmm1, %%zmm0, %%zmm3\n vsqrtps %%zmm1, %%zmm4\n"
                     "vpaddd %%zmm1, %%zmm0, %%zmm4\n vpermps %%zmm1, %%zmm0, %%zmm4" ::
                         : "xmm2", "xmm3", "xmm4", "memory");
    probe_end();
    return probe_counts_are(16 + 8 + 32 + 16, 16, 16, 16, 16, 8);
}
