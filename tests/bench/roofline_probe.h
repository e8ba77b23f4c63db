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
 * move to or from memory. What they read and write in the first cache is counted by itself
 * (roofline_access.h). */
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <ucontext.h>
#include <x86intrin.h>

#include "tests/bench/roofline_access.h"

#define PROBE_TRAP UINT64_C(0x100)

struct probe_counts {
    double operations, fused, whole, divisions, roots, slots, instructions;
    /* In the first cache, off the stack: lines that are read; vectors that are written, of whole
     * lines and narrower ones. */
    double loads, stores, narrow;
};

static struct probe_counts probe_found;
static volatile sig_atomic_t probe_on;
static uintptr_t probe_stack; /* where that of what is looked at begins: it grows down */

/* Prefixes of the old encoding, then 0F and a map. */
static inline void probe_read_old(const uint8_t *p, struct probe_instruction *out)
{
    bool repeat = false;
    uint8_t rex = 0;
    for (;; p++) {
        if (*p == 0xf3 || *p == 0xf2)
            out->prefix = *p == 0xf3 ? 2 : 3, repeat = true;
        else if (*p == 0x66 && !repeat)
            out->prefix = 1;
        else if (*p != 0x66 && *p != 0x2e && *p != 0x3e && *p != 0x64 && *p != 0x65)
            break;
    }
    if ((*p & 0xf0) == 0x40) rex = *p++;
    if (*p != 0x0f) return;
    out->map = p[1] == 0x38 ? 2 : p[1] == 0x3a ? 3 : 1;
    out->code = out->map == 1 ? p[1] : p[2];
    out->wide = rex >> 3 & 1;
    out->modrm = p + (out->map == 1 ? 2 : 3);
    out->base = rex << 3 & 8;
    out->index = rex << 2 & 8;
    out->memory = *out->modrm < 0xc0;
}

/* Bits that extend registers are kept upside down. */
static inline struct probe_instruction probe_read(const uint8_t *p)
{
    struct probe_instruction i = {0};
    if (p[0] == 0xc5)
        i = (struct probe_instruction){
            .map = 1, .prefix = p[1] & 3, .length = p[1] >> 2 & 1, .code = p[2], .modrm = p + 3};
    else if (p[0] == 0xc4)
        i = (struct probe_instruction){.map = p[1] & 31,
                                       .prefix = p[2] & 3,
                                       .length = p[2] >> 2 & 1,
                                       .wide = p[2] >> 7,
                                       .code = p[3],
                                       .modrm = p + 4,
                                       .base = ~p[1] >> 2 & 8,
                                       .index = ~p[1] >> 3 & 8};
    else if (p[0] == 0x62)
        i = (struct probe_instruction){.map = p[1] & 7,
                                       .prefix = p[2] & 3,
                                       .length = p[3] >> 5 & 3,
                                       .wide = p[2] >> 7,
                                       .code = p[4],
                                       .modrm = p + 5,
                                       .base = ~p[1] >> 2 & 8,
                                       .index = ~p[1] >> 3 & 8,
                                       .scaled = true,
                                       .repeats = p[3] >> 4 & 1};
    else
        probe_read_old(p, &i);
    i.memory = i.modrm && *i.modrm < 0xc0;
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

/* What a kernel keeps on its stack does not count, in whichever register its place is: compilers
 * keep numbers there for want of registers. */
static inline void probe_count_access(const struct access *a, uintptr_t stack_end)
{
    enum { RED_ZONE = 128 };
    if (a->at >= stack_end - RED_ZONE && a->at < probe_stack) return;
    if (!a->writes)
        probe_found.loads += access_lines(a);
    else if (a->bytes < ACCESS_LINE)
        probe_found.narrow += a->count;
    else
        probe_found.stores += a->count;
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
    const struct access access = access_of(&next, c);
    probe_count(&next);
    if (access.count) probe_count_access(&access, (uintptr_t)c->uc_mcontext.gregs[REG_RSP]);
    probe_found.instructions++;
}

static inline void probe_begin(void)
{
    const struct sigaction action = {.sa_sigaction = probe_trapped, .sa_flags = SA_SIGINFO};
    sigaction(SIGTRAP, &action, NULL);
    probe_stack = (uintptr_t)__builtin_frame_address(0) + 2 * sizeof(void *);
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

/* Lines that are read and vectors that are written, where they are known, too; the stack's and
 * those beside the code are none. */
static inline bool probe_accesses_are(double loads, double stores, double narrow)
{
    const struct probe_counts c = probe_found;
    probe_found = (struct probe_counts){0};
    return c.loads == loads && c.stores == stores && c.narrow == narrow;
}

static inline bool probe_finds_accesses(const char *isa)
{
    static _Alignas(64) char lines[512];
    char *const at = lines;
    const uintptr_t index = 4;
    probe_begin();
    __asm__ volatile(
        "movups (%0), %%xmm0\n movups 56(%0), %%xmm1\n addps 64(%0,%1,8), %%xmm0\n"
        "movss 62(%0), %%xmm2\n movaps %%xmm0, 128(%0)\n movups -16(%%rsp), %%xmm3\n"
        "movl (%0), %%eax\n movlps %%xmm0, 60(%0)\n movddup 56(%0), %%xmm1\n"
        "lea -64(%%rsp), %%rax\n movups (%%rax), %%xmm3\n movups %%xmm3, 16(%%rax)" ::"r"(at),
        "r"(index)
        : "xmm0", "xmm1", "xmm2", "xmm3", "rax", "memory");
    probe_end();
    if (!probe_accesses_are(1 + 2 + 1 + 2 + 1, 0, 2)) return false;
    if (!strcmp(isa, "sse4.2")) return true;
    probe_begin();
    __asm__ volatile(
        "mov %0, %%r13\n vmovups (%%r13), %%ymm0\n vaddps 40(%0), %%ymm0, %%ymm0\n"
        "vbroadcastss 61(%0), %%ymm1\n vpmovzxbd 56(%0), %%ymm2\n"
        "vmovups %%ymm0, 48(%0)\n vextractf128 $1, %%ymm0, (%0)\n"
        "vpxor %%xmm3, %%xmm3, %%xmm3\n vpcmpeqd %%ymm4, %%ymm4, %%ymm4\n"
        "vgatherdps %%ymm4, (%0,%%ymm3,4), %%ymm5\n vzeroupper\n lea (%0), %%rcx" ::"r"(at)
        : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "r13", "rcx", "memory");
    probe_end();
    if (!probe_accesses_are(1 + 2 + 2 + 1 + 8, 0, 2)) return false;
    if (strcmp(isa, "avx512") != 0) return true;
    probe_begin();
    __asm__ volatile("vmovups 64(%0), %%zmm0\n vaddps 4(%0), %%zmm0, %%zmm16\n"
                     "vmulps 60(%0)%{1to16%}, %%zmm0, %%zmm1\n vmovups %%zmm16, 68(%0)\n"
                     "vpmovdb %%zmm0, 128(%0)\n vmovss 64(%0), %%xmm17" ::"r"(at)
                     : "xmm0", "xmm1", "memory");
    probe_end();
    return probe_accesses_are(1 + 2 + 1 + 1, 1, 1);
}

static inline bool probe_is_right(const char *isa)
{
    if (!probe_finds_accesses(isa)) return false;
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
