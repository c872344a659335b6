// SPDX-License-Identifier: MIT
#include "turnscale/bag/byte_reader.h"

#include <array>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

constexpr std::array<uint8_t, 8> kEightBytes = {1, 2, 3, 4, 'a', 'b', 0xFF, 0xFF};

TEST(ByteReader, NumbersOfEitherOrder) {
  EXPECT_EQ(ByteReader(kEightBytes).Read<uint32_t>(), 0x04030201u);
  EXPECT_EQ(ByteReader(kEightBytes, std::endian::big).Read<uint32_t>(), 0x01020304u);
  EXPECT_EQ(ByteReader(std::span(kEightBytes).subspan(6)).Read<int16_t>(), -1);
}

TEST(ByteReader, NothingBeyondTheEnd) {
  ByteReader reader(kEightBytes);
  EXPECT_EQ(reader.Bytes(4).size(), 4u);
  EXPECT_EQ(reader.Text(2), "ab");
  EXPECT_THROW(reader.Read<uint32_t>(), MalformedData);
  EXPECT_THROW(reader.Bytes(3), MalformedData);
  EXPECT_THROW(reader.Bytes(~uint64_t{0}), MalformedData);
  EXPECT_EQ(reader.left(), 2u) << "what is refused is not read";
  EXPECT_EQ(reader.Read<uint16_t>(), 0xFFFFu);
  EXPECT_THROW(reader.Read<uint8_t>(), MalformedData);
}

TEST(ByteReader, AlignsFromTheBeginning) {
  ByteReader reader(kEightBytes);
  reader.Align(8);
  EXPECT_EQ(reader.position(), 0u);
  reader.Bytes(1);
  reader.Align(4);
  EXPECT_EQ(reader.position(), 4u);
  reader.Bytes(3);
  EXPECT_THROW(reader.Align(16), MalformedData);
}

}  // namespace
}  // namespace turnscale
