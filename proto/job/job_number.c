#include "proto/job/job_internal.h"

#include <stdio.h>
#include <stdlib.h>

double job_number_rounded(double v, int digits)
{
    char text[40];
    snprintf(text, sizeof text, "%.*e", digits - 1, v);
    return strtod(text, NULL);
}

json_t *job_number_write(float v)
{
    for (int digits = 1; digits < 9; digits++) {
        const double candidate = job_number_rounded((double)v, digits);
        if ((float)candidate == v) return json_real(candidate);
    }
    return json_real(job_number_rounded((double)v, 9)); /* nine always suffice */
}

json_t *job_number_write3(const float v[3])
{
    json_t *array = json_array();
    for (int i = 0; array && i < 3; i++)
        if (json_array_append_new(array, job_number_write(v[i]))) {
            json_decref(array);
            return NULL;
        }
    return array;
}
