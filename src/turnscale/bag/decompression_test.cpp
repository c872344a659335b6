// SPDX-License-Identifier: MIT
#include "turnscale/bag/decompression.h"

#include <string>

#include <bzlib.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include "turnscale/bag/byte_reader.h"

namespace turnscale {
namespace {

std::vector<uint8_t> Squeezed(const std::string& compression, const std::vector<uint8_t>& plain) {
  std::vector<uint8_t> out(2 * plain.size() + 4096);
  if (compression == "lz4") {
    out.resize(LZ4F_compressFrame(out.data(), out.size(), plain.data(), plain.size(), nullptr));
  } else if (compression == "zstd") {
    out.resize(ZSTD_compress(out.data(), out.size(), plain.data(), plain.size(), 3));
  } else {
    auto size = static_cast<unsigned>(out.size());
    std::vector<uint8_t> in = plain;
    in.reserve(1);
    BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(out.data()), &size, reinterpret_cast<char*>(in.data()),
                             static_cast<unsigned>(in.size()), 1, 0, 0);
    out.resize(size);
  }
  return out;
}

class DecompressionTest : public ::testing::TestWithParam<std::string> {};

TEST_P(DecompressionTest, GivesBackWhatWasCompressed) {
  for (const size_t size : {0u, 1u, 1000u, 65536u, 1000000u}) {
    std::vector<uint8_t> plain(size);
    for (size_t i = 0; i < size; ++i) plain[i] = static_cast<uint8_t>(i * i / 7);
    std::vector<uint8_t> out;
    Decompress(GetParam(), Squeezed(GetParam(), plain), size, out);
    EXPECT_EQ(out, plain) << size;
  }
}

TEST_P(DecompressionTest, RefusesAnotherSizeAndDamage) {
  const std::vector<uint8_t> plain(100000, 7);
  std::vector<uint8_t> squeezed = Squeezed(GetParam(), plain);
  std::vector<uint8_t> out;
  EXPECT_THROW(Decompress(GetParam(), squeezed, plain.size() - 1, out), MalformedData);
  EXPECT_THROW(Decompress(GetParam(), squeezed, plain.size() + 1, out), MalformedData);
  EXPECT_THROW(Decompress(GetParam(), std::span(squeezed).first(squeezed.size() / 2), plain.size(), out),
               MalformedData);
  EXPECT_THROW(Decompress(GetParam(), {}, plain.size(), out), MalformedData);
  squeezed[0] ^= 0xFF;
  EXPECT_THROW(Decompress(GetParam(), squeezed, plain.size(), out), MalformedData);
}

TEST_P(DecompressionTest, MemoryIsThatOfTheDataNotOfTheirClaim) {
  const std::vector<uint8_t> plain(1000, 7);
  std::vector<uint8_t> out;
  EXPECT_THROW(Decompress(GetParam(), Squeezed(GetParam(), plain), size_t{1} << 40, out), MalformedData);
  EXPECT_LT(out.capacity(), 1u << 20);
}

INSTANTIATE_TEST_SUITE_P(All, DecompressionTest, ::testing::Values("lz4", "zstd", "bz2"),
                         [](const auto& tested) { return tested.param; });

TEST(Decompression, OtherCompressions) {
  std::vector<uint8_t> out;
  EXPECT_THROW(Decompress("lzma", {}, 0, out), MalformedData);
}

}  // namespace
}  // namespace turnscale
