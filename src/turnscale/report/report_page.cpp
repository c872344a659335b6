// SPDX-License-Identifier: MIT
#include "turnscale/report/report_page.h"

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/report/page_text.h"

namespace turnscale {
namespace {

// Where web/src/page.html has its title and its data.
constexpr std::string_view kTitle = "<title>turnscale</title>";
constexpr std::string_view kBegin = "<script type=\"application/json\" id=\"data\">";
constexpr std::string_view kEnd = "</script>";

}  // namespace

std::string ReportPage(std::string_view title, std::string_view json) {
  std::string page;
  for (const std::string_view piece : PageText()) page += piece;
  const size_t title_at = page.find(kTitle);
  const size_t data_at = page.find(kBegin);
  Ensure(title_at < data_at && data_at != std::string::npos, "the page has no place for its data");
  page.insert(data_at + kBegin.size(), json);
  page.replace(title_at, kTitle.size(), "<title>" + EscapedXml(title) + " - turnscale</title>");
  return page;
}

bool IsReportPage(std::string_view page) { return page.find(kBegin) != std::string_view::npos; }

std::string DataOfPage(std::string_view page, const std::string& name) {
  const size_t begin = page.find(kBegin);
  const size_t end = begin == std::string_view::npos ? begin : page.find(kEnd, begin);
  if (end == std::string_view::npos) throw InputError(name + ": is not a report of turnscale");
  return std::string(page.substr(begin + kBegin.size(), end - begin - kBegin.size()));
}

}  // namespace turnscale
