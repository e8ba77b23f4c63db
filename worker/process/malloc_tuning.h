#pragma once
/* Settings of malloc for a process that traces one tile after the other. */

/* Makes malloc keep freed memory instead of returning it to the kernel. Every tile allocates as
 * much again, and the kernel would clear each fresh page. At most 64 MiB for each thread stay
 * unused. Call it before the first thread starts. */
void malloc_tuning_apply(void);
