// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map_archive.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_model.h"

namespace turnscale {
namespace {

// An empty vector may have no storage, and the C functions take no null pointer.
template <typename T>
bool WriteAll(const std::vector<T>& values, std::FILE* file) {
  return values.empty() || std::fwrite(values.data(), sizeof(T), values.size(), file) == values.size();
}

template <typename T>
bool ReadAll(std::vector<T>& values, std::FILE* file) {
  return values.empty() || std::fread(values.data(), sizeof(T), values.size(), file) == values.size();
}

// Without a name, so that it goes with the process. std::tmpfile ignores TMPDIR, and /tmp may be in memory. Null where
// none can be made.
std::FILE* TemporaryFile() {
  std::error_code error;
  std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) folder = "/tmp";
  std::string name = (folder / "turnscale-map-XXXXXX").string();
  const int descriptor = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) return nullptr;
  unlink(name.c_str());
  std::FILE* file = fdopen(descriptor, "w+b");
  if (file == nullptr) close(descriptor);
  return file;
}

// Takes the observations of keyframes before `last` from the landmarks, and drops landmarks without observations.
std::vector<int> DropObservationsBefore(int last, Map& map) {
  std::vector<int> new_index(map.landmarks.size(), -1);
  int kept = 0;
  for (size_t i = 0; i < map.landmarks.size(); ++i) {
    Landmark& landmark = map.landmarks[i];
    if (!landmark.observations.empty() && landmark.observations.front().keyframe < last) {
      std::erase_if(landmark.observations, [&](const LandmarkObservation& seen) { return seen.keyframe < last; });
      landmark.observations.shrink_to_fit();
    }
    if (landmark.observations.empty()) continue;
    new_index[i] = kept;
    if (kept != static_cast<int>(i)) map.landmarks[kept] = std::move(landmark);
    ++kept;
  }
  map.landmarks.resize(kept);
  return new_index;
}

}  // namespace

std::vector<int> MapArchive::BlockEnds() const {
  std::vector<int> ends;
  for (const Block& block : blocks_) ends.push_back(block.end);
  return ends;
}

std::vector<int> MapArchive::Retire(int last, Map& map) {
  const int first = end();
  while (end() < last) {
    int piece_end = end() + 1;
    while (piece_end < last && !map.keyframes[piece_end].after_gap) ++piece_end;
    // Blocks of equal size, none of them of a few keyframes only.
    const int blocks = (piece_end - end() + kMostKeyframes - 1) / kMostKeyframes;
    AddBlock(end() + (piece_end - end()) / blocks, map);
  }
  // An assignment of {} would keep the memory.
  for (int k = first; k < last; ++k) std::vector<KeyframeObservation>().swap(map.keyframes[k].observations);
  std::vector<int> new_index = DropObservationsBefore(last, map);
  for (size_t k = last; k < map.keyframes.size(); ++k) {
    std::vector<KeyframeObservation>& observations = map.keyframes[k].observations;
    for (KeyframeObservation& seen : observations) seen.landmark = new_index[seen.landmark];
    std::erase_if(observations, [](const KeyframeObservation& seen) { return seen.landmark < 0; });
  }
  return new_index;
}

void MapArchive::AddBlock(int last, Map& map) {
  Block block;
  block.first = end();
  block.end = last;
  block.radial_correction = map.camera.radial_correction;
  Contents contents;
  for (int k = block.first; k < last; ++k) {
    const size_t before = contents.observations.size();
    for (const KeyframeObservation& seen : map.keyframes[k].observations) {
      Landmark& landmark = map.landmarks[seen.landmark];
      if (!landmark.valid) continue;
      if (landmark.archived_as < 0) landmark.archived_as = numbers_++;
      contents.observations.push_back(
          {landmark.archived_as, static_cast<float>(seen.pixel.x()), static_cast<float>(seen.pixel.y())});
    }
    contents.observation_counts.push_back(static_cast<int>(contents.observations.size() - before));
  }
  for (const int index : LandmarksSeen(map, block.first, last - 1)) {
    contents.numbers.push_back(map.landmarks[index].archived_as);
    const Eigen::Vector3d& x = map.landmarks[index].position;
    contents.positions.insert(contents.positions.end(), {x.x(), x.y(), x.z()});
  }
  Write(std::move(contents), block);
  blocks_.push_back(std::move(block));
}

ArchivedPart MapArchive::Load(int first, int last, const Map& map) const {
  ArchivedPart part;
  part.first = first;
  part.map.camera = map.camera;
  std::vector<std::pair<int, Eigen::Vector3d>> landmarks;
  std::vector<std::pair<Contents, double>> loaded;
  for (const Block& block : blocks_) {
    if (block.end <= first || block.first >= last) continue;
    Ensure(block.first >= first && block.end <= last, "a part of the archive consists of whole blocks");
    loaded.emplace_back(Read(block), block.radial_correction);
    const Contents& contents = loaded.back().first;
    for (size_t i = 0; i < contents.numbers.size(); ++i)
      landmarks.emplace_back(contents.numbers[i], Eigen::Vector3d(&contents.positions[3 * i]));
  }
  // Of one number's positions the latest is the last.
  const auto number_of = [](const auto& landmark) { return landmark.first; };
  std::ranges::stable_sort(landmarks, {}, number_of);
  for (const auto& [number, position] : landmarks) {
    if (part.numbers.empty() || part.numbers.back() != number) {
      part.numbers.push_back(number);
      part.map.landmarks.push_back({Eigen::Vector3d::Zero(), true, {}, number});
    }
    part.map.landmarks.back().position = position;
  }
  for (int k = first; k < last; ++k) {
    part.map.keyframes.push_back(map.keyframes[k]);
    part.map.keyframes.back().observations.clear();
  }
  int keyframe = 0;
  const double wanted = map.camera.radial_correction;
  for (const auto& [contents, radial_correction] : loaded) {
    auto seen = contents.observations.begin();
    for (const int count : contents.observation_counts) {
      for (const auto end = seen + count; seen != end; ++seen) {
        Eigen::Vector2d pixel(seen->x, seen->y);
        if (radial_correction != wanted)
          pixel = ChangeRadialCorrection(map.camera.pinhole, radial_correction, wanted, pixel);
        const auto found = std::ranges::lower_bound(part.numbers, seen->number);
        AddObservation(part.map, keyframe, static_cast<int>(found - part.numbers.begin()), pixel);
      }
      ++keyframe;
    }
  }
  return part;
}

void MapArchive::Store(const ArchivedPart& part) {
  const int last = part.first + CountKeyframes(part.map);
  for (Block& block : blocks_) {
    if (block.first < part.first || block.end > last) continue;
    Contents contents = Read(block);
    for (size_t i = 0; i < contents.numbers.size(); ++i) {
      const auto found = std::ranges::lower_bound(part.numbers, contents.numbers[i]);
      const Eigen::Vector3d& x = part.map.landmarks[found - part.numbers.begin()].position;
      std::copy_n(x.data(), 3, &contents.positions[3 * i]);
    }
    Write(std::move(contents), block);
  }
}

bool MapArchive::WriteToFile(const Contents& contents, long offset) {
  if (!file_ && !file_failed_) file_.reset(TemporaryFile());
  file_failed_ = file_failed_ || !file_ || std::fseek(file_.get(), offset, SEEK_SET) != 0 ||
                 !WriteAll(contents.observation_counts, file_.get()) || !WriteAll(contents.observations, file_.get()) ||
                 !WriteAll(contents.numbers, file_.get()) || !WriteAll(contents.positions, file_.get()) ||
                 std::fflush(file_.get()) != 0;
  return !file_failed_;
}

void MapArchive::Write(Contents contents, Block& block) {
  block.observations = contents.observations.size();
  block.landmarks = contents.numbers.size();
  const bool is_new = block.offset < 0;
  if (WriteToFile(contents, is_new ? file_end_ : block.offset)) {
    if (!is_new) return;
    block.offset = file_end_;
    file_end_ = std::ftell(file_.get());
  } else {
    block.offset = -1;
    block.kept = std::move(contents);
  }
}

MapArchive::Contents MapArchive::Read(const Block& block) const {
  if (block.offset < 0) return block.kept;
  Contents contents;
  contents.observation_counts.resize(block.end - block.first);
  contents.observations.resize(block.observations);
  contents.numbers.resize(block.landmarks);
  contents.positions.resize(3 * block.landmarks);
  if (std::fseek(file_.get(), block.offset, SEEK_SET) != 0 || !ReadAll(contents.observation_counts, file_.get()) ||
      !ReadAll(contents.observations, file_.get()) || !ReadAll(contents.numbers, file_.get()) ||
      !ReadAll(contents.positions, file_.get()))
    throw OutputError("the temporary file of the map cannot be read back");
  return contents;
}

}  // namespace turnscale
