#pragma once
/* An array of workers as a batch script of Slurm's: one task a worker. */
#include <stdint.h>
#include <stdio.h>

#include "proto/error.h"

#define SLURM_ARRAY_MIN_S 120u /* of time: the drain begins up to 90 s before its end */

struct slurm_array {
    const char *connect;   /* the coordinator's HOST:PORT for workers */
    const char *key;       /* absolute path of the key's file, as nodes see it */
    const char *program;   /* path of shearwater-worker there, or a name in $PATH */
    const char *isa;       /* instruction set of the farm; NULL: the best of each node */
    long jobs, cpus;       /* tasks of the array; threads of each */
    uint32_t time_s;       /* limit of each */
    long idle_exit_s;      /* a worker without a tile leaves after this time */
    long connect_within_s; /* it fails when the coordinator has not answered by then */
};

/* Reads a time as Slurm writes it: MINUTES, M:S, H:M:S, D-H, D-H:M or D-H:M:S. ERR_SYNTAX;
 * ERR_RANGE for less than SLURM_ARRAY_MIN_S or more than a year. */
int slurm_array_read_time(const char *text, uint32_t *time_s, struct fault *fault);

/* Checks what goes into the script. *fault names the option. */
int slurm_array_check(const struct slurm_array *array, struct fault *fault);

/* Writes the script. ERR_IO. */
int slurm_array_write(const struct slurm_array *array, FILE *out);

/* Hands the script to sbatch, which prints the job's number. ERR_NOT_FOUND without sbatch,
 * ERR_STATE when it refuses, ERR_IO. */
int slurm_array_submit(const struct slurm_array *array, struct fault *fault);
