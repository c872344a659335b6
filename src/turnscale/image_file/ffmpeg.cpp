// SPDX-License-Identifier: MIT
#include "turnscale/image_file/ffmpeg.h"

#include <string>

#include <dlfcn.h>

#include "turnscale/base/error.h"

extern "C" {
#include <libavutil/macros.h>
}

namespace turnscale::ffmpeg {
namespace {

// Of the version that the headers describe.
const char* FileOf(Library library) {
  switch (library) {
    case Library::kUtil:
      return "libavutil.so." AV_STRINGIFY(LIBAVUTIL_VERSION_MAJOR);
    case Library::kCodec:
      return "libavcodec.so." AV_STRINGIFY(LIBAVCODEC_VERSION_MAJOR);
    case Library::kFormat:
      return "libavformat.so." AV_STRINGIFY(LIBAVFORMAT_VERSION_MAJOR);
    case Library::kScale:
      return "libswscale.so." AV_STRINGIFY(LIBSWSCALE_VERSION_MAJOR);
  }
  return "";
}

}  // namespace

void* AddressOf(Library library, const char* name) {
  // dlopen loads a library once and counts its users. It is never closed.
  void* loaded = dlopen(FileOf(library), RTLD_LAZY | RTLD_LOCAL);
  void* address = loaded == nullptr ? nullptr : dlsym(loaded, name);
  if (address == nullptr) {
    const char* why = dlerror();
    throw InputError(std::string(FileOf(library)) + ": cannot be loaded (" + (why == nullptr ? name : why) +
                     "); install this version of FFmpeg's libraries, which read and write videos and images");
  }
  return address;
}

}  // namespace turnscale::ffmpeg
