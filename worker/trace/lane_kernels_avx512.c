#define LANE_KERNELS lane_kernels_avx512
#include "worker/trace/lane_kernels_body.h"
