// SPDX-License-Identifier: MIT
#include "turnscale/live/live_page.h"

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr auto kNever = [] { return false; };

class LivePageTest : public ::testing::Test {
 protected:
  LivePageTest() : odometry_({}, {}), state_("drive", "1.0", 100, 0), page_(ShortEnd(), state_), client_(Address()) {}

  static LivePageOptions ShortEnd() {
    LivePageOptions options;
    options.report_wait = std::chrono::milliseconds(4000);
    options.last_answers = std::chrono::milliseconds(1000);
    return options;
  }

  std::string Address() const {
    const std::string address = page_.address();
    return address.substr(0, address.size() - 1);
  }

  void AddFrames(int count) {
    for (int i = 0; i < count; ++i) {
      FrameResult frame;
      frame.frame = frames_;
      frame.time = 0.1 * frames_++;
      state_.Add(cv::Mat(60, 80, CV_8UC1, cv::Scalar(90)), frame, odometry_);
    }
  }

  int Port() const { return std::stoi(Address().substr(Address().rfind(':') + 1)); }

  // A viewer's connection, which says nothing yet; the system keeps so many bytes for it (0: as usual).
  static int Connect(int port, int kept = 0) {
    const int handle = socket(AF_INET, SOCK_STREAM, 0);
    if (kept > 0) setsockopt(handle, SOL_SOCKET, SO_RCVBUF, &kept, sizeof kept);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(port));
    EXPECT_EQ(connect(handle, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return handle;
  }

  nlohmann::json State() {
    const auto answer = client_.Get("/state.json?viewer=a");
    return answer ? nlohmann::json::parse(answer->body) : nlohmann::json();
  }

  Odometry odometry_;
  LiveState state_;
  LivePage page_;
  httplib::Client client_;
  int frames_ = 0;
};

TEST_F(LivePageTest, ShowsTheStateAndTheImage) {
  const auto page = client_.Get("/");
  ASSERT_TRUE(page);
  EXPECT_NE(page->body.find("<title>live - turnscale</title>"), std::string::npos);
  AddFrames(3);
  EXPECT_EQ(client_.Get("/image.jpg")->status, 404) << "nobody has watched yet";
  EXPECT_EQ(State()["frame"], 3);
  AddFrames(2);
  const nlohmann::json state = State();
  EXPECT_EQ(state["frame"], 5);
  EXPECT_EQ(state["frames"], 100);
  EXPECT_EQ(state["image"], 1);
  EXPECT_FALSE(state["finished"]);
  EXPECT_EQ(client_.Get("/image.jpg")->body.substr(0, 2), "\xff\xd8");
  EXPECT_EQ(nlohmann::json::parse(client_.Get("/path.json")->body)["title"], "drive");
}

TEST_F(LivePageTest, ATotalThatIsExceededIsNoLongerShown) {
  AddFrames(100);
  EXPECT_EQ(State()["frames"], 100);
  AddFrames(1);
  EXPECT_EQ(State()["frames"], 0);
}

TEST_F(LivePageTest, ServesNothingElse) {
  for (const char* path : {"/index.html", "/etc/passwd", "/../../etc/passwd", "/%2e%2e/etc/passwd", "/report.html"})
    EXPECT_EQ(client_.Get(path)->status, 404) << path;
  // Pages of other sites: under a name of theirs for this machine, or without the header.
  EXPECT_EQ(client_.Get("/state.json", {{"Host", "elsewhere.example"}})->status, 403);
  EXPECT_EQ(client_.Post("/pause", "", "text/plain")->status, 403);
  EXPECT_FALSE(state_.IsPaused());
}

TEST_F(LivePageTest, PausesAndResumes) {
  const httplib::Headers headers = {{"X-Turnscale", "1"}};
  EXPECT_EQ(client_.Post("/pause", headers, "", "text/plain")->status, 200);
  EXPECT_TRUE(state_.IsPaused());
  page_.WaitWhilePaused([] { return true; });
  std::atomic<bool> resumed = false;
  std::thread run([&] {
    page_.WaitWhilePaused([] { return false; });
    resumed = true;
  });
  EXPECT_FALSE(resumed);
  EXPECT_EQ(client_.Post("/resume", headers, "", "text/plain")->status, 200);
  run.join();
  EXPECT_TRUE(resumed);
}

TEST_F(LivePageTest, APauseEndsWhenItsViewerHasLeft) {
  LiveState state("drive", "1.0", 100, 0, "", std::chrono::milliseconds(200));
  const LivePage page({}, state);
  state.SetPaused(true);
  const auto begin = std::chrono::steady_clock::now();
  // A viewer who asks keeps it.
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    state.StateJson();
    EXPECT_TRUE(state.IsPaused()) << i;
  }
  page.WaitWhilePaused([&] { return std::chrono::steady_clock::now() - begin > std::chrono::seconds(60); });
  EXPECT_FALSE(state.IsPaused());
  state.StateJson();
  EXPECT_FALSE(state.IsPaused()) << "one who comes back does not pause it again";
}

TEST_F(LivePageTest, WarningsAreBounded) {
  for (int i = 0; i < 1000; ++i) state_.AddWarning("frame " + std::to_string(i) + ": cannot be read");
  const nlohmann::json warnings = State()["warnings"];
  ASSERT_EQ(warnings.size(), 11u);
  EXPECT_EQ(warnings[0], "frame 0: cannot be read");
  EXPECT_EQ(warnings[10], "990 more, in the report");
}

TEST_F(LivePageTest, BecomesTheReport) {
  AddFrames(1);
  State();
  std::thread end([&] { page_.Finish("<p>the report", kNever); });
  nlohmann::json state = State();
  for (int i = 0; i < 100 && state.is_object() && !state["finished"].get<bool>(); ++i) state = State();
  EXPECT_TRUE(state["finished"].get<bool>());
  EXPECT_EQ(client_.Get("/report.html?viewer=a")->body, "<p>the report");
  end.join();
  EXPECT_FALSE(client_.Get("/state.json")) << "the server has stopped";
}

// That would take seconds of a page of megabytes.
TEST_F(LivePageTest, CompressesNothing) {
  const auto page = client_.Get("/", {{"Accept-Encoding", "br, gzip, deflate"}});
  ASSERT_TRUE(page);
  EXPECT_FALSE(page->has_header("Content-Encoding"));
  EXPECT_EQ(page->get_header_value("Content-Length"), std::to_string(page->body.size()));
}

TEST_F(LivePageTest, WaitsForNobodyWhoHasLeft) {
  AddFrames(1);
  State();
  EXPECT_EQ(client_.Post("/leave?viewer=a")->status, 200);
  const auto begin = std::chrono::steady_clock::now();
  page_.Finish("<p>the report", kNever);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(3000)) << "of 4000";
}

TEST_F(LivePageTest, TheWaitForViewersCanBeStopped) {
  AddFrames(1);
  State();
  const auto begin = std::chrono::steady_clock::now();
  page_.Finish("<p>the report", [] { return true; });
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(3000)) << "of 4000";
}

TEST_F(LivePageTest, NamesWhatTheProgramDoes) {
  EXPECT_EQ(State()["phase"], "");
  state_.SetPhase("final adjustment");
  EXPECT_EQ(State()["phase"], "final adjustment");
}

TEST_F(LivePageTest, StalledViewersHoldUpNobody) {
  // They open a connection and say nothing.
  std::vector<int> stalled;
  for (int i = 0; i < 20; ++i) stalled.push_back(Connect(Port()));
  AddFrames(1);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(State()["frame"], 1);
  for (const int handle : stalled) close(handle);
}

TEST_F(LivePageTest, SlowViewersDoNotHoldUpTheEnd) {
  // One sends its request letter by letter, one asks for a report that it does not read.
  const int sender = Connect(Port());
  const int reader = Connect(Port());
  const std::string request = "GET /report.html?viewer=b HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  std::atomic<bool> over = false;
  std::thread slow([&] {
    for (size_t i = 0; !over; ++i) {
      send(sender, i == 0 ? "G" : "x", 1, MSG_NOSIGNAL);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  AddFrames(1);
  State();
  std::thread late([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    send(reader, request.data(), request.size(), MSG_NOSIGNAL);
  });
  const auto begin = std::chrono::steady_clock::now();
  std::string report;
  report.resize(30'000'000, 'x');
  page_.Finish(report, kNever);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  over = true;
  slow.join();
  late.join();
  close(sender);
  close(reader);
}

TEST(LiveState, CountsFromTheFirstFrameOfTheDrive) {
  LiveState state("drive", "1.0", 100, 12.5);
  EXPECT_EQ(nlohmann::json::parse(state.PathJson())["timeOrigin"], 12.5);
}

// The report is longer than what the system keeps for a viewer.
TEST_F(LivePageTest, ViewersWhoDoNotReadTheReportHoldUpNobody) {
  LiveState state("drive", "1.0", 100, 0);
  LivePage page({}, state);
  const std::string address = page.address();
  const std::string port = address.substr(address.rfind(':') + 1);
  httplib::Client client("127.0.0.1", std::stoi(port));
  client.set_read_timeout(60);
  ASSERT_TRUE(client.Get("/state.json?viewer=a"));
  std::string report;
  report.resize(12'000'000, 'x');
  std::thread end([&] { page.Finish(report, kNever); });
  while (!nlohmann::json::parse(client.Get("/state.json?viewer=a").value().body)["finished"].get<bool>())
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::vector<int> stalled;
  const std::string request = "GET /report.html HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  for (int i = 0; i < 10; ++i) {
    stalled.push_back(Connect(std::stoi(port), 4096));
    send(stalled.back(), request.data(), request.size(), MSG_NOSIGNAL);
  }
  const auto answer = client.Get("/report.html?viewer=a");
  EXPECT_TRUE(answer && answer->body == report);
  end.join();
  for (const int handle : stalled) close(handle);
}

TEST(LiveAddress, HostAndPort) {
  EXPECT_EQ(ParseLiveAddress("--live-address", "0.0.0.0:8000").port, 8000);
  EXPECT_EQ(ParseLiveAddress("--live-address", "0.0.0.0:8000").host, "0.0.0.0");
  EXPECT_EQ(ParseLiveAddress("--live-address", ":80").host, "127.0.0.1");
  EXPECT_EQ(ParseLiveAddress("--live-address", "localhost").port, 0);
  EXPECT_EQ(ParseLiveAddress("--live-address", "[::1]:8000").host, "::1");
  EXPECT_EQ(ParseLiveAddress("--live-address", "[::1]:8000").port, 8000);
  EXPECT_EQ(ParseLiveAddress("--live-address", "::").host, "::");
  for (const char* wrong : {"host:port", "host:70000", "[::1]:port"})
    EXPECT_THROW(ParseLiveAddress("--live-address", wrong), InputError) << wrong;
}

class ListeningElsewhere : public ::testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(ListeningElsewhere, AnswersThere) {
  const auto [host, address] = GetParam();
  LiveState state("drive", "1.0", 100, 0);
  std::optional<LivePage> page;
  try {
    LivePageOptions options;
    options.host = host;
    page.emplace(options, state);
  } catch (const InputError&) {
    GTEST_SKIP() << "this machine has no address " << host;
  }
  EXPECT_EQ(page->address().substr(0, address.size()), address);
  const std::string port = page->address().substr(page->address().rfind(':') + 1);
  httplib::Client client(host.find(':') == std::string::npos ? "127.0.0.1" : "::1", std::stoi(port));
  // As a browser names the host that it asks.
  for (const std::string& name :
       {address.substr(7) + port, std::string("localhost:") + port, std::string("LocalHost:") + port,
        std::string("192.0.2.7:") + port, std::string("[fd00::7]:") + port}) {
    const auto answer = client.Get("/state.json", {{"Host", name}});
    ASSERT_TRUE(answer) << host;
    EXPECT_EQ(answer->status, 200) << host << " asked as " << name;
  }
  // A name that another site may have given to this machine.
  const auto refused = client.Get("/state.json", {{"Host", "elsewhere.example:" + port}});
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 403) << host;
}

INSTANTIATE_TEST_SUITE_P(Addresses, ListeningElsewhere,
                         ::testing::Values(std::pair<std::string, std::string>("0.0.0.0", "http://127.0.0.1:"),
                                           std::pair<std::string, std::string>("::1", "http://[::1]:"),
                                           std::pair<std::string, std::string>("::", "http://[::1]:"),
                                           std::pair<std::string, std::string>("localhost", "http://localhost:")));

}  // namespace
}  // namespace turnscale
