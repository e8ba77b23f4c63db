#include "server/import/obj/obj_near.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/mtl_map.h"
#include "server/import/scene/origin.h"

#define LINE_BYTES   256 /* of a vertex, at most; others are left as they are, all of them */
#define VERTEX_BYTES 64  /* that a written vertex may be longer than a read one */

/* A line with its end, and a vertex if it is one. */
struct line {
    const char *at;
    size_t size_bytes;
    bool is_vertex;
    double position[3];
    char rest[LINE_BYTES]; /* behind the position: a colour */
};

/* Reads a vertex. Returns false for one that cannot be moved. */
static bool read_vertex(struct line *line)
{
    char text[LINE_BYTES], *at = text, *end;
    if (line->size_bytes >= sizeof text) return false;
    memcpy(text, line->at, line->size_bytes);
    text[line->size_bytes] = '\0';
    const size_t end_at = strcspn(text, "\r\n");
    if (strcmp(text + end_at, "\r\n") != 0 && end_at + 1 < line->size_bytes) return false;
    text[end_at] = '\0';
    at += strspn(at, " \t") + 1;
    for (int i = 0; i < 3; i++, at = end) {
        line->position[i] = strtod(at, &end);
        if (end == at || !isfinite(line->position[i])) return false;
    }
    memcpy(line->rest, at, strlen(at) + 1);
    const double weight = strtod(at, &end);
    const bool is_alone = end != at && end[strspn(end, " \t")] == '\0';
    return !strchr(line->rest, '\\') && (!is_alone || weight == 1.0);
}

/* Returns false at the end, or at a vertex that cannot be moved. */
static bool next_line(const struct file_view *main, size_t *at, struct line *line)
{
    const char *text = (const char *)main->data + *at;
    const size_t left = main->size_bytes - *at;
    if (left == 0) return false;
    const char *end = memchr(text, '\n', left);
    line->at = text;
    line->size_bytes = end ? (size_t)(end - text) + 1 : left;
    size_t blanks = 0;
    while (blanks + 1 < line->size_bytes && (text[blanks] == ' ' || text[blanks] == '\t')) blanks++;
    line->is_vertex = blanks + 1 < line->size_bytes && text[blanks] == 'v' &&
                      (text[blanks + 1] == ' ' || text[blanks + 1] == '\t');
    *at += line->size_bytes;
    if (!line->is_vertex || read_vertex(line)) return true;
    *at = 0;
    return false;
}

/* Returns how many vertices there are, with their box; 0 where one cannot be moved. */
static size_t measure(const struct file_view *main, double lowest[3], double highest[3])
{
    struct line line;
    size_t at = 0, count = 0;
    for (int i = 0; i < 3; i++) lowest[i] = INFINITY, highest[i] = -INFINITY;
    while (next_line(main, &at, &line)) {
        count += line.is_vertex;
        for (int i = 0; line.is_vertex && i < 3; i++) {
            lowest[i] = fmin(lowest[i], line.position[i]);
            highest[i] = fmax(highest[i], line.position[i]);
        }
    }
    return at == main->size_bytes ? count : 0;
}

static void write_near(struct obj_near *near, const struct file_view *main)
{
    struct line line;
    size_t at = 0;
    char *to = near->text;
    while (next_line(main, &at, &line)) {
        const double *p = line.position, *o = near->origin;
        if (line.is_vertex) {
            to += sprintf(to, "v %.9g %.9g %.9g%s\n", p[0] - o[0], p[1] - o[1], p[2] - o[2],
                          line.rest);
        } else {
            memcpy(to, line.at, line.size_bytes);
            to += line.size_bytes;
        }
    }
    near->view = (struct file_view){(const uint8_t *)near->text, (size_t)(to - near->text)};
}

int obj_near_open(struct obj_near *near, const char *name, const struct file_view *main,
                  struct fault *fault)
{
    double lowest[3], highest[3];
    struct file_view text = *main;
    mtl_skip_mark((const char **)&text.data, &text.size_bytes);
    *near = (struct obj_near){.view = text};
    const size_t count = measure(&text, lowest, highest);
    if (count == 0 || !origin_choose(lowest, highest, near->origin)) return 0;
    near->text = malloc(text.size_bytes + count * VERTEX_BYTES + 1);
    if (!near->text) return fault_set(fault, ERR_MEMORY, name, "no memory for its vertices");
    write_near(near, &text);
    return 0;
}

void obj_near_close(struct obj_near *near)
{
    free(near->text);
    *near = (struct obj_near){0};
}
