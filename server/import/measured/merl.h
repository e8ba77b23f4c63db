#pragma once
/* Measured isotropic reflectance in the binary format of the MERL database (Matusik et al. 2003, "A
 * data-driven reflectance model").
 *
 * A file has three i32, the bins of theta_h, theta_d and phi_d (90, 90 and 180 in the database,
 * from 2 to 1024 here), and then as many f64 for each of red, green and blue, phi_d running
 * fastest. Angles are Rusinkiewicz's (1998): of the half vector to the normal, up to 90 degrees in
 * bins whose edges grow as squares; of the directions to it, 90 degrees; around it, 180 degrees, as
 * light may go either way. Numbers times 1/1500, 1.15/1500 and 1.66/1500 are the BRDF. */
#include "server/import/fence/files.h"

#define MERL_BINS_MAX 1024
/* Cosine to the normal below which nothing is read: measurements beyond 80 degrees are unreliable
 * (Ngan et al. 2005, "Experimental analysis of BRDF models"), and files have any numbers where a
 * direction lies below the horizon. */
#define MERL_COSINE_MIN 0.173648178

struct merl {
    const uint8_t *data; /* borrowed */
    uint32_t bins[3];    /* of theta_h, theta_d, phi_d */
};

/* The middle of a bin. Directions are unit, z the normal. */
struct merl_bin {
    double wo[3], wi[3], h[3];
    double cosine;   /* wo.h */
    double measure;  /* of pairs of directions that it holds, times both cosines; up to a factor */
    double value[3]; /* the BRDF, rgb */
};

/* Looks at a file, which must outlive *out, and at every number that merl_read may return.
 * ERR_TRUNCATED and ERR_SYNTAX for sizes, ERR_NOT_FINITE and ERR_RANGE for numbers; the fault says
 * which bin it is. */
int merl_open(const struct file_view *file, const char *place, struct merl *out,
              struct fault *fault);

/* Reads a bin. Returns false where a direction is below MERL_COSINE_MIN. */
bool merl_read(const struct merl *m, uint32_t theta_h, uint32_t theta_d, uint32_t phi_d,
               struct merl_bin *out);
