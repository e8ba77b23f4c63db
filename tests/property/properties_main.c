/* properties [runs=N] [seconds=S] [seed=N] [property=NAME] [case=FILE] [corpus=FOLDER]
 *
 * What holds of every scene, for scenes drawn from seeds (the first is `seed`, 1 unless said) and
 * for those that are kept in the corpus. TAP. A case that fails is made simpler as long as it does,
 * and printed: its seed, and the simplest case as lines that `case=` reads. */
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tests/property/check.h"

const struct property properties[] = {
    {"finite", property_finite},         {"cut", property_cut},
    {"scaled", property_scaled},         {"moved", property_moved},
    {"brighter", property_brighter},     {"mirrored", property_mirrored},
    {"turned", property_turned},         {"lights_add", property_lights_add},
    {"filtered", property_filtered},     {"open", property_open},
    {"unoccluded", property_unoccluded}, {"glow", property_glow},
    {"furnace", property_furnace},       {"dealt", property_dealt},
    {"looked", property_looked},
};
const int property_count = sizeof properties / sizeof properties[0];

enum { TRIES_MAX = 400, CASES_MAX = 256, FAILURES_SHOWN = 3 };

struct options {
    uint64_t seed;
    long runs, seconds;
    const char *property, *file, *corpus;
};

static int tests, failed;

static void test(bool holds, const char *format, const char *a, const char *b)
{
    tests++;
    failed += !holds;
    printf("%sok %d - ", holds ? "" : "not ", tests);
    printf(format, a, b);
    putchar('\n');
    fflush(stdout);
}

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void show(const struct property *p, const struct property_case *c, const char *says)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory) abort();
    case_write(c, memory);
    fclose(memory);
    printf("# property %s: %s\n", p->name, says);
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) printf("# %s\n", line);
    free(text);
}

static bool wanted(const struct options *o, const struct property *p)
{
    return !o->property || !strcmp(o->property, p->name);
}

/* Seeds in turn, each with all properties, until runs or time are used up. */
static void run_seeds(const struct options *o)
{
    long held[32] = {0}, fails[32] = {0};
    const double end = now_s() + (double)o->seconds;
    long run = 0;
    for (; run < o->runs && (o->seconds == 0 || now_s() < end); run++) {
        struct property_case c;
        case_draw(o->seed + (uint64_t)run, &c);
        for (int i = 0; i < property_count; i++) {
            char says[PROPERTY_SAYS_BYTES];
            if (!wanted(o, &properties[i])) continue;
            const enum property_result result = check(&properties[i], &c, says);
            held[i] += result == PROPERTY_HOLDS;
            if (result != PROPERTY_FAILS) continue;
            if (fails[i]++ >= FAILURES_SHOWN) continue;
            struct property_case simplest = c;
            printf("# seed %llu: %s: %s\n", (unsigned long long)(o->seed + (uint64_t)run),
                   properties[i].name, says);
            check_shrink(&properties[i], &simplest, TRIES_MAX, says);
            show(&properties[i], &simplest, says);
        }
    }
    for (int i = 0; i < property_count; i++) {
        char said[96];
        if (!wanted(o, &properties[i])) continue;
        snprintf(said, sizeof said, "%ld seeds from %llu, held by %ld, failed by %ld", run,
                 (unsigned long long)o->seed, held[i], fails[i]);
        /* A property that applied to nothing has shown nothing. */
        test(fails[i] == 0 && (held[i] > 0 || run < 20), "%s: %s", properties[i].name, said);
    }
}

static void run_case(const struct options *o, const char *path)
{
    struct property_case c;
    int line = 0;
    FILE *in = fopen(path, "r");
    const bool readable = in && case_read(in, &c, &line) == 0;
    if (in) fclose(in);
    bool holds = readable;
    if (!readable) printf("# %s: line %d is no line of a case\n", path, line);
    for (int i = 0; readable && i < property_count; i++) {
        char says[PROPERTY_SAYS_BYTES];
        if (!wanted(o, &properties[i])) continue;
        const enum property_result result = check(&properties[i], &c, says);
        /* Whoever looks at one case wants to know what it does not show. */
        if (result == PROPERTY_DOES_NOT_APPLY && o->file)
            printf("# %s does not apply: %s\n", properties[i].name, says);
        if (result != PROPERTY_FAILS) continue;
        holds = false;
        show(&properties[i], &c, says);
    }
    const char *name = strrchr(path, '/');
    test(holds, "case %s: %s", name ? name + 1 : path, "all properties");
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static void run_corpus(const struct options *o)
{
    char *paths[CASES_MAX];
    int count = 0;
    DIR *folder = opendir(o->corpus);
    if (!folder) {
        test(false, "%s%s", o->corpus, ": no such folder");
        return;
    }
    for (struct dirent *e; (e = readdir(folder)) && count < CASES_MAX;) {
        const size_t length = strlen(o->corpus) + strlen(e->d_name) + 2;
        if (!strstr(e->d_name, ".case") || !(paths[count] = malloc(length))) continue;
        snprintf(paths[count++], length, "%s/%s", o->corpus, e->d_name);
    }
    closedir(folder);
    qsort(paths, (size_t)count, sizeof *paths, by_name);
    for (int i = 0; i < count; i++) {
        run_case(o, paths[i]);
        free(paths[i]);
    }
}

static bool parse(int argc, char **argv, struct options *o)
{
    for (int i = 1; i < argc; i++) {
        const char *value = strchr(argv[i], '=');
        if (!value) return false;
        value++;
        if (!strncmp(argv[i], "runs=", 5))
            o->runs = strtol(value, NULL, 10);
        else if (!strncmp(argv[i], "seconds=", 8))
            o->seconds = strtol(value, NULL, 10);
        else if (!strncmp(argv[i], "seed=", 5))
            o->seed = strtoull(value, NULL, 10);
        else if (!strncmp(argv[i], "property=", 9))
            o->property = value;
        else if (!strncmp(argv[i], "case=", 5))
            o->file = value;
        else if (!strncmp(argv[i], "corpus=", 7))
            o->corpus = value;
        else
            return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    struct options o = {.seed = 1, .runs = 100};
    if (!parse(argc, argv, &o)) {
        fprintf(stderr, "usage: properties [runs=N] [seconds=S] [seed=N] [property=NAME] "
                        "[case=FILE] [corpus=FOLDER]\n");
        return 2;
    }
    if (o.file)
        run_case(&o, o.file);
    else if (o.corpus)
        run_corpus(&o);
    if (!o.file && o.runs > 0) run_seeds(&o);
    printf("1..%d\n", tests);
    return failed > 0;
}
