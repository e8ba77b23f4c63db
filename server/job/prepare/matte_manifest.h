#pragma once
/* The names of a scene's objects and materials beside their ids, as EXR files of the layers
 * CryptoObject and CryptoMaterial carry them. */
#include "proto/job/job.h"
#include "server/image/exr_mattes.h"
#include "server/job/plan/plan.h"

/* The most names that a manifest has. Ids of names that none tells of are found by picking them. */
#define MATTE_MANIFEST_NAMES 65536u

/* Makes {"name": "id in hexadecimal", ...} of the layers that the job has, in the order of names. A
 * name that is no UTF-8 is left out; that others are, because there are too many, is a warning of
 * the report. ERR_MEMORY. */
int matte_manifest_make(const struct job *job, const struct scene *scene,
                        struct plan_report *report, struct exr_mattes **out);
