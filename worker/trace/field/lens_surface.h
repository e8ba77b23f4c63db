#pragma once
/* The surfaces that lens samples meet, for relighting by the light fields of pixel centres, and the
 * radiance of the samples without that light. */
#include "proto/samples.h"
#include "worker/trace/path/path.h"

/* Removes the light that fields bring from the radiance's slot. */
void lens_surface_take_out(const struct path_context *c, size_t slot, struct path_radiance *h);

/* Stores depth, normal, albedo and own light of lens sample `sample`, which lies in the radiance
 * from slot `first` on, and removes the light of fields from the radiance. Does nothing under a
 * plan whose light fields light no lens samples. */
void lens_surface_store(const struct path_context *c, const struct block *b, size_t first,
                        uint32_t sample, struct path_radiance *h, struct samples *samples);
