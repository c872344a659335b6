// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <vector>

namespace turnscale {

/// The page as web/dist/page.html has it, in pieces: without data.
std::vector<std::string_view> PageText();

}  // namespace turnscale
