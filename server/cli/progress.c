#include "server/cli/progress.h"

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

static void eta_text(double eta_s, char *out, size_t capacity)
{
    if (eta_s < 0)
        out[0] = '\0';
    else if (eta_s < 90)
        snprintf(out, capacity, ", %.0f s left", eta_s);
    else if (eta_s < 5400)
        snprintf(out, capacity, ", %.0f min left", eta_s / 60);
    else
        snprintf(out, capacity, ", %.1f h left", eta_s / 3600);
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
    char eta[48], tail[128];
    if (p->quiet) return;
    if (state) snprintf(p->state, sizeof p->state, "%s", state);
    const json_t *fraction = json_object_get(data, "fraction");
    if (json_is_number(fraction)) p->fraction = json_number_value(fraction);
    if (p->fraction > 0.99) p->fraction = 0.99;
    const json_t *eta_s = json_object_get(data, "eta_s");
    eta_text(json_is_number(eta_s) ? json_number_value(eta_s) : -1, eta, sizeof eta);
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
