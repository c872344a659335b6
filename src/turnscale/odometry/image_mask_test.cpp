// SPDX-License-Identifier: MIT
#include "turnscale/odometry/image_mask.h"
