/* The table of kernels, compiled once for each instruction set: define LENS_KERNELS as its name and
 * include this. The same operations in the same order everywhere: pictures do not depend on the
 * CPU. */
#include "server/reconstruct/lens/lens_add_lanes.h"
#include "server/reconstruct/lens/lens_cell_lanes.h"
#include "server/reconstruct/lens/lens_lanes.h"
#include "server/reconstruct/lens/lens_view_lanes.h"

const struct lens_kernels LENS_KERNELS = {
    .gather = kernel_gather,
    .layers = kernel_layers,
    .lines = kernel_lines,
    .add = kernel_add,
    .slopes = kernel_slopes,
    .passes = kernel_passes,
    .finish = kernel_finish,
    .focus = kernel_focus,
    .composite = kernel_composite,
};
