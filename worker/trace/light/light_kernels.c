#include "worker/trace/light/light_kernels.h"

#include "worker/trace/light/light_lanes.h"
#include "worker/trace/light/shadow_lanes.h"

const struct light_kernels KERNELS(light_kernels) = {
    .sample_light = kernel_sample_light,
    .light_hidden = kernel_light_hidden,
    .lattice_jitters = kernel_lattice_jitters,
    .place_strata = kernel_place_strata,
    .sample_strata = kernel_sample_strata,
    .add_strata = kernel_add_strata,
    .store_visibility = kernel_store_visibility,
    .add_slopes = kernel_add_slopes,
};
