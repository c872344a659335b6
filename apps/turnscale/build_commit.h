// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// The commit that this was built from, as `git describe` gives it; empty where neither git nor an archive tells it.
/// Every build writes the definition anew where it has changed (cmake/WriteCommit.cmake).
const char* BuildCommit();

}  // namespace turnscale
