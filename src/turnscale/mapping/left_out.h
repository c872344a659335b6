// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

namespace turnscale {

/// The values of those that are not left out (one flag per value).
template <typename T>
std::vector<T> Without(const std::vector<char>& left_out, const std::vector<T>& values) {
  std::vector<T> kept;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (left_out[i] == 0) kept.push_back(values[i]);
  return kept;
}

/// The inverse of Without: the values of all, where those that are left out have `nothing`.
template <typename T>
std::vector<T> OfAll(const std::vector<char>& left_out, const std::vector<T>& kept, const T& nothing) {
  std::vector<T> values(left_out.size(), nothing);
  for (std::size_t i = 0, k = 0; i < values.size(); ++i)
    if (left_out[i] == 0) values[i] = kept[k++];
  return values;
}

}  // namespace turnscale
