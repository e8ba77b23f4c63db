#pragma once
/* The name under which a worker that was given none appears in the list of workers. */
#include <stddef.h>

/* Writes a name: under Slurm "HOST:slurm-JOB" or "HOST:slurm-ARRAY_TASK", with ".N" for the
 * processes of a step behind its first, in Kubernetes the pod's name ($POD_NAME, else $HOSTNAME),
 * elsewhere "HOST:PID". An engine's word that is too long or has other characters than letters,
 * digits and "._-" is passed over. ERR_LIMIT. */
int worker_name_default(char *out, size_t capacity);
