// SPDX-License-Identifier: MIT
// Writes the pixels of all images of the plain street drive into the file that is named.
#include <cstdio>
#include <fstream>

#include "street_drive.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("render_street_drive: name one file\n", stderr);
    return 2;
  }
  std::ofstream file(argv[1], std::ios::binary);
  for (const cv::Mat& image : turnscale::RenderStreetDrive({}).images) {
    file.write(image.ptr<char>(), static_cast<std::streamsize>(image.total()));
  }
  file.close();
  return file ? 0 : 1;
}
