#include "worker/process/options.h"

#include <errno.h>
#include <limits.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/log/log.h"
#include "proto/plan.h"
#include "worker/link/link.h"

#define DEFAULT_CACHE_BYTES (16ull << 30)

static const char help[] =
    "usage: shearwater-worker --connect unix:PATH | HOST:PORT [options]\n"
    "       shearwater-worker --replay PLAN X,Y SAMPLE [--field FIELD] [--json] [--blobs DIR]\n"
    "                         [--cache DIR]\n"
    "\n"
    "Traces tiles for a Shearwater coordinator until it is told to stop (SIGTERM).\n"
    "\n"
    "  --connect ADDRESS    the coordinator: unix:PATH or HOST:PORT ([ADDRESS]:PORT for IPv6)\n"
    "  --key FILE           the key that the coordinator has (serve --worker-key): the link over\n"
    "                       TCP is encrypted, and only who has the key is talked to\n"
    "  --threads N          tracing threads, 1 to 1024 (default: the CPUs of this process)\n"
    "  --tiles-in-hand N    tiles to hold at a time, 1 to 256 (default: 2 a thread)\n"
    "  --cache DIR          where fetched scenes are kept (default: ~/.cache/shearwater)\n"
    "  --cache-bytes N      bound of that folder; k, M, G allowed (default: 16G)\n"
    "  --blobs DIR          the object folder of a coordinator on this machine: scenes are\n"
    "                       mapped from it without copying\n"
    "  --pack HOW           quick, or small: a quarter to a third fewer bytes for more CPU time\n"
    "                       (default: small where they cross a network)\n"
    "  --nice N             leave CPUs to others, 1 to 19 (see nice(1); default: as started)\n"
    "  --name NAME          name in the list of workers (default: host:pid)\n"
    "  --log-format FORMAT  of the lines on standard error: text, or json (an object a line)\n"
    "  --quiet              errors only\n"
    "  --exit-with-parent   end when the parent process or the link is gone\n"
    "  --replay PLAN        trace one sample of a plan once more and print all that it does: the\n"
    "                       pixel's path (or its path through the lens) number SAMPLE, from 0;\n"
    "                       --json: for programs. Scene and environment are looked for in --blobs\n"
    "                       and --cache. `shearwater replay` makes plans of job documents\n"
    "  --field FIELD        a sample of a light field of pixel centres instead: light:N or\n"
    "                       light:NAME (a stratum of that light), indirect (a bounce ray), glossy\n"
    "                       (a ray of the surface's glossy lobe)\n"
    "  --pass N --side L    of a later pass of rays (of a target_error, or the second set of the\n"
    "                       filter of rates), in which the pixel got L x L\n"
    "  --help, --version\n"
    "\n"
    "SIGTERM or SIGINT: finish the tiles being traced, give the others back, leave. A second one:\n"
    "give all back at once.\n"
    "Exit status: 0 told to stop, 1 failed, 2 wrong use, 3 refused by the coordinator.\n";

const char *options_help(void)
{
    return help;
}

enum option_kind { OPTION_TEXT, OPTION_COUNT, OPTION_BYTES, OPTION_FLAG };

struct option_row {
    const char *name;
    enum option_kind kind;
    size_t offset;
    uint64_t max;
};

static const struct option_row rows[] = {
    {"--connect", OPTION_TEXT, offsetof(struct options, connect), 0},
    {"--key", OPTION_TEXT, offsetof(struct options, key), 0},
    {"--cache", OPTION_TEXT, offsetof(struct options, cache_dir), 0},
    {"--blobs", OPTION_TEXT, offsetof(struct options, blob_dir), 0},
    {"--name", OPTION_TEXT, offsetof(struct options, name), 0},
    {"--threads", OPTION_COUNT, offsetof(struct options, threads), LIMIT_THREADS},
    {"--tiles-in-hand", OPTION_COUNT, offsetof(struct options, tiles_in_hand), LIMIT_TILES_IN_HAND},
    {"--nice", OPTION_COUNT, offsetof(struct options, nice), 19},
    {"--cache-bytes", OPTION_BYTES, offsetof(struct options, cache_bytes), UINT64_MAX >> 1},
    {"--replay", OPTION_TEXT, offsetof(struct options, replay), 0},
    {"--field", OPTION_TEXT, offsetof(struct options, field), 0},
    {"--pass", OPTION_COUNT, offsetof(struct options, pass), LIMIT_PASSES - 1},
    {"--side", OPTION_COUNT, offsetof(struct options, side), PLAN_SIDE_MOST},
    {"--json", OPTION_FLAG, offsetof(struct options, json), 0},
    {"--pack", OPTION_TEXT, offsetof(struct options, pack), 0},
    {"--log-format", OPTION_TEXT, offsetof(struct options, log_format), 0},
    {"--quiet", OPTION_FLAG, offsetof(struct options, quiet), 0},
    {"--exit-with-parent", OPTION_FLAG, offsetof(struct options, exit_with_parent), 0},
    {"--help", OPTION_FLAG, offsetof(struct options, help), 0},
    {"--version", OPTION_FLAG, offsetof(struct options, version), 0},
};

static const struct option_row *find_row(const char *name)
{
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (strcmp(rows[i].name, name) == 0) return &rows[i];
    return NULL;
}

static unsigned suffix_shift(const char *suffix)
{
    if (*suffix == 'k' || *suffix == 'K') return 10;
    if (*suffix == 'M') return 20;
    if (*suffix == 'G') return 30;
    return *suffix == '\0' ? 0 : 64;
}

static int read_number(const struct option_row *row, const char *text, uint64_t *out,
                       struct fault *fault)
{
    char *end = NULL;
    errno = 0;
    unsigned long long value = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || errno != 0)
        return fault_set(fault, ERR_SYNTAX, row->name, "\"%.64s\" is not a number", text);
    unsigned shift = row->kind == OPTION_BYTES ? suffix_shift(end) : *end ? 64 : 0;
    if (shift == 64 || (shift > 0 && end[1] != '\0'))
        return fault_set(fault, ERR_SYNTAX, row->name, "\"%.64s\" is not a number", text);
    if (value < 1 || value > row->max >> shift)
        return fault_set(fault, ERR_RANGE, row->name, "%.64s is not between 1 and %llu", text,
                         (unsigned long long)row->max);
    *out = value << shift;
    return 0;
}

static int read_value(const struct option_row *row, const char *text, struct options *out,
                      struct fault *fault)
{
    char *field = (char *)out + row->offset;
    uint64_t number = 0;
    if (!text || *text == '\0')
        return fault_set(fault, ERR_MISSING, row->name, "a value must follow");
    if (row->kind == OPTION_TEXT) {
        memcpy(field, &text, sizeof text);
        return 0;
    }
    int e = read_number(row, text, &number, fault);
    if (e) return e;
    uint32_t count = (uint32_t)number;
    if (row->kind == OPTION_BYTES)
        memcpy(field, &number, sizeof number);
    else
        memcpy(field, &count, sizeof count);
    return 0;
}

static uint32_t usable_cpus(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    int count = CPU_COUNT(&set);
    return count < 1 ? 1 : count > LIMIT_THREADS ? LIMIT_THREADS : (uint32_t)count;
}

/* Only a replay has arguments. */
static int check_arguments(const struct options *o, struct fault *fault)
{
    if (o->argument_count > 0 && !o->replay)
        return fault_set(fault, ERR_UNKNOWN_MEMBER, o->arguments[0],
                         "there is no such option; --help lists them");
    if (o->json && !o->replay)
        return fault_set(fault, ERR_MISSING, "--json", "goes with --replay alone");
    if (o->field && !o->replay)
        return fault_set(fault, ERR_MISSING, "--field", "goes with --replay alone");
    if ((o->pass || o->side) && !o->field)
        return fault_set(fault, ERR_MISSING, o->pass ? "--pass" : "--side",
                         "goes with --field alone: paths of all passes are numbered on");
    if (!o->replay || o->argument_count == 2) return 0;
    return fault_set(fault, ERR_MISSING, "--replay", "a pixel, X,Y, and a sample's number follow");
}

/* Does what is sent there leave the machine? A name may be anybody's. */
static bool crosses_network(const char *address)
{
    static const char *const own[] = {"unix:", "127.", "localhost:", "[::1]:"};
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
        if (strncmp(address, own[i], strlen(own[i])) == 0) return false;
    return true;
}

static int choose_packing(struct options *o, struct fault *fault)
{
    const bool is_small = o->pack ? strcmp(o->pack, "small") == 0 : crosses_network(o->connect);
    o->packing = is_small ? PACKING_SMALL : PACKING_QUICK;
    if (!o->pack || is_small || strcmp(o->pack, "quick") == 0) return 0;
    return fault_set(fault, ERR_RANGE, "--pack", "\"%.64s\" is none: quick and small are", o->pack);
}

static int finish(struct options *o, struct fault *fault)
{
    if (o->help || o->version) return 0;
    const int e = check_arguments(o, fault);
    if (e || o->replay) return e;
    if (!o->connect)
        return fault_set(fault, ERR_MISSING, "--connect",
                         "say where the coordinator is: unix:PATH or HOST:PORT");
    if (link_check_address(o->connect, fault) != 0) return fault->code;
    if (o->name && strlen(o->name) >= LIMIT_NAME_BYTES)
        return fault_set(fault, ERR_LIMIT, "--name", "a name has at most %d bytes",
                         LIMIT_NAME_BYTES - 1);
    enum log_format format;
    if (!log_format_from_name(o->log_format, &format))
        return fault_set(fault, ERR_RANGE, "--log-format", "\"%.64s\" is none: text and json are",
                         o->log_format);
    if (choose_packing(o, fault) != 0) return fault->code;
    if (o->threads == 0) o->threads = usable_cpus();
    if (o->tiles_in_hand == 0) o->tiles_in_hand = 2 * o->threads;
    if (o->tiles_in_hand > LIMIT_TILES_IN_HAND) o->tiles_in_hand = LIMIT_TILES_IN_HAND;
    return 0;
}

int options_read(int argc, char **argv, struct options *out, struct fault *fault)
{
    *out = (struct options){.cache_bytes = DEFAULT_CACHE_BYTES, .log_format = "text"};
    for (int i = 1; i < argc; i++) {
        const struct option_row *row = find_row(argv[i]);
        if (!row && argv[i][0] != '-' && out->argument_count < 2) {
            out->arguments[out->argument_count++] = argv[i];
            continue;
        }
        if (!row)
            return fault_set(fault, ERR_UNKNOWN_MEMBER, argv[i],
                             "there is no such option; --help lists them");
        if (row->kind == OPTION_FLAG) {
            *((bool *)((char *)out + row->offset)) = true;
            continue;
        }
        int e = read_value(row, i + 1 < argc ? argv[i + 1] : NULL, out, fault);
        if (e) return e;
        i++;
    }
    return finish(out, fault);
}

int options_default_name(char *out, size_t capacity)
{
    char host[128] = "worker";
    gethostname(host, sizeof host - 1);
    const int n = snprintf(out, capacity, "%s:%ld", host, (long)getpid());
    return n > 0 && (size_t)n < capacity ? 0 : ERR_LIMIT;
}

int options_default_cache(char *out, size_t capacity)
{
    const char *xdg = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int n;
    if (xdg && xdg[0] == '/')
        n = snprintf(out, capacity, "%s/shearwater", xdg);
    else if (home && home[0] == '/')
        n = snprintf(out, capacity, "%s/.cache/shearwater", home);
    else
        n = snprintf(out, capacity, "/tmp/shearwater-%u", (unsigned)getuid());
    return n > 0 && (size_t)n < capacity ? 0 : ERR_LIMIT;
}
