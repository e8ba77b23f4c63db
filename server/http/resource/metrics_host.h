#pragma once
/* Metrics of the coordinator's own resources: its disk, its loop and threads, its process, its
 * log. */
#include <stdio.h>

struct http;
struct log;

void metrics_store(FILE *out, const struct http *http);
void metrics_log(FILE *out, const struct log *log); /* NULL: nothing */
void metrics_host(FILE *out, const struct http *http);
