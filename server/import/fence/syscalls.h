#pragma once
/* Allows only the system calls that an import needs. There are no sockets, no programs, no other
 * processes or signals to them, and no memory that is both written and run. Any other call ends the
 * process (SIGSYS). A filter cannot be removed. It needs no_new_privs. */

/* Returns 0, or ERR_UNSUPPORTED on a kernel without seccomp filters, where nothing may be imported.
 * Every Linux since 3.5 can have them. */
int syscalls_confine(void);
