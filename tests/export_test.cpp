// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "turnscale/base/csv_table.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/test_files.h"
#include "turnscale/export/test_results.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kExportedFrames = 201;

// Standard output of a shell command.
std::string OutputOf(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen((command + " 2>/dev/null").c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> piece{};
  while (const size_t count = fread(piece.data(), 1, piece.size(), pipe.get())) text.append(piece.data(), count);
  return text;
}

bool Has(const std::string& program) { return !OutputOf("command -v " + program).empty(); }

// A drive at 10 m/s along a circle of 100 m radius to the right, and its exports.
class ExportTest : public ::testing::Test {
 protected:
  ExportTest() : folder_(ScratchPath("export")) {
    const ResultFolder results = TestResults(kExportedFrames, 100);
    RunSummary summary;
    summary.scale.state = ScaleState::kHeld;
    summary.scale.path_sigma = 0.05;
    RunWriter writer({folder_ / "out"});
    writer.WriteTrajectory(results.frames, Eigen::Quaterniond::Identity(), ScaleState::kHeld);
    writer.WriteTurns({});
    writer.WriteSpeeds(results.speeds);
    writer.WriteText("summary.json", SummaryJson(summary));
  }
  ~ExportTest() override { fs::remove_all(folder_); }

  // A writer of results would first delete the existing ones.
  void WriteSummary(const RunSummary& summary) const {
    std::ofstream(folder_ / "out" / "summary.json") << SummaryJson(summary);
  }
  CommandResult Export(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"export", (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCommand(arguments, folder_);
  }
  CommandResult ExportAll() const {
    return Export({"--gpx", "--kml", "--geojson", "--gltf", "--origin", "49.0112,8.4225", "--heading", "90",
                   "--start-time", "2026-03-22T07:14:05+01:00"});
  }
  std::string Path(const std::string& extension) const { return (folder_ / "out" / "path").string() + extension; }

  // fixes.csv: without noise, from the exported path itself, stretched about its first point.
  void WriteFixes(double stretch) const {
    const auto json = nlohmann::json::parse(TextOf(Path(".geojson")));
    const auto& line = json["features"][0];
    const auto& points = line["geometry"]["coordinates"];
    std::ofstream fixes(folder_ / "fixes.csv");
    fixes << "time,latitude,longitude,sigma\n";
    for (size_t i = 0; i < 21; ++i) {
      const auto stretched = [&](int axis) {
        const double first = points[0][axis].get<double>();
        return NumberText(first + stretch * (points[i][axis].get<double>() - first));
      };
      fixes << line["properties"]["coordinateProperties"]["times"][i].get<std::string>() << ',' << stretched(1) << ','
            << stretched(0) << ",1\n";
    }
  }

  fs::path folder_;
};

// After a quarter of the circle the car is 100 m east and 100 m south of its start.
void ExpectCircle(const std::vector<std::pair<double, double>>& places) {
  ASSERT_EQ(places.size(), 21u);
  EXPECT_NEAR(places[0].first, 49.0112, 2e-6);
  EXPECT_NEAR(places[0].second, 8.4225, 2e-6);
  constexpr double kMetresPerDegree = 111210;  // north, at 49 degrees
  const double angle = 16 / 10.0;
  EXPECT_NEAR((places[16].first - 49.0112) * kMetresPerDegree, -100 * (1 - std::cos(angle)), 0.3);
  EXPECT_NEAR((places[16].second - 8.4225) * 73169, 100 * std::sin(angle), 0.3);
}

// A point per second, UTC.
void ExpectTime(const std::string& text, size_t point) {
  const std::string time = fmt::format("06:14:{:02}", 5 + point);
  EXPECT_NE(text.find(time), std::string::npos) << text << " at point " << point;
}

void ExpectGpsbabelReads(const std::string& format, const std::string& file) {
  if (!Has("gpsbabel")) GTEST_SKIP() << "no gpsbabel (Debian package: gpsbabel)";
  std::istringstream text(OutputOf("gpsbabel -t -i " + format + " -f '" + file + "' -o unicsv,utc=0,prec=8 -F -"));
  CsvTable table(text, file);
  std::vector<std::pair<double, double>> places;
  while (table.Next()) {
    places.emplace_back(table.Value<double>(table.Column("Latitude")), table.Value<double>(table.Column("Longitude")));
    EXPECT_EQ(table.Text(table.Column("Date")), "2026/03/22");
    ExpectTime(table.Text(table.Column("Time")), places.size() - 1);
  }
  ExpectCircle(places);
}

TEST_F(ExportTest, OutNamesTheFilesOrTheirFolder) {
  const fs::path maps = folder_ / "maps";
  fs::create_directories(maps);
  const auto exports = [&](const std::string& out, const fs::path& file) {
    const CommandResult result = Export({"--gpx", "--origin", "49.0112,8.4225", "--heading", "90", "--out", out});
    EXPECT_TRUE(result.out.ends_with("wrote    " + file.string() + "\n")) << result.out;
    EXPECT_TRUE(fs::remove(file)) << out;
  };
  exports(maps.string(), maps / "path.gpx");
  exports(maps.string() + "/", maps / "path.gpx");
  exports((maps / "track").string(), maps / "track.gpx");
  exports((maps / "track.gpx").string(), maps / "track.gpx");
  exports((maps / "2026.03").string(), maps / "2026.03.gpx");
  EXPECT_TRUE(fs::is_empty(maps));
}

TEST_F(ExportTest, GpxWithoutTimesIsNamed) {
  const auto out = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--origin", "49.0112,8.4225", "--heading", "90"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Export(arguments).out;
  };
  EXPECT_EQ(out({"--gpx"}),
            "times    GPX has none, as the date and time of the drive are unknown; give --start-time\nwrote    " +
                Path(".gpx") + "\n");
  EXPECT_EQ(TextOf(Path(".gpx")).find("<time>"), std::string::npos);
  EXPECT_EQ(out({"--gpx", "--start-time", "2026-03-22T07:14:05+01:00"}), "wrote    " + Path(".gpx") + "\n");
  EXPECT_EQ(out({"--kml"}), "wrote    " + Path(".kml") + "\n");
  RunSummary summary;
  summary.scale.state = ScaleState::kHeld;
  summary.scale.path_sigma = 0.05;
  summary.drive.given.recorded_from = "2023-05-01T12:00:00";
  WriteSummary(summary);
  EXPECT_EQ(out({"--gpx"}),
            "times    GPX has none, as the time zone of the recorder is unknown: by the names of the clips, the drive "
            "begins at 2023-05-01T12:00:00; give --start-time 2023-05-01T12:00:00 with the offset from UTC, such as "
            "2023-05-01T12:00:00+01:00\nwrote    " +
                Path(".gpx") + "\n");
}

TEST_F(ExportTest, ThePathIsNamedAfterTheFolderAlone) {
  for (const char* way : {"out", "out/", "out/."}) {
    const CommandResult result = RunCommand({"export", (folder_ / way).string(), "--gpx", "--geojson", "--kml",
                                             "--origin", "49.0112,8.4225", "--heading", "90"},
                                            folder_);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(TextOf(Path(".gpx")).find("<name>out</name>"), std::string::npos) << way;
    EXPECT_NE(TextOf(Path(".kml")).find("<name>out</name>"), std::string::npos) << way;
    EXPECT_EQ(TextOf(Path(".geojson")).find(folder_.string()), std::string::npos) << way;
  }
}

TEST_F(ExportTest, NumbersAreFinite) {
  for (const char* option : {"--aspect", "--fov"})
    ExpectComplaint(Export({"--gltf", option, "nan"}), 2, {option, "nan: give a number"});
  ExpectComplaint(Export({"--gpx", "--interval", "nan"}), 2, {"--interval", "nan: give a number"});
  EXPECT_FALSE(fs::exists(Path(".gltf")));
  EXPECT_FALSE(fs::exists(Path(".gpx")));
}

TEST_F(ExportTest, GpsbabelReadsGpx) {
  ASSERT_EQ(ExportAll().exit_code, 0);
  ExpectGpsbabelReads("gpx", Path(".gpx"));
}

TEST_F(ExportTest, GpsbabelReadsKml) {
  ASSERT_EQ(ExportAll().exit_code, 0);
  ExpectGpsbabelReads("kml", Path(".kml"));
}

std::pair<double, double> PlaceOf(const nlohmann::json& position) {
  return {position[1].get<double>(), position[0].get<double>()};
}

// The features that GDAL reads from a file or one of its layers.
nlohmann::json ReadByGdal(const std::string& file, const std::string& layer = "") {
  const auto json = nlohmann::json::parse(OutputOf(fmt::format("ogr2ogr -f GeoJSON /vsistdout/ '{}' {}", file, layer)),
                                          nullptr, false);
  EXPECT_TRUE(json.is_object() && json.contains("features")) << file;
  return json.is_object() ? json.value("features", nlohmann::json::array()) : nlohmann::json::array();
}

TEST_F(ExportTest, GdalReadsLines) {
  if (!Has("ogr2ogr")) GTEST_SKIP() << "no ogr2ogr (Debian package: gdal-bin)";
  ASSERT_EQ(ExportAll().exit_code, 0);
  for (const std::string& file : {Path(".geojson"), Path(".kml")}) {
    nlohmann::json line;
    for (const auto& feature : ReadByGdal(file))
      if (feature["geometry"]["type"] == "LineString") line = feature;
    ASSERT_TRUE(line.is_object()) << file;
    std::vector<std::pair<double, double>> places;
    for (const auto& position : line["geometry"]["coordinates"]) places.push_back(PlaceOf(position));
    ExpectCircle(places);
    if (line["properties"].contains("begin")) {
      // Of a track in KML it reads the first and the last time.
      ExpectTime(line["properties"]["begin"].get<std::string>(), 0);
      ExpectTime(line["properties"]["end"].get<std::string>(), 20);
      continue;
    }
    const auto& times = line["properties"]["coordinateProperties"]["times"];
    ASSERT_EQ(times.size(), 21u) << file;
    for (size_t i = 0; i < times.size(); ++i) ExpectTime(times[i].get<std::string>(), i);
  }
}

TEST_F(ExportTest, GdalReadsGpxPoints) {
  if (!Has("ogr2ogr")) GTEST_SKIP() << "no ogr2ogr (Debian package: gdal-bin)";
  ASSERT_EQ(ExportAll().exit_code, 0);
  std::vector<std::pair<double, double>> places;
  for (const auto& feature : ReadByGdal(Path(".gpx"), "track_points")) {
    ExpectTime(feature["properties"]["time"].get<std::string>(), places.size());
    places.push_back(PlaceOf(feature["geometry"]["coordinates"]));
  }
  ExpectCircle(places);
}

TEST_F(ExportTest, FixesPlaceThePath) {
  ASSERT_EQ(ExportAll().exit_code, 0);
  WriteFixes(1);
  const std::string before = TextOf(Path(".gpx"));
  const CommandResult result =
      Export({"--gpx", "--fixes", (folder_ / "fixes.csv").string(), "--start-time", "2026-03-22T06:14:05Z"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("heading  90.0"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("fixes    21 in the drive, 0 of them outliers"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("scale    by the fixes, the path is 0.0 +-"), std::string::npos) << result.out;
  EXPECT_NE(TextOf(Path(".gpx")), "");
  EXPECT_EQ(TextOf(Path(".gpx")).substr(0, 400), before.substr(0, 400));
  EXPECT_EQ(result.err, "");
}

TEST_F(ExportTest, SaysWhatIsMissing) {
  ExpectComplaint(Export({}), 2, {"nothing to write; give --gpx"});
  ExpectComplaint(Export({"--gpx"}), 2, {"the place on Earth is needed; give --origin"});
  ExpectComplaint(Export({"--gltf", "--origin", "49,8"}), 2, {"--origin: needs --gpx, --kml or --geojson"});
  ExpectComplaint(Export({"--gltf", "--interval", "2"}), 2, {"--interval: needs --gpx, --kml or --geojson"});
  ExpectComplaint(Export({"--gpx", "--fov", "70"}), 2, {"--fov: needs --gltf"});
  for (const char* heading : {"1000", "-361", "nan"})
    ExpectComplaint(Export({"--gpx", "--origin", "49,8", "--heading", heading}), 2,
                    {std::string("--heading ") + heading + ": give degrees clockwise from north, from -360 to 360"});
  ExpectComplaint(Export({"--gpx", "--origin", "49,8"}), 2,
                  {"--origin 49,8: needs the direction of the car there", "give --heading DEGREES"});
  ExpectComplaint(Export({"--gpx", "--origin", "49", "--heading", "1"}), 2, {"--origin 49: give LATITUDE,LONGITUDE"});
  ExpectComplaint(Export({"--gpx", "--origin", "151.2,-33.9", "--heading", "1"}), 2,
                  {"--origin 151.2,-33.9: a latitude of 151.2 is beyond 90 degrees"});
  ExpectComplaint(Export({"--gpx", "--origin", "49,8", "--heading", "1", "--start-time", "noon"}), 2,
                  {"--start-time noon: give date, time and offset"});
  // Results of a version that wrote no speeds are in metres all the same.
  fs::remove(folder_ / "out" / "speed.csv");
  for (const char* origin : {"49,8,1,2", "49,x", "90,8", "49,181", "49,8,inf", "nan,8", "49,,8"})
    ExpectComplaint(Export({"--gpx", "--origin", origin, "--heading", "1"}), 2, {"give LATITUDE,LONGITUDE"});
  EXPECT_EQ(Export({"--gpx", "--origin", "49,8", "--heading", "1"}).exit_code, 0);
  EXPECT_EQ(Export({"--gpx", "--origin", "49, 8, 120", "--heading", "1"}).exit_code, 0);
  WriteSummary({});
  ExpectComplaint(Export({"--gpx", "--origin", "49,8", "--heading", "1"}), 2, {"the path is not in metres"});
  ExpectComplaint(RunCommand({"export", folder_.string(), "--gpx"}, folder_), 2, {"summary.json: no such file"});
  ExpectComplaint(RunCommand({"view", folder_.string()}, folder_), 2, {"holds no results"});
  ExpectComplaint(RunCommand({"view", (folder_ / "nowhere").string()}, folder_), 2,
                  {"nowhere: no such file or folder"});
}

TEST_F(ExportTest, ViewKeepsTheTruthOfThePage) {
  const std::string out = (folder_ / "out").string();
  const std::string truth = out + "/trajectory.tum";
  ASSERT_EQ(RunCommand({"view", out, "--truth", truth}, folder_).exit_code, 0);
  const std::string page = TextOf(folder_ / "out" / "report.html");
  EXPECT_NE(page.find("\"Path length error\",\"value\":\"+0.00 %\""), std::string::npos);
  ASSERT_EQ(RunCommand({"view", out}, folder_).exit_code, 0);
  EXPECT_EQ(TextOf(folder_ / "out" / "report.html"), page);
}

TEST_F(ExportTest, FixesOfAnotherLengthAreReported) {
  ASSERT_EQ(ExportAll().exit_code, 0);
  WriteFixes(1.5);
  const CommandResult result =
      Export({"--gpx", "--fixes", (folder_ / "fixes.csv").string(), "--start-time", "2026-03-22T06:14:05Z"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("fixes.csv: the path is 33.3 % too short by the fixes"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("the path is 33.3 +-"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" % too short (it is not changed)"), std::string::npos) << result.out;
}

TEST_F(ExportTest, FixesThatDoNotFitAreReported) {
  std::ofstream fixes(folder_ / "fixes.csv");
  fixes << "time,latitude,longitude,sigma\n";
  for (int i = 0; i <= 20; ++i) fixes << 1774160045 + i << ",49.00" << i % 3 << ",8.0" << 10 + i << ",1\n";
  fixes.close();
  const std::vector<std::string> arguments = {"--gpx", "--fixes", (folder_ / "fixes.csv").string()};
  ExpectComplaint(Export(arguments), 2, {"fixes.csv:2: its time is in seconds since 1970", "give --start-time"});
  std::vector<std::string> with_start = arguments;
  with_start.insert(with_start.end(), {"--start-time", "2026-03-22T07:14:05+01:00"});
  const CommandResult result = Export(with_start);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("fixes    21 in the drive"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("fixes.csv: they do not fit the path (RMS "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("of 21 outliers): check --start-time, the order of latitude and longitude"),
            std::string::npos)
      << result.err;
}

TEST_F(ExportTest, HeightsOfFixesAreThoseOfThePath) {
  // Above the sea. Three rough heights close to each other hardly tilt the path.
  std::ofstream fixes(folder_ / "fixes.csv");
  fixes << "time,latitude,longitude,height\n0,49,8,112\n10,49.0004,8.0010,114\n20,49.0004,8.0020,113\n";
  fixes.close();
  const CommandResult result = Export({"--gpx", "--kml", "--geojson", "--fixes", (folder_ / "fixes.csv").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(TextOf(Path(".gpx")).find("<ele>113."), std::string::npos);
  EXPECT_NE(TextOf(Path(".kml")).find(",113."), std::string::npos);
  EXPECT_EQ(TextOf(Path(".kml")).find("absolute"), std::string::npos) << "a car is on the ground";
  const auto json = nlohmann::json::parse(TextOf(Path(".geojson")));
  EXPECT_NEAR(json["features"][0]["properties"]["coordinateProperties"]["height_m"][20].get<double>(), 113, 0.1);
}

TEST_F(ExportTest, TimesSince1970NeedNoStartTime) {
  ResultFolder results = TestResults(kExportedFrames, 100);
  for (FrameResult& frame : results.frames) frame.time += 1774160045;
  RunWriter writer({folder_ / "out"});
  writer.WriteTrajectory(results.frames, Eigen::Quaterniond::Identity(), ScaleState::kHeld);
  writer.WriteTurns({});
  RunSummary summary;
  summary.scale.state = ScaleState::kHeld;
  WriteSummary(summary);
  const std::vector<std::string> place = {"--gpx", "--origin", "49,8", "--heading", "1"};
  ASSERT_EQ(Export(place).exit_code, 0);
  EXPECT_NE(TextOf(Path(".gpx")).find("<time>2026-03-22T06:14:05.000Z</time>"), std::string::npos);
  std::vector<std::string> twice = place;
  twice.insert(twice.end(), {"--start-time", "2026-03-22T06:14:05Z"});
  ExpectComplaint(Export(twice), 2, {"--start-time 2026-03-22T06:14:05Z", "are seconds since 1970 already"});
}

TEST_F(ExportTest, TheCameraIsThatOfTheRun) {
  RunSummary summary;
  summary.scale.state = ScaleState::kHeld;
  summary.drive.camera.pinhole = Pinhole{500, 500, 320, 240};
  summary.drive.images.width = 640;
  summary.drive.images.height = 480;
  WriteSummary(summary);
  const auto camera = [&](const std::vector<std::string>& arguments) {
    const CommandResult result = Export(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(TextOf(Path(".gltf")))["cameras"][0]["perspective"];
  };
  EXPECT_NEAR(camera({"--gltf"})["yfov"].get<double>(), 2 * std::atan(240 / 500.0), 1e-9);
  EXPECT_NEAR(camera({"--gltf"})["aspectRatio"].get<double>(), 4 / 3.0, 1e-9);
  EXPECT_NEAR(camera({"--gltf", "--fov", "90", "--aspect", "1"})["yfov"].get<double>(), M_PI / 2, 1e-9);
  // No pinhole camera resembles a fisheye.
  summary.drive.camera.lens_model = LensModel::kEquidistant;
  WriteSummary(summary);
  EXPECT_NE(Export({"--gltf"}).out.find("70 deg wide is assumed"), std::string::npos);
  summary.drive.given.pose_frame = "vehicle";
  WriteSummary(summary);
  ExpectComplaint(Export({"--gltf", "--gpx", "--origin", "49,8", "--heading", "0"}), 2,
                  {"are those of the rear axle", "without --frame vehicle"});
  EXPECT_FALSE(fs::exists(folder_ / "out" / "path.gpx")) << "all or nothing";
}

TEST_F(ExportTest, AnUncertainScaleIsNamed) {
  EXPECT_EQ(ExportAll().err, "");
  RunSummary summary;
  summary.scale.state = ScaleState::kHeld;
  summary.scale.path_sigma = summary.scale.sigma = 0.3;
  WriteSummary(summary);
  const CommandResult uncertain = ExportAll();
  EXPECT_EQ(uncertain.exit_code, 0);
  EXPECT_NE(uncertain.err.find("out: the scale is uncertain: lengths and speeds are rough"), std::string::npos);
  WriteSummary({});
  EXPECT_NE(Export({"--gltf"}).err.find("out: the trajectory is up to scale"), std::string::npos);
  // Results of a version that did not say.
  auto older = nlohmann::json::parse(SummaryJson(summary));
  older["scale"].erase("known");
  std::ofstream(folder_ / "out" / "summary.json") << older;
  EXPECT_EQ(ExportAll().err, "");
}

TEST_F(ExportTest, AFolderThatCannotBeWrittenToEndsWithCode2) {
  const fs::path out = folder_ / "out";
  for (const char* name : {"report.html", "path.gltf"}) fs::create_directories(out / name);
  ExpectComplaint(RunCommand({"view", out.string()}, folder_), 2, {"report.html: cannot be written"});
  ExpectComplaint(Export({"--gltf"}), 2, {"path.gltf: cannot be written"});
}

TEST_F(ExportTest, ViewMakesThePageAgain) {
  const CommandResult result = RunCommand({"view", (folder_ / "out").string()}, folder_);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string page = TextOf(folder_ / "out" / "report.html");
  EXPECT_NE(page.find("\"unit\":\"m\""), std::string::npos);
  // A page alone, without the files that it was made from.
  fs::copy(folder_ / "out" / "report.html", folder_ / "alone.html");
  EXPECT_EQ(RunCommand({"view", (folder_ / "alone.html").string()}, folder_).exit_code, 0);
  EXPECT_NE(TextOf(folder_ / "alone.html").find("\"unit\":\"m\""), std::string::npos);
  ExpectComplaint(RunCommand({"view", (folder_ / "alone.html").string(), "--truth", "poses.txt"}, folder_), 2,
                  {"--truth poses.txt: needs the results of a run beside the page"});
  std::ofstream(folder_ / "other.html") << "<html>";
  ExpectComplaint(RunCommand({"view", (folder_ / "other.html").string()}, folder_), 2,
                  {"other.html: is not a report of turnscale"});
}

}  // namespace
}  // namespace turnscale
