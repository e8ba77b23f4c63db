#include "server/http/resource/png_query.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"

static bool read_exposure(const char *text, float *out)
{
    char *end = NULL;
    if (!text) return true;
    /* strtof would also take blanks, hexadecimal and names of infinities. */
    if (*text && strspn(text, "+-.0123456789") == strlen(text)) *out = strtof(text, &end);
    return end && *end == '\0' && fabsf(*out) <= (float)LIMIT_EXPOSURE_EV;
}

/* One of two words. */
static bool read_either(const char *text, const char *no, const char *yes, bool *out)
{
    if (!text) return true;
    *out = strcmp(text, yes) == 0;
    return *out || strcmp(text, no) == 0;
}

bool png_query_read(struct request *r, const struct png_options *otherwise, struct png_options *out)
{
    const char *view = target_parameter(&r->target, "view"), *fault = NULL;
    *out = *otherwise;
    if (!read_exposure(target_parameter(&r->target, "exposure"), &out->exposure_ev))
        fault = "exposure must be a number of stops from -32 to 32";
    else if (view && !view_curve_from_name(view, &out->view))
        fault = "view must be linear, filmic or agx";
    else if (!read_either(target_parameter(&r->target, "bits"), "8", "16", &out->is_deep))
        fault = "bits must be 8 or 16";
    else if (!read_either(target_parameter(&r->target, "alpha"), "0", "1", &out->alpha))
        fault = "alpha must be 0 or 1";
    if (fault) request_problem(r, PROBLEM_MALFORMED, fault, NULL);
    return !fault;
}

bool png_query_is_same(const struct png_options *a, const struct png_options *b)
{
    return a->view == b->view && a->exposure_ev == b->exposure_ev && a->is_deep == b->is_deep &&
           a->alpha == b->alpha;
}
