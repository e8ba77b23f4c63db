#pragma once
/* The fake worker's link: a blocking socket. What cannot be sent ends it. */
#include <stddef.h>

#include "tests/fake/worker/fake.h"

/* A connected socket to unix:PATH or HOST:PORT, which the caller closes, or -1. */
int link_dial(const char *address);
void link_lose(struct fake *f);
/* The coordinator may wait for what a damaged length promised: the link is ended from here. */
void link_end_soon(struct fake *f);

void link_send(struct fake *f, const void *data, size_t size_bytes);
/* Takes the head over and frees it. */
void link_send_message(struct fake *f, uint16_t type, uint64_t request_id,
                       struct bytes_writer *head, const void *tail, size_t tail_bytes);
void link_send_want(struct fake *f, uint32_t tiles);
