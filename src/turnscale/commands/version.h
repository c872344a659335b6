// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// The version of this build, such as 0.1.0.
const char* Version();

}  // namespace turnscale
