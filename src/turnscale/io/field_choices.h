// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <utility>

namespace turnscale {

/// The words that a field of a settings file may hold, and what they mean.
template <class Value>
using Choices = std::initializer_list<std::pair<const char*, Value>>;

}  // namespace turnscale
