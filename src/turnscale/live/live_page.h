// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "turnscale/live/live_state.h"

namespace turnscale {

struct LivePageOptions {
  std::string host = "127.0.0.1";  ///< address of this machine to listen on
  int port = 0;                    ///< 0: a free one
  /// At the end, for viewers to ask for the report, and then for answers that are being sent. Generous, since the
  /// threads that answer have to wait on a busy machine; viewers that are there end the wait.
  std::chrono::milliseconds report_wait{10'000};
  std::chrono::milliseconds last_answers{15'000};
};

/// "HOST:PORT", "HOST" or ":PORT"; an IPv6 address with a port stands in brackets, "[::1]:8000". Throws InputError that
/// names the option.
LivePageOptions ParseLiveAddress(const std::string& option, const std::string& text);

/// A web server with one page that shows a run while it goes on. It serves nothing but the page and its data. Requests
/// are answered one by one and by threads of low priority, so that a viewer that stalls or leaves holds up neither the
/// run nor other viewers. A request has to name a host that it was opened for, and to pause it needs a header that
/// pages of other sites cannot send. Where it listens on all addresses, only their numbers and localhost are such
/// names: any other could be one that another site has given to this machine.
class LivePage {
 public:
  /// Starts to listen. Throws InputError if the address cannot be used.
  LivePage(const LivePageOptions& options, LiveState& state);
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  ~LivePage();

  /// Such as http://127.0.0.1:8731/
  std::string address() const;

  /// Returns when the run is not paused, or `stop` returns true.
  void WaitWhilePaused(const std::function<bool()>& stop) const;

  /// The run is over: viewers get `report`, the page of its results (empty if there is none). Waits until all who have
  /// looked lately have it or have left, but no longer than `report_wait`; then the server stops, and connections that
  /// are still open after `last_answers` are cut. Neither wait goes on when `stop` returns true.
  void Finish(const std::string& report, const std::function<bool()>& stop);

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace turnscale
