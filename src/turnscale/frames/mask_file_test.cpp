// SPDX-License-Identifier: MIT
#include "turnscale/frames/mask_file.h"

#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

std::string Complaint(const std::filesystem::path& path) {
  try {
    ReadMask(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(MaskFile, IsReadAsGray) {
  const std::filesystem::path path = ScratchPath("mask.png");
  cv::Mat colours(20, 30, CV_8UC3, cv::Scalar(0, 40, 0));
  colours.rowRange(15, 20).setTo(cv::Scalar::all(0));
  cv::imwrite(path.string(), colours);
  const cv::Mat mask = ReadMask(path);
  EXPECT_EQ(mask.type(), CV_8UC1);
  EXPECT_EQ(cv::countNonZero(mask), 15 * 30);
  EXPECT_NO_THROW(CheckMaskSize(path, mask, {30, 20}));
  EXPECT_THROW(CheckMaskSize(path, mask, {20, 30}), InputError);
}

TEST(MaskFile, WhatIsNoMaskIsRefused) {
  EXPECT_NE(Complaint("/nonexistent/mask.png").find("no such mask"), std::string::npos);
  EXPECT_NE(Complaint(::testing::TempDir()).find("is a folder, not a mask"), std::string::npos);
  const std::filesystem::path text = ScratchPath("text.png");
  std::ofstream(text) << "no image";
  EXPECT_EQ(Complaint(text), text.string() + ": is not a readable image");
  const std::filesystem::path black = ScratchPath("black.png");
  cv::imwrite(black.string(), cv::Mat::zeros(20, 30, CV_8U));
  EXPECT_NE(Complaint(black).find("leaves out the whole image"), std::string::npos);
}

TEST(MaskFile, OneThatIsIncompleteIsNamedSo) {
  const std::filesystem::path path = ScratchPath("mask.png");
  cv::imwrite(path.string(), cv::Mat::zeros(20, 30, CV_8U));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 20);
  EXPECT_EQ(Complaint(path), path.string() + ": is truncated");
  std::ofstream(path).flush();
  EXPECT_EQ(Complaint(path), path.string() + ": is empty");
}

TEST(MaskFile, OneThatLeavesNothingOutIsRefused) {
  const std::filesystem::path path = ScratchPath("mask.png");
  for (const cv::Scalar& colour : {cv::Scalar(0, 0, 255), cv::Scalar(3, 3, 3)}) {
    cv::Mat mask(20, 30, CV_8UC3, cv::Scalar::all(255));
    mask.rowRange(15, 20).setTo(colour);
    cv::imwrite(path.string(), mask);
    EXPECT_NE(Complaint(path).find("leaves nothing out: its darkest pixel has the gray level "), std::string::npos);
  }
  EXPECT_NE(Complaint(path).find("level 3; paint what is to be left out black (0)"), std::string::npos);
}

}  // namespace
}  // namespace turnscale
