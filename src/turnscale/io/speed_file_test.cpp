// SPDX-License-Identifier: MIT
#include "turnscale/io/speed_file.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

SpeedLog SpeedsFrom(const std::string& text) {
  const std::string path = ScratchPath("speed.csv");
  std::ofstream(path) << text;
  struct Remover {
    std::string path;
    ~Remover() { std::filesystem::remove(path); }
  } remover{path};
  return ReadSpeedFile(path);
}

TEST(SpeedFile, GivesDistances) {
  const SpeedLog log = SpeedsFrom("time_s,speed_mps\n0,0\n1,2\n# a comment\n3 2\n");
  EXPECT_DOUBLE_EQ(log.Distance(0, 1).value(), 1);
  EXPECT_DOUBLE_EQ(log.Distance(0.5, 2).value(), 0.75 + 2);
  EXPECT_DOUBLE_EQ(log.Distance(0, 3).value(), 5);
  EXPECT_FALSE(log.Distance(2, 3.1));
  EXPECT_FALSE(log.Distance(-0.1, 1));
}

TEST(SpeedFile, TimesMayBeMicroseconds) {
  EXPECT_NEAR(SpeedsFrom("1403636580000000,1\n1403636580100000,3\n").Distance(1403636580, 1403636580.1).value(), 0.2,
              1e-6);
}

TEST(SpeedFile, ConvertsTheUnitOfTheTimesThatTheHeadingNames) {
  for (const char* heading : {"time_ms,speed", "Time [ms],Speed", "t_ms speed", "# timestamp_ms, speed"})
    EXPECT_NEAR(SpeedsFrom(std::string(heading) + "\n0,1\n100,3\n").times.back(), 0.1, 1e-12) << heading;
  EXPECT_NEAR(SpeedsFrom("time_us,speed\n0,1\n100000,3\n").times.back(), 0.1, 1e-12);
  EXPECT_EQ(SpeedsFrom("timestamp_s,speed\n0,1\n1,3\n").times.back(), 1);
  std::string log = "time,speed\n";
  for (int i = 0; i < 10; ++i) log += std::to_string(33 * i) + ",1\n";
  try {
    SpeedsFrom(log);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("33 s apart or more; are they milliseconds"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(SpeedsFrom("time,speed\n0,5\n1000,5\n").Distance(0, 1000), 5000) << "a constant speed";
}

TEST(SpeedFile, TimesWithAUnitMayBeFarApart) {
  const auto log = [](const std::string& heading, int interval) {
    std::string text = heading + "\n";
    for (int i = 0; i < 10; ++i) text += std::to_string(interval * i) + ",1\n";
    return SpeedsFrom(text);
  };
  for (const char* heading : {"time_s,speed", "Time [s],Speed", "t_s,v", "# time_s, speed", "seconds,speed"})
    EXPECT_EQ(log(heading, 15).times.back(), 135) << heading;
  EXPECT_NEAR(log("time_ms,speed", 15000).times.back(), 135, 1e-9);
  EXPECT_EQ(log("time_s,speed", 2000).times.back(), 18000) << "not taken for milliseconds";
  for (const char* heading : {"time,speed", "times,speed", "timestamps,speed", "ts,speed"})
    EXPECT_THROW(log(heading, 15), InputError) << heading;
}

TEST(SpeedFile, KnowsTheUnitsOfTimesByAllTheirNames) {
  const auto last = [](const std::string& heading) { return SpeedsFrom(heading + "\n0,1\n1000,3\n").times.back(); };
  for (const char* heading : {"time [ms],speed", "time_millis,speed", "timestamp (milliseconds),speed", "timeMs,speed",
                              "tms,v", "Zeit [ms],speed", "millisecond,speed", "elapsed time ms,speed"})
    EXPECT_NEAR(last(heading), 1, 1e-12) << heading;
  for (const char* heading : {"time [\xC2\xB5s],speed", "time (\xCE\xBCs),speed", "time_microseconds,speed", "t_us,v"})
    EXPECT_NEAR(last(heading), 1e-3, 1e-15) << heading;
  EXPECT_NEAR(last("time_nanoseconds,speed"), 1e-6, 1e-18);
  for (const char* heading : {"time_second,speed", "time_secs,speed", "time since start [s],speed", "stamp_s,speed"})
    EXPECT_EQ(last(heading), 1000) << heading;
  for (const char* heading : {"time,speed", "timestamp,speed", "Time Stamp,speed", "t,v", "stamp,speed",
                              "gps_time,speed", "timestamps,speed", "Zeit,speed", "track,speed"})
    EXPECT_EQ(last(heading), 1000) << heading;
}

TEST(SpeedFile, KnowsWhetherTheUnitOfTheSpeedsIsNamed) {
  EXPECT_TRUE(SpeedsFrom("time,speed_mps\n0,1\n1,3\n").names_unit);
  EXPECT_FALSE(SpeedsFrom("time,speed\n0,1\n1,3\n").names_unit);
  EXPECT_FALSE(SpeedsFrom("0,1\n1,3\n").names_unit);
}

TEST(SpeedFile, TakesTheColumnsThatAreNamed) {
  const SpeedLog log = SpeedsFrom("frame,t_s,speed_mps,yaw\n0,10,2,0\n1,11,4,0\n");
  EXPECT_DOUBLE_EQ(log.Distance(10, 11).value(), 3);
  for (const char* text : {"frame,t_s,rate\n0,10,2\n1,11,4\n", "0,10,2\n1,11,4\n"}) {
    try {
      SpeedsFrom(text);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("has 3 columns"), std::string::npos) << error.what();
    }
  }
}

TEST(SpeedFile, ConvertsTheUnitThatTheHeadingNames) {
  const auto metres = [](const std::string& heading) {
    return SpeedsFrom(heading + "\n0,36\n1,36\n").Distance(0, 1).value();
  };
  for (const char* heading : {"time,speed_kmh", "t,v_kmh", "time (s),speed (km/h)", "Time [s], Speed [km/h]",
                              "time speed [km/h]", "seconds,wheel speed km/h", "time,speed_kph", "# time, speed_kmh",
                              "# t v_kmh", "time,velocity_kmh", "Zeit,Geschwindigkeit km/h"})
    EXPECT_NEAR(metres(heading), 10, 1e-9) << heading;
  EXPECT_NEAR(metres("time,speed_mph"), 36 * 1.609344 / 3.6, 1e-3);
  EXPECT_NEAR(metres("time,speed_kts"), 36 * 1.852 / 3.6, 1e-3);
  for (const char* heading : {"time,speed", "time,speed_mps", "time,speed (m/s)", "t_s,v_ms",
                              "# time and speed of the car", "# recorded at t, without wheel slip", "time,value"})
    EXPECT_EQ(metres(heading), 36) << heading;
  EXPECT_NEAR(SpeedsFrom("frame,t_s,yaw,speed_kmh\n0,10,0,7.2\n1,11,0,14.4\n").Distance(10, 11).value(), 3, 1e-9);
}

TEST(SpeedFile, RefusesAUnitThatItDoesNotKnow) {
  for (const char* heading : {"time,speed_fps", "time,speed_kms"}) {
    try {
      SpeedsFrom(std::string(heading) + "\n0,10\n1,11\n");
      FAIL() << heading;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(":1: the unit of 'speed_"), std::string::npos) << error.what();
    }
  }
}

TEST(SpeedFile, RefusesAUnitOfTheTimeThatItDoesNotKnow) {
  for (const char* heading : {"time_min,speed", "time [ticks],speed", "t_hours,v", "timestamp_ps speed",
                              "stamp (h),speed", "Zeit [min],speed", "# time_min, speed"}) {
    try {
      SpeedsFrom(std::string(heading) + "\n0,10\n1,11\n");
      FAIL() << heading;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(":1: the unit of '"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("time_ms"), std::string::npos) << error.what();
    }
  }
}

TEST(SpeedFile, RefusesSpeedsThatAreNoMetresPerSecond) {
  for (const char* text : {"0,50\n1,85\n", "time,speed\n1,85\n2,50\n"}) {
    try {
      SpeedsFrom(text);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(":2: speed 85 is too fast for m/s; name the unit"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_EQ(SpeedsFrom("time,speed_mps\n0,85\n1,85\n").Distance(0, 1), 85);
}

TEST(SpeedFile, NamesTheLineItCannotRead) {
  for (const char* text : {"0,1\n1,x\n", "0,1\n1,nan\n", "0,1\n0,2\n", "0,1\n1,-2\n", "0,1\n2\n"}) {
    try {
      SpeedsFrom(text);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(":2: "), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(SpeedsFrom("0,1\n"), InputError);
}

}  // namespace
}  // namespace turnscale
