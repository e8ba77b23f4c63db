#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/rgbd/rgbd_document.h"

#define PLACE "/rgbd/poses/file"

/* How far rounded numbers may be from a rotation. */
#define ROTATION_TOLERANCE 1e-2

/* A frame whose time is further from all poses has none. */
#define TIME_TOLERANCE_S 0.05

struct poses {
    struct affine *list; /* owned */
    double *times_s;     /* owned */
    size_t count, capacity;
};

bool rgbd_similarity_read(const double rows[16], struct affine *out, double *scale)
{
    double lengths = 0;
    for (int i = 0; i < 16; i++)
        if (!isfinite(rows[i])) return false;
    for (int i = 0; i < 12; i++) out->m[i] = rows[i];
    const double det = affine_determinant(out), s = cbrt(det);
    *scale = s;
    if (!(det > 1e-12) || rows[12] != 0 || rows[13] != 0 || rows[14] != 0 || rows[15] != 1)
        return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = 0;
            for (int k = 0; k < 3; k++) sum += rows[4 * k + i] * rows[4 * k + j];
            lengths = fmax(lengths, fabs(sum / (s * s) - (i == j)));
        }
    return lengths <= ROTATION_TOLERANCE;
}

static int add(struct poses *p, const struct affine *pose, double time_s, struct fault *fault)
{
    if (p->count == LIMIT_POSES)
        return fault_set(fault, ERR_LIMIT, PLACE, "it has more than %u poses", LIMIT_POSES);
    if (p->count == p->capacity) {
        const size_t capacity = 2 * p->capacity + 64;
        struct affine *list = realloc(p->list, capacity * sizeof *list);
        if (list != NULL) p->list = list;
        double *times = list != NULL ? realloc(p->times_s, capacity * sizeof *times) : NULL;
        if (times != NULL) p->times_s = times;
        if (times == NULL) return fault_set(fault, ERR_MEMORY, PLACE, "no memory for poses");
        p->capacity = capacity;
    }
    p->list[p->count] = *pose;
    p->times_s[p->count++] = time_s;
    return 0;
}

/* Reads the numbers of a line; returns how many, and -1 where it has anything else. */
static int read_numbers(const char *line, double out[16])
{
    int count = 0;
    for (const char *at = line;;) {
        char *end;
        at += strspn(at, " \t,\r");
        if (*at == '\0' || *at == '#') return count;
        const double v = strtod(at, &end);
        if (end == at || count == 16 || !isfinite(v)) return -1;
        out[count++] = v;
        at = end;
    }
}

/* t tx ty tz qx qy qz qw, or without t. */
static int add_tum(struct poses *p, int line, const double *v, int count, struct fault *fault)
{
    static const double one[3] = {1, 1, 1};
    if (count != 8 && count != 7)
        return fault_set(fault, ERR_SYNTAX, PLACE,
                         "line %d has %d numbers, no t tx ty tz qx qy qz qw", line, count);
    const double *at = v + (count == 8);
    double q[4], length = 0;
    for (int i = 0; i < 4; i++) length += at[3 + i] * at[3 + i];
    length = sqrt(length);
    if (!(fabs(length - 1) <= ROTATION_TOLERANCE))
        return fault_set(fault, ERR_RANGE, PLACE,
                         "line %d: its quaternion has the length %.6g: no rotation", line, length);
    for (int i = 0; i < 4; i++) q[i] = at[3 + i] / length;
    for (int i = 0; i < 3; i++)
        if (!(fabs(at[i]) <= (double)LIMIT_COORDINATE))
            return fault_set(fault, ERR_LIMIT, PLACE, "line %d: %.9g is too far", line, at[i]);
    const struct affine pose = affine_from_trs(at, q, one);
    return add(p, &pose, count == 8 ? v[0] : NAN, fault);
}

/* Makes columns orthonormal that nearly are. */
static void orthonormalise(struct affine *pose)
{
    double c[3][3];
    for (int k = 0; k < 9; k++) c[k / 3][k % 3] = pose->m[4 * (k % 3) + k / 3];
    normalize3(c[0]);
    const double along = dot3(c[0], c[1]);
    for (int i = 0; i < 3; i++) c[1][i] -= along * c[0][i];
    normalize3(c[1]);
    cross3(c[0], c[1], c[2]);
    for (int k = 0; k < 9; k++) pose->m[4 * (k % 3) + k / 3] = c[k / 3][k % 3];
}

static int add_matrix(struct poses *p, int line, const double rows[16], struct fault *fault)
{
    struct affine pose;
    double scale;
    if (!rgbd_similarity_read(rows, &pose, &scale) || fabs(scale - 1) > ROTATION_TOLERANCE)
        return fault_set(fault, ERR_RANGE, PLACE,
                         "the matrix that ends in line %d is no rotation and translation", line);
    for (int i = 0; i < 3; i++)
        if (!(fabs(rows[4 * i + 3]) <= (double)LIMIT_COORDINATE))
            return fault_set(fault, ERR_LIMIT, PLACE, "line %d: the camera is too far", line);
    orthonormalise(&pose);
    return add(p, &pose, NAN, fault);
}

/* Rows of four numbers, and between matrices what Open3D writes: three whole numbers. */
static int add_row(struct poses *p, int line, const double *v, int count, double rows[16],
                   int *filled, struct fault *fault)
{
    if (count == 3 && *filled == 0) return 0;
    if (count == 16 && *filled == 0) return add_matrix(p, line, v, fault);
    if (count != 4)
        return fault_set(fault, ERR_SYNTAX, PLACE, "line %d has %d numbers, no row of a matrix",
                         line, count);
    memcpy(rows + *filled, v, 4 * sizeof *v);
    *filled += 4;
    if (*filled < 16) return 0;
    *filled = 0;
    return add_matrix(p, line, rows, fault);
}

static int read_lines(char *text, uint32_t format, bool by_time, struct poses *p,
                      struct fault *fault)
{
    double v[16], rows[16];
    int line = 0, filled = 0, rc = 0;
    for (char *at = text, *next; at != NULL && rc == 0; at = next) {
        next = strchr(at, '\n');
        if (next != NULL) *next++ = '\0';
        const int count = read_numbers(at, v);
        line++;
        if (count < 0)
            rc = fault_set(fault, ERR_SYNTAX, PLACE, "line %d is no list of numbers", line);
        else if (count == 7 && format == RGBD_POSES_TUM && by_time)
            rc = fault_set(fault, ERR_MISSING, PLACE,
                           "line %d has no time, and frames with a time_s need one", line);
        else if (count > 0 && format == RGBD_POSES_TUM)
            rc = add_tum(p, line, v, count, fault);
        else if (count > 0)
            rc = add_row(p, line, v, count, rows, &filled, fault);
    }
    if (rc == 0 && filled > 0)
        rc = fault_set(fault, ERR_TRUNCATED, PLACE, "it ends within a matrix");
    return rc;
}

static size_t nearest(const struct poses *p, double time_s)
{
    size_t best = 0;
    for (size_t i = 1; i < p->count; i++)
        if (fabs(p->times_s[i] - time_s) < fabs(p->times_s[best] - time_s)) best = i;
    return best;
}

static int assign(const struct poses *p, struct rgbd_document *d, struct fault *fault)
{
    const bool by_time = d->frame_count > 0 && d->frames[0].has_time;
    if (p->count == 0 || (!by_time && p->count < d->frame_count))
        return fault_set(fault, ERR_TRUNCATED, PLACE, "it ends after %zu poses of %u frames",
                         p->count, d->frame_count);
    for (uint32_t i = 0; i < d->frame_count; i++) {
        const size_t k = by_time ? nearest(p, d->frames[i].time_s) : i;
        if (by_time && !(fabs(p->times_s[k] - d->frames[i].time_s) <= TIME_TOLERANCE_S))
            return fault_set(fault, ERR_NOT_FOUND, PLACE,
                             "no pose is within %g s of frame %u, at %.6f s", TIME_TOLERANCE_S,
                             i + 1, d->frames[i].time_s);
        d->frames[i].pose = p->list[k];
    }
    return 0;
}

int rgbd_poses_read(const struct file_view *file, struct rgbd_document *d, struct fault *fault)
{
    struct poses p = {0};
    char *text = malloc(file->size_bytes + 1);
    if (text == NULL) return fault_set(fault, ERR_MEMORY, PLACE, "no memory for poses");
    memcpy(text, file->data, file->size_bytes);
    text[file->size_bytes] = '\0';
    int rc = read_lines(text, d->pose_format, d->frames[0].has_time, &p, fault);
    if (rc == 0) rc = assign(&p, d, fault);
    free(text);
    free(p.list);
    free(p.times_s);
    return rc;
}
