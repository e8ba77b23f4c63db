#pragma once
/* The system calls that an import needs, and no others: no sockets, no programs, no other
 * processes, no signals to any, no memory that is both written and run. Whatever else is tried ends
 * the process (SIGSYS). For good: a filter cannot be taken off. Needs no_new_privs. */

/* 0, or ERR_UNSUPPORTED for a kernel without seccomp filters: every Linux since 3.5 can have them,
 * and an import without is not done. */
int syscalls_confine(void);
