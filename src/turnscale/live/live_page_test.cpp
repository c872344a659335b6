// SPDX-License-Identifier: MIT
#include "turnscale/live/live_page.h"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

class LivePageTest : public ::testing::Test {
 protected:
  LivePageTest() : odometry_({}, {}), state_("drive", "1.0", 100), page_({}, state_), client_(Address()) {}

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

TEST_F(LivePageTest, ServesNothingElse) {
  for (const char* path : {"/index.html", "/etc/passwd", "/../../etc/passwd", "/%2e%2e/etc/passwd", "/report.html"})
    EXPECT_EQ(client_.Get(path)->status, 404) << path;
  // Pages of other sites: under a name of theirs for this machine, or without the header.
  EXPECT_EQ(client_.Get("/state.json", {{"Host", "elsewhere.example"}})->status, 403);
  EXPECT_EQ(client_.Post("/pause", "", "text/plain")->status, 403);
  EXPECT_FALSE(state_.paused());
}

TEST_F(LivePageTest, PausesAndResumes) {
  const httplib::Headers headers = {{"X-Turnscale", "1"}};
  EXPECT_EQ(client_.Post("/pause", headers, "", "text/plain")->status, 200);
  EXPECT_TRUE(state_.paused());
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

TEST_F(LivePageTest, BecomesTheReport) {
  AddFrames(1);
  State();
  std::thread end([&] { page_.Finish("<p>the report"); });
  nlohmann::json state = State();
  for (int i = 0; i < 100 && state.is_object() && !state["finished"].get<bool>(); ++i) state = State();
  EXPECT_TRUE(state["finished"].get<bool>());
  EXPECT_EQ(client_.Get("/report.html")->body, "<p>the report");
  end.join();
  EXPECT_FALSE(client_.Get("/state.json")) << "the server has stopped";
}

TEST_F(LivePageTest, StalledViewersHoldUpNobody) {
  // They open a connection and say nothing.
  std::vector<int> stalled;
  for (int i = 0; i < 20; ++i) {
    const int handle = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const std::string port = Address().substr(Address().rfind(':') + 1);
    address.sin_port = htons(static_cast<uint16_t>(std::stoi(port)));
    ASSERT_EQ(connect(handle, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    stalled.push_back(handle);
  }
  AddFrames(1);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(State()["frame"], 1);
  for (const int handle : stalled) close(handle);
}

TEST(LiveAddress, HostAndPort) {
  EXPECT_EQ(ParseLiveAddress("--live-address", "0.0.0.0:8000").port, 8000);
  EXPECT_EQ(ParseLiveAddress("--live-address", "0.0.0.0:8000").host, "0.0.0.0");
  EXPECT_EQ(ParseLiveAddress("--live-address", ":80").host, "127.0.0.1");
  EXPECT_EQ(ParseLiveAddress("--live-address", "localhost").port, 0);
  EXPECT_THROW(ParseLiveAddress("--live-address", "host:port"), InputError);
}

}  // namespace
}  // namespace turnscale
