#pragma once
/* Clocks of the system, as one number each. */
#include <stdint.h>
#include <time.h>

/* Returns a clock's time; 0 where there is no such clock. */
uint64_t clock_ns(clockid_t clock);
uint64_t clock_us(clockid_t clock);

/* Returns the CPU time that the calling thread has used. */
uint64_t thread_cpu_us(void);
