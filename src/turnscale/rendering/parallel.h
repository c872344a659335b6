// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

namespace turnscale {

/// Calls `work` for 0...count-1, from so many threads, each index once, in no order that could be relied on. The first
/// exception that `work` throws ends it and is thrown on.
void ForEachIndex(int count, int threads, const std::function<void(int)>& work);

}  // namespace turnscale
