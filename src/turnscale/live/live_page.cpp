// SPDX-License-Identifier: MIT
#include "turnscale/live/live_page.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/report/report_page.h"

namespace turnscale {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kThreads = 32;
constexpr int kNicenessIncrement = 10;     // niceness beyond that of the run
constexpr milliseconds kPollInterval(20);  // of a wait
constexpr int kTimeoutSeconds = 2;         // of a viewer that stalls
constexpr int kBacklog = 128;              // connections that wait for a thread; the library's 5 make browsers wait
constexpr int kForbidden = 403;
constexpr int kNotFound = 404;

// Host and port of "host:port", "[address]:port" or an address alone; what is not there is empty.
std::pair<std::string, std::string> SplitAddress(const std::string& text) {
  if (text.starts_with('[')) {
    const size_t end = std::min(text.find(']'), text.size());
    const size_t port = text.find(':', end);
    return {text.substr(1, end - 1), port == std::string::npos ? "" : text.substr(port + 1)};
  }
  const size_t colon = text.find(':');
  // More than one: an IPv6 address.
  if (colon == std::string::npos || text.find(':', colon + 1) != std::string::npos) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

// An address in numbers, no name.
bool IsNumeric(const std::string& host) {
  in6_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1 || inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

// Browsers write names of machines in lower case.
bool IsSameName(const std::string& a, const std::string& b) {
  return std::ranges::equal(a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

int PortOf(const sockaddr_storage& address) {
  if (address.ss_family == AF_INET) return ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port);
  if (address.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
  return -1;
}

// With its length given, the library sends it as it is: compressing a page of megabytes takes seconds.
void Send(std::string body, const char* type, httplib::Response& response) {
  const auto kept = std::make_shared<const std::string>(std::move(body));
  response.set_content_provider(kept->size(), type, [kept](size_t offset, size_t length, httplib::DataSink& sink) {
    return sink.write(kept->data() + offset, length);
  });
}

// Ends the connections of this process's sockets of that port, so that no thread waits for their viewers.
void CutConnections(int port) {
  std::error_code none;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", none), end; entry != end; entry.increment(none)) {
    const int handle = ParseNumber<int>(entry->path().filename().string()).value_or(-1);
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (getsockname(handle, reinterpret_cast<sockaddr*>(&address), &size) == 0 && PortOf(address) == port)
      shutdown(handle, SHUT_RDWR);
  }
}

}  // namespace

LivePageOptions ParseLiveAddress(const std::string& option, const std::string& text) {
  LivePageOptions address;
  const auto [host, port_text] = SplitAddress(text);
  if (!host.empty()) address.host = host;
  if (!port_text.empty()) {
    const auto port = ParseNumber<int>(port_text);
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
    int listener = -1;
    server_.set_socket_options([&listener](socket_t socket) {
      listener = socket;
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    port_ = options.port > 0 ? (server_.bind_to_port(options.host, options.port) ? options.port : -1)
                             : server_.bind_to_any_port(options.host);
    if (port_ < 0) {
      throw InputError("--live-address " + options.host + ":" + std::to_string(options.port) +
                       ": cannot listen there; choose another port, or an address of this machine");
    }
    listen(listener, kBacklog);
    thread_ = std::thread([this] {
      // Threads inherit the priority of the one that makes them.
      const auto self = static_cast<id_t>(gettid());
      setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + kNicenessIncrement);
      server_.listen_after_bind();
      ended_ = true;
    });
    while (!server_.is_running() && !ended_) std::this_thread::sleep_for(kPollInterval);
    if (!ended_) return;
    thread_.join();
    throw InputError("--live-address " + options.host + ":" + std::to_string(port_) +
                     ": the page cannot be served there; choose another port, or leave out --live");
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server() {
    Stop([] { return false; });
  }

  std::string address() const {
    // Where it listens on all addresses, this machine's own.
    const std::string host = options_.host == "0.0.0.0" ? "127.0.0.1" : options_.host == "::" ? "::1" : options_.host;
    return "http://" + (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" + std::to_string(port_) +
           "/";
  }
  bool IsPaused() const {
    state_.EndStalePause();
    return state_.IsPaused();
  }

  void Finish(const std::string& report, const std::function<bool()>& stop) {
    {
      const std::lock_guard lock(mutex_);
      report_ = report;
    }
    state_.Finish();
    const auto end = Clock::now() + options_.report_wait;
    const auto all_served = [&] {
      const std::lock_guard lock(mutex_);
      return viewers_.empty();
    };
    ForgetThoseWhoAskNoMore();
    while (!all_served() && !stop() && Clock::now() < end) std::this_thread::sleep_for(kPollInterval);
    Stop(stop);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void Stop(const std::function<bool()>& stop) {
    server_.stop();
    // A viewer that reads or sends a little at a time would keep its thread for as long as it likes.
    const auto patience = Clock::now() + options_.last_answers;
    while (!ended_) {
      if (Clock::now() > patience || stop()) CutConnections(port_);
      std::this_thread::sleep_for(kPollInterval);
    }
    if (thread_.joinable()) thread_.join();
  }

  // Another site can make its name lead here; the browser then sends that name, never an address in numbers.
  bool Knows(const std::string& host) const {
    return IsNumeric(host) || IsSameName(host, "localhost") || IsSameName(host, options_.host);
  }

  void Route() {
    server_.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      response.set_header("Cache-Control", "no-store");
      response.set_header("X-Content-Type-Options", "nosniff");
      // Browsers send no header when a page is left; who leaves is named by a number that other sites do not know.
      const bool named = Knows(SplitAddress(request.get_header_value("Host")).first);
      const bool ours = request.method == "GET" || request.path == "/leave" || request.has_header("X-Turnscale");
      if (named && ours) return httplib::Server::HandlerResponse::Unhandled;
      response.status = kForbidden;
      if (!named) response.set_content("Open this page by the address of the machine in numbers.\n", "text/plain");
      return httplib::Server::HandlerResponse::Handled;
    });
    server_.Get("/", [this](const auto&, auto& response) {
      const std::string report = Report();
      Send(report.empty() ? page_ : report, "text/html; charset=utf-8", response);
    });
    server_.Get("/state.json", [this](const auto& request, auto& response) {
      Remember(request.get_param_value("viewer"));
      Send(state_.StateJson(), "application/json", response);
    });
    server_.Get("/path.json",
                [this](const auto&, auto& response) { Send(state_.PathJson(), "application/json", response); });
    server_.Get("/image.jpg", [this](const auto&, auto& response) {
      const std::string image = state_.Image();
      if (image.empty()) {
        response.status = kNotFound;
      } else {
        Send(image, "image/jpeg", response);
      }
    });
    server_.Get("/report.html", [this](const auto&, auto& response) {
      const std::string report = Report();
      if (report.empty()) {
        response.status = kNotFound;
      } else {
        Send(report, "text/html; charset=utf-8", response);
      }
    });
    // After an answer has been sent.
    server_.set_logger([this](const httplib::Request& request, const httplib::Response&) {
      const std::lock_guard lock(mutex_);
      if (request.path == "/report.html") viewers_.erase(request.get_param_value("viewer"));
    });
    server_.Post("/leave", [this](const auto& request, auto&) {
      const std::lock_guard lock(mutex_);
      viewers_.erase(request.get_param_value("viewer"));
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
    constexpr size_t kMost = 1000;
    ForgetThoseWhoAskNoMore();
    const std::lock_guard lock(mutex_);
    if (!viewer.empty() && viewers_.size() < kMost) viewers_[viewer] = Clock::now();
  }

  void ForgetThoseWhoAskNoMore() {
    constexpr seconds kKept(15);  // those who leave say so
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    std::erase_if(viewers_, [&](const auto& seen) { return now - seen.second > kKept; });
  }

  const LivePageOptions options_;
  LiveState& state_;
  const std::string page_ = ReportPage("live", "");
  httplib::Server server_;
  std::thread thread_;
  std::atomic<bool> ended_ = false;
  int port_ = -1;
  std::mutex mutex_;
  std::string report_;
  std::map<std::string, Clock::time_point> viewers_;  // without the report
};

LivePage::LivePage(const LivePageOptions& options, LiveState& state)
    : server_(std::make_unique<Server>(options, state)) {}

LivePage::~LivePage() = default;

std::string LivePage::address() const { return server_->address(); }

void LivePage::WaitWhilePaused(const std::function<bool()>& stop) const {
  while (server_->IsPaused() && !stop()) std::this_thread::sleep_for(kPollInterval);
}

void LivePage::Finish(const std::string& report, const std::function<bool()>& stop) { server_->Finish(report, stop); }

}  // namespace turnscale
