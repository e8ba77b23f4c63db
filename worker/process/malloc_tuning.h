#pragma once
/* The worker's heap while tiles follow each other. */

/* Keeps what is freed instead of giving it back: every tile asks for as much again, and each fresh
 * page would be cleared by the kernel first. At most 64 MiB a thread stay unused. Call before the
 * first thread starts. */
void malloc_tuning_apply(void);
