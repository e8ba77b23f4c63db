#include "server/cli/progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

void progress_begin(struct progress *p, bool quiet)
{
    struct winsize size;
    *p = (struct progress){.quiet = quiet, .terminal = isatty(STDERR_FILENO) == 1, .width = 30};
    p->tenth = -1;
    if (p->terminal && ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col < 80)
        p->width = size.ws_col < 60 ? 10 : 20;
}

/* A time as people say it. */
struct duration {
    char number[24];
    const char *unit;
};

static struct duration duration_of(double s)
{
    const bool hours = s >= 5400, minutes = s >= 90 && !hours;
    struct duration out = {.unit = hours ? "h" : minutes ? "min" : "s"};
    const double number = hours ? s / 3600 : ceil(minutes ? s / 60 : s);
    snprintf(out.number, sizeof out.number, "%.*f", hours, number);
    return out;
}

/* Writes ", 12 s left" or ", 10 to 40 s left", or nothing when there is no telling. */
static void eta_text(const json_t *data, char *out, size_t capacity)
{
    const json_t *eta = json_object_get(data, "eta_s"),
                 *range = json_object_get(data, "eta_range_s");
    const bool point = json_is_number(eta);
    out[0] = '\0';
    if (!point && json_array_size(range) != 2) return;
    const struct duration least =
        duration_of(json_number_value(point ? eta : json_array_get(range, 0)));
    const struct duration most =
        duration_of(json_number_value(point ? eta : json_array_get(range, 1)));
    const bool same_unit = strcmp(least.unit, most.unit) == 0;
    if (same_unit && strcmp(least.number, most.number) == 0)
        snprintf(out, capacity, ", %s %s left", most.number, most.unit);
    else
        snprintf(out, capacity, ", %s%s%s to %s %s left", least.number, same_unit ? "" : " ",
                 same_unit ? "" : least.unit, most.number, most.unit);
}

static void draw_bar(const struct progress *p, const char *tail)
{
    int full = (int)(p->fraction * p->width);
    fprintf(stderr, "\r\033[K%-9s [", p->state);
    for (int i = 0; i < p->width; i++) fputc(i < full ? '#' : '.', stderr);
    fprintf(stderr, "] %2.0f %%%s", p->fraction * 100, tail);
    fflush(stderr);
}

void progress_show(struct progress *p, const char *state, const json_t *data)
{
    char eta[96], tail[160];
    if (p->quiet) return;
    if (state) snprintf(p->state, sizeof p->state, "%s", state);
    const json_t *fraction = json_object_get(data, "fraction");
    if (json_is_number(fraction)) p->fraction = json_number_value(fraction);
    if (p->fraction > 0.99) p->fraction = 0.99;
    eta_text(data, eta, sizeof eta);
    json_int_t done = json_integer_value(json_object_get(data, "tiles_done"));
    json_int_t total = json_integer_value(json_object_get(data, "tiles_total"));
    tail[0] = '\0';
    if (total > 0)
        snprintf(tail, sizeof tail, ", %lld of %lld tiles%s", (long long)done, (long long)total,
                 eta);
    if (p->terminal)
        draw_bar(p, tail);
    else if ((int)(p->fraction * 10) > p->tenth) {
        p->tenth = (int)(p->fraction * 10);
        fprintf(stderr, "%s: %d %%%s\n", p->state, p->tenth * 10, tail);
    }
}

void progress_end(struct progress *p, const char *line)
{
    if (p->quiet) return;
    if (p->terminal) fputs("\r\033[K", stderr);
    if (line) fprintf(stderr, "%s\n", line);
}
