#include "worker/process/options.h"

#include <errno.h>
#include <limits.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/link/message.h"
#include "proto/log/log.h"
#include "proto/option_text.h"
#include "proto/plan.h"
#include "worker/link/link.h"

#define DEFAULT_CACHE_BYTES (16ull << 30)
#define DEADLINE_MAX_S      (366u * 24u * 3600u)

static const char *const usages[] = {
    "shearwater-worker --connect unix:PATH|HOST:PORT [options]",
    "shearwater-worker --replay PLAN X,Y SAMPLE [--json] [--blobs DIR] [--cache DIR]",
};
static const char summary[] = "Traces tiles for a Shearwater coordinator until it is told to stop. "
                              "With --replay it traces one "
                              "sample of a plan again and prints every step; `shearwater replay` "
                              "makes plans of job documents.";
static const char *const notes[] = {
    "SIGTERM or SIGINT: the worker finishes the tiles that it traces, gives the others back and "
    "leaves. A second signal: it gives all of them back at once.",
    "Exit status: 0 told to stop, idle for too long or at the end of its lifetime, 1 failed, 2 "
    "wrong "
    "use, 3 refused by the coordinator.",
};

enum option_kind { OPTION_TEXT, OPTION_COUNT, OPTION_BYTES, OPTION_FLAG };

struct option_row {
    const char *name;         /* with its dashes */
    const char *value, *text; /* as in option_text.h; no text: hidden */
    enum option_kind kind;
    size_t offset;
    uint64_t max;
};

#define ROW(name, value, kind, member, max, text)                                                  \
    {                                                                                              \
        (name), (value), (text), (kind), offsetof(struct options, member), (max)                   \
    }

static const struct option_row rows[] = {
    ROW("--connect", "ADDRESS", OPTION_TEXT, connect, 0,
        "the coordinator: unix:PATH or HOST:PORT ([ADDRESS]:PORT for IPv6)"),
    ROW("--key", "FILE", OPTION_TEXT, key, 0,
        "the coordinator's key (serve --worker-key): the link over TCP is encrypted, and both "
        "sides "
        "must have the key"),
    ROW("--threads", "N", OPTION_COUNT, threads, LIMIT_THREADS,
        "tracing threads, 1 to 1024 (default: the CPUs of this process)"),
    ROW("--tiles-in-hand", "N", OPTION_COUNT, tiles_in_hand, LIMIT_TILES_IN_HAND,
        "tiles to hold at a time, 1 to 256 (default: 2 per thread)"),
    ROW("--cache", "DIR", OPTION_TEXT, cache_dir, 0,
        "directory of fetched scenes (default: ${XDG_CACHE_HOME:-~/.cache}/shearwater)"),
    ROW("--cache-bytes", "N", OPTION_BYTES, cache_bytes, UINT64_MAX >> 1,
        "most bytes of that directory, with k, M or G behind the number if you like (default: "
        "16G)"),
    ROW("--blobs", "DIR", OPTION_TEXT, blob_dir, 0,
        "object directory of a coordinator on this machine: scenes are mapped from there, without "
        "a "
        "copy"),
    ROW("--pack", "quick|small", OPTION_TEXT, pack, 0,
        "how samples are compressed; small takes a quarter to a third fewer bytes and more CPU "
        "time "
        "(default: small where they cross a network)"),
    ROW("--nice", "N", OPTION_COUNT, nice, 19,
        "niceness, 1 to 19: other processes go first (default: as started)"),
    ROW("--name", "NAME", OPTION_TEXT, name, 0,
        "name in the list of workers (default: host:pid; under Slurm HOST:slurm-JOB_TASK, in "
        "Kubernetes the pod's name)"),
    ROW("--connect-within", "SECONDS", OPTION_COUNT, connect_within_s, DEADLINE_MAX_S,
        "fail when the coordinator has not answered once by then (default: try on)"),
    ROW("--idle-exit", "SECONDS", OPTION_COUNT, idle_exit_s, DEADLINE_MAX_S,
        "leave after this time without a tile, also while the coordinator is away (default: stay)"),
    ROW("--lifetime", "SECONDS", OPTION_COUNT, lifetime_s, DEADLINE_MAX_S,
        "leave by then: the worker takes no tile in the last tenth of it, of which a minute at "
        "most, and gives back what is left at its end (default: stay)"),
    ROW("--log-format", "text|json", OPTION_TEXT, log_format, 0,
        "format of the log on standard error; json: one object per line (default: text)"),
    ROW("--quiet", NULL, OPTION_FLAG, quiet, 0, "log errors only"),
    ROW("--exit-with-parent", NULL, OPTION_FLAG, exit_with_parent, 0,
        "stop when the parent process or the link ends"),
    ROW("--replay", "PLAN", OPTION_TEXT, replay, 0,
        "print every step of one sample of a plan: path number SAMPLE, from 0, of the pixel X,Y. "
        "Scene and environment are looked for in --blobs and --cache"),
    ROW("--json", NULL, OPTION_FLAG, json, 0, "print JSON"),
    ROW("--help", NULL, OPTION_FLAG, help, 0, "print this text"),
    ROW("--version", NULL, OPTION_FLAG, version, 0, "print the build"),
    ROW(OPTION_TEXT_DUMP, NULL, OPTION_FLAG, dump, 0, NULL),
};
#define ROW_COUNT (sizeof rows / sizeof rows[0])

/* Calls for each row that is shown. */
static void each_shown(FILE *out, void (*print)(FILE *out, const struct option_text *option))
{
    for (size_t i = 0; i < ROW_COUNT; i++) {
        const struct option_text text = {0, rows[i].name + 2, rows[i].value, rows[i].text};
        if (text.text) print(out, &text);
    }
}

void options_print_help(FILE *out)
{
    for (size_t i = 0; i < sizeof usages / sizeof usages[0]; i++)
        fprintf(out, "%s%s\n", i == 0 ? "usage: " : "       ", usages[i]);
    fputc('\n', out);
    option_text_wrap(out, summary, 0);
    fputc('\n', out);
    each_shown(out, option_text_help);
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++) {
        fputc('\n', out);
        option_text_wrap(out, notes[i], 0);
    }
}

void options_dump(FILE *out)
{
    for (size_t i = 0; i < sizeof usages / sizeof usages[0]; i++)
        fprintf(out, "usage\t%s\n", usages[i]);
    fprintf(out, "summary\t%s\n", summary);
    each_shown(out, option_text_dump);
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++)
        fprintf(out, "note\t%s\n", notes[i]);
}

static const struct option_row *find_row(const char *name)
{
    for (size_t i = 0; i < ROW_COUNT; i++)
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

/* Refuses arguments unless there is a replay. */
static int check_arguments(const struct options *o, struct fault *fault)
{
    if (o->argument_count > 0 && !o->replay)
        return fault_set(fault, ERR_UNKNOWN_MEMBER, o->arguments[0],
                         "there is no such option; --help lists them");
    if (o->json && !o->replay) return fault_set(fault, ERR_MISSING, "--json", "needs --replay");
    if (!o->replay || o->argument_count == 2) return 0;
    return fault_set(fault, ERR_MISSING, "--replay",
                     "a pixel X,Y and a sample's number must follow");
}

/* Returns whether bytes sent there may leave the machine, as they may for any host name. */
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
    return fault_set(fault, ERR_RANGE, "--pack", "\"%.64s\" is neither quick nor small", o->pack);
}

static int check_name(const char *name, struct fault *fault)
{
    if (name[0] == '\0' || strlen(name) >= LIMIT_NAME_BYTES)
        return fault_set(fault, ERR_LIMIT, "--name",
                         "a name has 1 to %d bytes: give a shorter one, or none to be called "
                         "HOST:PID",
                         LIMIT_NAME_BYTES - 1);
    if (!message_text_is_clean(name))
        return fault_set(fault, ERR_SYNTAX, "--name",
                         "a name is printable UTF-8, without line ends: give another, or none to "
                         "be called HOST:PID");
    return 0;
}

static int finish(struct options *o, struct fault *fault)
{
    if (o->help || o->version || o->dump) return 0;
    const int e = check_arguments(o, fault);
    if (e || o->replay) return e;
    if (!o->connect)
        return fault_set(fault, ERR_MISSING, "--connect",
                         "give the coordinator's address: unix:PATH or HOST:PORT");
    if (link_check_address(o->connect, fault) != 0) return fault->code;
    if (o->name && check_name(o->name, fault) != 0) return fault->code;
    enum log_format format;
    if (!log_format_from_name(o->log_format, &format))
        return fault_set(fault, ERR_RANGE, "--log-format", "\"%.64s\" is neither text nor json",
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
