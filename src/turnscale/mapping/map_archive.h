// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <vector>

#include "turnscale/mapping/map.h"

namespace turnscale {

/// Keyframes of the archive as a map of their own.
struct ArchivedPart {
  int first = 0;  ///< keyframe i of `map` is keyframe first + i of the drive
  Map map;
  std::vector<int> numbers;  ///< of each landmark of `map` in the archive, ascending
};

/// Keeps the observations of keyframes that no local adjustment can change any more in a temporary file, so that memory
/// does not grow with the drive. Poses and times of all keyframes stay in the map.
///
/// The file has no name and vanishes with the process. What cannot be written to it (disk full) stays in memory.
class MapArchive {
 public:
  static constexpr int kMostKeyframes = 50;  ///< in a block

  /// Observations of keyframes from here on are in the map.
  int end() const { return blocks_.empty() ? 0 : blocks_.back().end; }

  /// Landmarks that have a number in the archive.
  int landmarks() const { return numbers_; }

  /// Where an archived block of keyframes ends, in the order of time.
  std::vector<int> BlockEnds() const;

  /// Moves the observations of keyframes end()...`last`-1 out of the map, in blocks of kMostKeyframes at most that
  /// contain no gap. Kept are valid landmarks and their observations, pixels in single precision. Landmarks that no
  /// later keyframe sees leave the map; the rest lose their archived observations. Returns the new index of each
  /// landmark of the map, -1 for those that left.
  std::vector<int> Retire(int last, Map& map);

  /// Keyframes `first`...`last`-1, both 0 or one of BlockEnds(), with the poses and the camera of `map`, whose radial
  /// correction their pixels get. Landmarks stand where the latest of these blocks has them. Not for several threads at
  /// once.
  ArchivedPart Load(int first, int last, const Map& map) const;

  /// Overwrites the positions of a part's landmarks.
  void Store(const ArchivedPart& part);

 private:
  struct ObservationRecord {
    int number;
    float x, y;
  };
  struct Contents {
    std::vector<int> observation_counts;  ///< of each keyframe
    std::vector<ObservationRecord> observations;
    std::vector<int> numbers;       ///< of the landmarks
    std::vector<double> positions;  ///< three of each
  };
  struct Block {
    int first = 0;
    int end = 0;
    double radial_correction = 0;  ///< of the pixels
    size_t observations = 0;       ///< how many
    size_t landmarks = 0;          ///< how many
    long offset = -1;              ///< in the file; -1: in `kept`
    Contents kept;
  };
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void AddBlock(int last, Map& map);
  bool WriteToFile(const Contents& contents, long offset);
  void Write(Contents contents, Block& block);
  Contents Read(const Block& block) const;

  std::unique_ptr<std::FILE, CloseFile> file_;
  long file_end_ = 0;
  bool file_failed_ = false;
  std::vector<Block> blocks_;
  int numbers_ = 0;  ///< given to landmarks so far
};

}  // namespace turnscale
