/* All instruction sets have the same operations in the same order: pictures do not depend on the
 * CPU. */
#include "server/reconstruct/lens/lens_kernels.h"

#include "server/reconstruct/lens/lens_add_lanes.h"
#include "server/reconstruct/lens/lens_cell_lanes.h"
#include "server/reconstruct/lens/lens_lanes.h"
#include "server/reconstruct/lens/lens_view_lanes.h"

const struct lens_kernels KERNELS(lens_kernels) = {
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
