// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "turnscale/live/live_state.h"

namespace turnscale {

struct LivePageOptions {
  std::string host = "127.0.0.1";  ///< address of this machine to listen on
  int port = 0;                    ///< 0: a free one
};

/// "HOST:PORT", "HOST" or ":PORT". Throws InputError that names the option.
LivePageOptions ParseLiveAddress(const std::string& option, const std::string& text);

/// A web server with one page that shows a run while it goes on. It serves nothing but the page and its data. Requests
/// are answered one by one and by threads of low priority, so that a viewer that stalls or leaves holds up neither the
/// run nor other viewers. A request has to name a host that it was opened for, and to pause it needs a header that
/// pages of other sites cannot send.
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
  /// looked lately have it, but no longer than some seconds; then the server stops.
  void Finish(const std::string& report);

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace turnscale
