// SPDX-License-Identifier: MIT
#include "turnscale/commands/version.h"

namespace turnscale {

const char* Version() { return TURNSCALE_VERSION; }

}  // namespace turnscale
