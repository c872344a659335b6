// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace turnscale {

/// The self-contained page with its data, JSON as of ReportJson; empty data give the page that follows a running
/// program.
std::string ReportPage(std::string_view title, std::string_view json);

/// Whether ReportPage has made it, also of another version.
bool IsReportPage(std::string_view page);

/// The data of a page that ReportPage has made, also by another version. Throws InputError, with the page's name, if it
/// is none.
std::string DataOfPage(std::string_view page, const std::string& name);

}  // namespace turnscale
