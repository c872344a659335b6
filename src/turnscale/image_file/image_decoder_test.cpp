// SPDX-License-Identifier: MIT
#include "turnscale/image_file/image_decoder.h"

#include <climits>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/image_file/test_png.h"

namespace turnscale {
namespace {

// Smooth, with some noise, as JPEG does not keep all of the latter.
cv::Mat Picture(int type, const cv::Size& size = {53, 38}) {
  cv::Mat image(size, CV_MAKETYPE(CV_MAT_DEPTH(type), CV_MAT_CN(type)));
  std::mt19937 generator(7);
  const auto random = [&](int below) { return static_cast<int>(generator() % below); };
  const double unit = image.depth() == CV_16U ? 256 : 1;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      for (int c = 0; c < image.channels(); ++c) {
        const double level = unit * (20 + 2.5 * x + 1.5 * y * (1 + c % 2) + random(8) + 20 * c);
        const int i = x * image.channels() + c;
        if (image.depth() == CV_16U)
          image.ptr<uint16_t>(y)[i] = cv::saturate_cast<uint16_t>(level + random(256));
        else
          image.ptr<uint8_t>(y)[i] = cv::saturate_cast<uint8_t>(level);
      }
    }
  }
  return image;
}

Bytes Encoded(const std::string& extension, const cv::Mat& image, const std::vector<int>& parameters = {}) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, parameters)) << extension;
  return bytes;
}

// By OpenCV's decoders, which are others.
cv::Mat Reference(const Bytes& bytes) {
  cv::Mat image = cv::imdecode(bytes, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  return image;
}

ImagePixels Decoded(const Bytes& bytes) { return DecodePixels(bytes, INT_MAX); }

bool IsRefused(const Bytes& bytes) { return Decoded(bytes).gray.empty(); }

void ExpectEqual(const cv::Mat& a, const cv::Mat& b, double tolerance = 0) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.type(), b.type());
  EXPECT_LE(cv::norm(a, b, cv::NORM_INF), tolerance);
}

// The seven passes of an 8-bit gray image.
Bytes InterlacedRows(const cv::Mat& image, int passes = 7) {
  constexpr int kFirst[7][2] = {{0, 0}, {4, 0}, {0, 4}, {2, 0}, {0, 2}, {1, 0}, {0, 1}};
  constexpr int kStep[7][2] = {{8, 8}, {8, 8}, {4, 8}, {4, 4}, {2, 4}, {2, 2}, {1, 2}};
  Bytes rows;
  for (int pass = 0; pass < passes; ++pass) {
    for (int y = kFirst[pass][1]; y < image.rows && kFirst[pass][0] < image.cols; y += kStep[pass][1]) {
      rows.push_back(0);
      for (int x = kFirst[pass][0]; x < image.cols; x += kStep[pass][0]) rows.push_back(image.at<uint8_t>(y, x));
    }
  }
  return rows;
}

Bytes PlainRows(const cv::Mat& image) {
  Bytes rows;
  for (int y = 0; y < image.rows; ++y) {
    rows.push_back(0);
    rows.insert(rows.end(), image.ptr<uint8_t>(y), image.ptr<uint8_t>(y) + image.cols * image.elemSize());
  }
  return rows;
}

TEST(ImageDecoder, PixelsAreThoseOfOtherDecoders) {
  for (const std::string extension : {".png", ".bmp", ".pgm", ".ppm", ".tiff"}) {
    for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
      const bool is_deep = CV_MAT_DEPTH(type) == CV_16U;
      if (extension == ".bmp" && is_deep) continue;
      if (extension == ".pgm" && CV_MAT_CN(type) != 1) continue;
      if (extension == ".ppm" && CV_MAT_CN(type) != 3) continue;
      SCOPED_TRACE(extension + " " + std::to_string(type));
      const Bytes bytes = Encoded(extension, Picture(type));
      const ImagePixels decoded = Decoded(bytes);
      ExpectEqual(decoded.gray, Reference(bytes));
      EXPECT_EQ(decoded.colour, CV_MAT_CN(type) > 1);
    }
  }
}

TEST(ImageDecoder, PackingDoesNotMatter) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
    // None, LZW, deflate, PackBits.
    for (const int compression : {1, 5, 8, 32773}) {
      SCOPED_TRACE(std::to_string(type) + " " + std::to_string(compression));
      const Bytes bytes = Encoded(".tiff", Picture(type), {cv::IMWRITE_TIFF_COMPRESSION, compression});
      ExpectEqual(Decoded(bytes).gray, Reference(bytes));
    }
  }
  const cv::Mat gray = Picture(CV_8UC1);
  for (const std::string extension : {".pgm", ".ppm", ".pbm"}) {
    for (const int binary : {0, 1}) {
      SCOPED_TRACE(extension + " " + std::to_string(binary));
      cv::Mat image = gray;
      if (extension == ".ppm") image = Picture(CV_8UC3);
      if (extension == ".pbm") image = (gray > 100) & 255;
      const Bytes bytes = Encoded(extension, image, {cv::IMWRITE_PXM_BINARY, binary});
      ExpectEqual(Decoded(bytes).gray, Reference(bytes));
    }
  }
  const Bytes bytes = Encoded(".png", gray > 100, {cv::IMWRITE_PNG_BILEVEL, 1});
  ExpectEqual(Decoded(bytes).gray, Reference(bytes));
}

TEST(ImageDecoder, LevelsOfFewBitsAreStretched) {
  const Bytes two = Png({4, 1, 2, 0}, {0, 0b00'01'10'11});
  ExpectEqual(Decoded(two).gray, (cv::Mat_<uint8_t>(1, 4) << 0, 85, 170, 255));
  const Bytes four = Png({2, 1, 4, 0}, {0, 0x3C});
  ExpectEqual(Decoded(four).gray, (cv::Mat_<uint8_t>(1, 2) << 0x33, 0xCC));
  const Bytes one = Png({3, 1, 1, 0}, {0, 0b101'00000});
  ExpectEqual(Decoded(one).gray, (cv::Mat_<uint8_t>(1, 3) << 255, 0, 255));
}

// A row of all levels up to the greatest one.
Bytes LevelsOfPgm(int greatest) {
  const std::string header =
      "P5\n# comment 12\n" + std::to_string(greatest + 1) + " 1\n" + std::to_string(greatest) + "\n";
  Bytes bytes(header.begin(), header.end());
  for (int level = 0; level <= greatest; ++level) {
    if (greatest > 255) bytes.push_back(static_cast<uint8_t>(level >> 8));
    bytes.push_back(static_cast<uint8_t>(level));
  }
  return bytes;
}

TEST(ImageDecoder, LevelsOfPgmAreStretchedToTheWholeRange) {
  for (const int greatest : {1, 100, 138, 254, 255, 256, 1023, 4095, 16383, 65534, 65535}) {
    const cv::Mat gray = Decoded(LevelsOfPgm(greatest)).gray;
    ASSERT_EQ(gray.size(), cv::Size(greatest + 1, 1)) << greatest;
    ASSERT_EQ(gray.depth(), greatest > 255 ? CV_16U : CV_8U);
    const double range = greatest > 255 ? 65535 : 255;
    for (int level = 0; level <= greatest; ++level) {
      const int stretched = gray.depth() == CV_16U ? gray.at<uint16_t>(level) : gray.at<uint8_t>(level);
      ASSERT_NEAR(stretched, range * level / greatest, 0.51) << level << " of " << greatest;
    }
  }
  const std::string beyond("P5 2 1 100\n\x64\xFF", 13);
  ExpectEqual(Decoded({beyond.begin(), beyond.end()}).gray, (cv::Mat_<uint8_t>(1, 2) << 255, 255));
  const std::string colours("P6 1 1 100\n\x64\x64\x64", 14);
  ExpectEqual(Decoded({colours.begin(), colours.end()}).gray, (cv::Mat_<uint8_t>(1, 1) << 255));
  for (const std::string header : {"P5 1 1 0\n", "P5 1 1 65536\n", "P5 1 1 -1\n", "P5 1 1", "P5 1 1 #", "P5 1 1 x\n"})
    EXPECT_TRUE(IsRefused({header.begin(), header.end()})) << header;
}

TEST(ImageDecoder, PaletteBecomesGray) {
  const Bytes palette = {0, 0, 0, 255, 0, 0, 0, 255, 0, 10, 20, 200};
  for (const int depth : {2, 8}) {
    const Bytes rows = depth == 8 ? Bytes{0, 0, 1, 2, 3} : Bytes{0, 0b00'01'10'11};
    const Bytes bytes = Png({4, 1, depth, 3}, rows, palette);
    ExpectEqual(Decoded(bytes).gray, Reference(bytes));
    EXPECT_TRUE(Decoded(bytes).colour);
  }
  EXPECT_FALSE(Decoded(Png({1, 1, 8, 3}, {0, 1}, {7, 7, 7, 9, 9, 9})).colour);
  EXPECT_TRUE(IsRefused(Png({1, 1, 8, 3}, {0, 1}))) << "a palette that is missing";
}

TEST(ImageDecoder, AlphaIsIgnored) {
  EXPECT_EQ(Decoded(Png({1, 1, 8, 4}, {0, 90, 0})).gray.at<uint8_t>(0), 90);
  const auto transparent = [](Bytes& png) { AppendChunk(png, "tRNS", {0, 90}); };
  EXPECT_EQ(Decoded(Png({1, 1, 8, 0}, {0, 90}, {}, transparent)).gray.at<uint8_t>(0), 90);
  const Bytes deep = Png({1, 1, 16, 4}, {0, 0x12, 0x34, 0, 0});
  ExpectEqual(Decoded(deep).gray, (cv::Mat_<uint16_t>(1, 1) << 0x1234));
}

TEST(ImageDecoder, InterlacedPngIsWholeOrRefused) {
  for (const cv::Size& size : {cv::Size(53, 38), cv::Size(1, 1), cv::Size(3, 9)}) {
    const cv::Mat image = Picture(CV_8UC1, size);
    ExpectEqual(Decoded(Png({size.width, size.height, 8, 0, 1}, InterlacedRows(image))).gray, image);
  }
  const cv::Mat image = Picture(CV_8UC1);
  for (int passes = 0; passes < 7; ++passes)
    EXPECT_TRUE(IsRefused(Png({image.cols, image.rows, 8, 0, 1}, InterlacedRows(image, passes)))) << passes;
  const cv::Mat level(38, 53, CV_8UC1, cv::Scalar(0x5B));
  ExpectEqual(Decoded(Png({53, 38, 8, 0, 1}, InterlacedRows(level))).gray, level);
}

TEST(ImageDecoder, PngWithTooFewRowsIsRefused) {
  const cv::Mat image = Picture(CV_8UC1);
  for (const int rows : {0, 1, 20, image.rows - 1})
    EXPECT_TRUE(IsRefused(Png({image.cols, image.rows}, PlainRows(image.rowRange(0, rows))))) << rows;
  ExpectEqual(Decoded(Png({image.cols, image.rows}, PlainRows(image))).gray, image);
}

TEST(ImageDecoder, EveryLevelIsALevel) {
  for (int level = 0; level < 256; ++level) {
    const cv::Mat image(9, 17, CV_8UC1, cv::Scalar(level));
    for (const std::string extension : {".png", ".bmp", ".pgm", ".tiff", ".jpg"})
      ExpectEqual(Decoded(Encoded(extension, image)).gray, image, extension == ".jpg" ? 1 : 0);
  }
}

TEST(ImageDecoder, JpegGivesItsLuma) {
  for (const int progressive : {0, 1}) {
    for (const int restart : {0, 3}) {
      const std::vector<int> parameters = {cv::IMWRITE_JPEG_QUALITY,      95,
                                           cv::IMWRITE_JPEG_PROGRESSIVE,  progressive,
                                           cv::IMWRITE_JPEG_RST_INTERVAL, restart};
      const Bytes gray = Encoded(".jpg", Picture(CV_8UC1), parameters);
      ExpectEqual(Decoded(gray).gray, Reference(gray), 1);
      EXPECT_FALSE(Decoded(gray).colour);
      const Bytes colour = Encoded(".jpg", Picture(CV_8UC3), parameters);
      // Colours out of range are cut off on the reference's way through RGB.
      ExpectEqual(Decoded(colour).gray, Reference(colour), 3);
      EXPECT_TRUE(Decoded(colour).colour);
    }
  }
}

TEST(ImageDecoder, OrientationIsIgnored) {
  const Bytes plain = Encoded(".jpg", Picture(CV_8UC1));
  // A camera that was turned by 90 degrees.
  const std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0",
      36);
  Bytes turned = plain;
  turned.insert(turned.begin() + 2, exif.begin(), exif.end());
  ASSERT_EQ(cv::imdecode(turned, cv::IMREAD_GRAYSCALE).cols, 38) << "the reference turns it";
  ExpectEqual(Decoded(turned).gray, Decoded(plain).gray);
}

TEST(ImageDecoder, JpegInLimitedRangeIsStretched) {
  const cv::Mat white(16, 16, CV_8UC3, cv::Scalar::all(235));
  Bytes bytes = Encoded(".jpg", white);
  const std::string comment(
      "\xFF\xFE\x00\x0C"
      "CS=ITU601\0",
      14);
  bytes.insert(bytes.begin() + 2, comment.begin(), comment.end());
  EXPECT_EQ(Decoded(bytes).gray.at<uint8_t>(8, 8), 255);
}

TEST(ImageDecoder, JpegWithoutItsScanIsRefused) {
  const Bytes whole = Encoded(".jpg", Picture(CV_8UC1, {120, 90}));
  const std::string scan = "\xFF\xDA";
  const auto begin = std::search(whole.begin(), whole.end(), scan.begin(), scan.end(),
                                 [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); });
  Bytes none(whole.begin(), begin);
  none.insert(none.end(), {0xFF, 0xD9});
  EXPECT_TRUE(IsRefused(none));
  for (const double part : {0.3, 0.6, 0.95}) {
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(whole.size())));
    EXPECT_TRUE(cut.size() < static_cast<size_t>(begin - whole.begin()) + 10 || IsRefused(cut)) << part;
    cut.insert(cut.end(), {0xFF, 0xD9});
    EXPECT_TRUE(IsRefused(cut)) << part;
  }
}

TEST(ImageDecoder, FlippedBitsOfAPngAreNoticed) {
  const Bytes whole = Encoded(".png", Picture(CV_8UC1));
  const cv::Mat pixels = Reference(whole);
  int refused = 0;
  for (size_t place = 8; place < whole.size(); ++place) {
    Bytes flipped = whole;
    flipped[place] ^= static_cast<uint8_t>(1U << (place % 8));
    const cv::Mat gray = Decoded(flipped).gray;
    refused += gray.empty() ? 1 : 0;
    if (!gray.empty()) ExpectEqual(gray, pixels);
  }
  // All but the end's name, size and checksum, which come after the pixels.
  EXPECT_GE(refused, static_cast<int>(whole.size()) - 8 - 12);
}

TEST(ImageDecoder, DamagedImagesAreDeterministic) {
  std::mt19937 random(3);
  for (const std::string extension : {".png", ".jpg", ".bmp", ".pgm", ".tiff"}) {
    for (const int type : {CV_8UC1, CV_8UC3}) {
      if (extension == ".pgm" && type == CV_8UC3) continue;
      const Bytes whole = Encoded(extension, Picture(type));
      for (int i = 0; i < 300; ++i) {
        Bytes damaged = whole;
        for (int change = 0; change < 3; ++change) damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
        if (i % 5 == 0) damaged.resize(random() % damaged.size());
        const cv::Mat first = DecodePixels(damaged, 1'000'000).gray;
        Decoded(whole);
        const cv::Mat second = DecodePixels(damaged, 1'000'000).gray;
        ASSERT_EQ(first.empty(), second.empty());
        if (!first.empty()) ExpectEqual(first, second);
      }
    }
  }
}

TEST(ImageDecoder, DamageBesideThePixelsDoesNoHarm) {
  const auto broken_text = [](Bytes& png) {
    AppendChunk(png, "tEXt", {'a', 0, 'b'});
    png.back() ^= 1;
    AppendChunk(png, "iCCP", {'a', 0, 0, 'b'});
  };
  EXPECT_EQ(Decoded(Png({1, 1}, {0, 90}, {}, broken_text)).gray.at<uint8_t>(0), 90);
}

TEST(ImageDecoder, HugeSizesAreRefused) {
  const Bytes png = Png({20'000, 20'000}, {0, 1, 2, 3});
  EXPECT_TRUE(DecodePixels(png, 100'000'000).gray.empty());
  EXPECT_TRUE(IsRefused(Png({0x7FFFFFFF, 0x7FFFFFFF}, {0})));
  EXPECT_TRUE(IsRefused(Png({0, 5}, {0})));
  for (const int interlace : {0, 1}) {
    EXPECT_TRUE(IsRefused(Png({46'000, 46'000, 16, 6, interlace}, Bytes(100)))) << "gigabytes from few bytes";
    const cv::Mat black(2000, 2000, CV_8UC1, cv::Scalar(0));
    ExpectEqual(Decoded(Png({2000, 2000, 8, 0, interlace}, interlace ? InterlacedRows(black) : PlainRows(black))).gray,
                black);
  }
  const Bytes small = Encoded(".png", Picture(CV_8UC1, {64, 64}));
  EXPECT_TRUE(DecodePixels(small, 64 * 64 - 1).gray.empty());
  EXPECT_FALSE(DecodePixels(small, 64 * 64).gray.empty());
  const std::string pgm = "P5 60000 60000 255\nabc";
  EXPECT_TRUE(IsRefused({pgm.begin(), pgm.end()}));
}

TEST(ImageDecoder, OtherBytesAreRefused) {
  EXPECT_TRUE(IsRefused({}));
  for (const std::string text :
       {"x", "BM", "P5", "P6\n", "P", "II*", "\xFF\xD8", "\xFF\xD8\xFF", "\x89PNG\r\n\x1a\n", "this is no image"})
    EXPECT_TRUE(IsRefused({text.begin(), text.end()})) << text;
  EXPECT_TRUE(IsRefused(Encoded(".webp", Picture(CV_8UC3))));
}

}  // namespace
}  // namespace turnscale
