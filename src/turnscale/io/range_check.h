// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// Throws InputError where `value` is not in `low`...`high`. `field`: its name in the file of settings, with its group;
/// `unit`: of the range, may be empty.
void CheckRange(const char* field, double value, double low, double high, const char* unit = "");

}  // namespace turnscale
