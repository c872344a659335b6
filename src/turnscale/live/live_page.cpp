// SPDX-License-Identifier: MIT
#include "turnscale/live/live_page.h"

#include <chrono>
#include <map>
#include <mutex>
#include <thread>

#include <httplib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/report/report_page.h"

namespace turnscale {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kThreads = 32;
constexpr int kLowPriority = 10;           // niceness
constexpr milliseconds kPollInterval(20);  // of a wait
constexpr seconds kFarewell(4);            // for viewers to fetch the report
constexpr int kTimeoutSeconds = 2;         // of a viewer that stalls
constexpr int kForbidden = 403;
constexpr int kNotFound = 404;

std::string HostOf(const httplib::Request& request) {
  const std::string host = request.get_header_value("Host");
  const size_t colon = host.rfind(':');
  return colon != std::string::npos && host.find(']', colon) == std::string::npos ? host.substr(0, colon) : host;
}

}  // namespace

LivePageOptions ParseLiveAddress(const std::string& option, const std::string& text) {
  LivePageOptions address;
  const size_t colon = text.rfind(':');
  if (const std::string host = text.substr(0, colon); !host.empty()) address.host = host;
  if (colon != std::string::npos) {
    const auto port = ParseNumber<int>(std::string_view(text).substr(colon + 1));
    constexpr int kMostPort = 65535;
    if (!port || *port < 0 || *port > kMostPort) throw InputError(option + " " + text + ": give HOST:PORT");
    address.port = *port;
  }
  return address;
}

class LivePage::Server {
 public:
  Server(const LivePageOptions& options, LiveState& state) : options_(options), state_(state) {
    Route();
    server_.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    // A kept connection would hold a thread.
    server_.set_keep_alive_max_count(1);
    server_.set_read_timeout(kTimeoutSeconds);
    server_.set_write_timeout(kTimeoutSeconds);
    server_.set_payload_max_length(0);
    port_ = options.port > 0 ? (server_.bind_to_port(options.host, options.port) ? options.port : -1)
                             : server_.bind_to_any_port(options.host);
    if (port_ < 0) {
      throw InputError("--live-address " + options.host + ":" + std::to_string(options.port) +
                       ": cannot listen there; choose another port, or an address of this machine");
    }
    thread_ = std::thread([this] {
      // Threads inherit the priority of the one that makes them.
      setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowPriority);
      server_.listen_after_bind();
    });
    while (!server_.is_running()) std::this_thread::sleep_for(kPollInterval);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server() { Stop(); }

  std::string address() const { return "http://" + options_.host + ":" + std::to_string(port_) + "/"; }
  bool paused() const { return state_.paused(); }

  void Finish(const std::string& report) {
    {
      const std::lock_guard lock(mutex_);
      report_ = report;
    }
    const bool watched = state_.IsWatched();
    state_.Finish();
    const auto end = std::chrono::steady_clock::now() + kFarewell;
    const auto all_served = [&] {
      const std::lock_guard lock(mutex_);
      return !viewers_.empty() && farewells_ >= viewers_.size();
    };
    while (watched && !all_served() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(kPollInterval);
    Stop();
  }

 private:
  using Clock = std::chrono::steady_clock;

  void Stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }

  bool Knows(const std::string& host) const {
    const bool local = host == "localhost" || host == "127.0.0.1" || host == "[::1]" || host == options_.host;
    const bool for_all = options_.host == "0.0.0.0" || options_.host == "::";
    return local || for_all;
  }

  void Route() {
    server_.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      response.set_header("Cache-Control", "no-store");
      response.set_header("X-Content-Type-Options", "nosniff");
      const bool allowed = Knows(HostOf(request)) && (request.method == "GET" || request.has_header("X-Turnscale"));
      if (allowed) return httplib::Server::HandlerResponse::Unhandled;
      response.status = kForbidden;
      return httplib::Server::HandlerResponse::Handled;
    });
    server_.Get("/", [this](const auto&, auto& response) {
      const std::string report = Report();
      response.set_content(report.empty() ? page_ : report, "text/html; charset=utf-8");
    });
    server_.Get("/state.json", [this](const auto& request, auto& response) {
      Remember(request.get_param_value("viewer"));
      response.set_content(state_.StateJson(), "application/json");
    });
    server_.Get("/path.json",
                [this](const auto&, auto& response) { response.set_content(state_.PathJson(), "application/json"); });
    server_.Get("/image.jpg", [this](const auto&, auto& response) {
      const std::string image = state_.Image();
      if (image.empty()) {
        response.status = kNotFound;
      } else {
        response.set_content(image, "image/jpeg");
      }
    });
    server_.Get("/report.html", [this](const auto&, auto& response) {
      const std::string report = Report();
      if (report.empty()) {
        response.status = kNotFound;
      } else {
        response.set_content(report, "text/html; charset=utf-8");
      }
      const std::lock_guard lock(mutex_);
      ++farewells_;
    });
    server_.Post("/pause", [this](const auto&, auto&) { state_.SetPaused(true); });
    server_.Post("/resume", [this](const auto&, auto&) { state_.SetPaused(false); });
  }

  std::string Report() {
    const std::lock_guard lock(mutex_);
    return report_;
  }

  // Those that have asked within the last seconds: they are waited for at the end.
  void Remember(const std::string& viewer) {
    constexpr seconds kKept(3);
    constexpr size_t kMost = 1000;
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (viewers_.size() < kMost) viewers_[viewer] = now;
    std::erase_if(viewers_, [&](const auto& seen) { return now - seen.second > kKept; });
  }

  const LivePageOptions options_;
  LiveState& state_;
  const std::string page_ = ReportPage("live", "");
  httplib::Server server_;
  std::thread thread_;
  int port_ = -1;
  std::mutex mutex_;
  std::string report_;
  std::map<std::string, Clock::time_point> viewers_;
  size_t farewells_ = 0;
};

LivePage::LivePage(const LivePageOptions& options, LiveState& state)
    : server_(std::make_unique<Server>(options, state)) {}

LivePage::~LivePage() = default;

std::string LivePage::address() const { return server_->address(); }

void LivePage::WaitWhilePaused(const std::function<bool()>& stop) const {
  while (server_->paused() && !stop()) std::this_thread::sleep_for(kPollInterval);
}

void LivePage::Finish(const std::string& report) { server_->Finish(report); }

}  // namespace turnscale
