// SPDX-License-Identifier: MIT
#include "turnscale/bag/decompression.h"

#include <algorithm>
#include <memory>
#include <new>
#include <string>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "turnscale/bag/byte_reader.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

// What one call of a decoder did.
struct DecoderStep {
  size_t consumed = 0;
  size_t produced = 0;
  bool finished = false;
};

[[noreturn]] void RefuseDamaged(const char* compression) {
  throw MalformedData(std::string("damaged ") + compression + " data");
}

class Lz4Decoder {
 public:
  Lz4Decoder() {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) throw std::bad_alloc();
    context_.reset(context);
  }

  DecoderStep Step(std::span<const uint8_t> in, std::span<uint8_t> out) {
    size_t consumed = in.size();
    size_t produced = out.size();
    const size_t hint = LZ4F_decompress(context_.get(), out.data(), &produced, in.data(), &consumed, nullptr);
    if (LZ4F_isError(hint)) RefuseDamaged("lz4");
    return {consumed, produced, hint == 0};
  }

 private:
  struct Free {
    void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
  };
  std::unique_ptr<LZ4F_dctx, Free> context_;
};

class ZstdDecoder {
 public:
  ZstdDecoder() : stream_(ZSTD_createDStream()) {
    if (!stream_) throw std::bad_alloc();
  }

  DecoderStep Step(std::span<const uint8_t> in, std::span<uint8_t> out) {
    ZSTD_inBuffer input = {in.data(), in.size(), 0};
    ZSTD_outBuffer output = {out.data(), out.size(), 0};
    const size_t hint = ZSTD_decompressStream(stream_.get(), &output, &input);
    if (ZSTD_isError(hint)) RefuseDamaged("zstd");
    return {input.pos, output.pos, hint == 0};
  }

 private:
  struct Free {
    void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
  };
  std::unique_ptr<ZSTD_DStream, Free> stream_;
};

class Bz2Decoder {
 public:
  Bz2Decoder() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }
  ~Bz2Decoder() { BZ2_bzDecompressEnd(&stream_); }
  Bz2Decoder(const Bz2Decoder&) = delete;
  Bz2Decoder& operator=(const Bz2Decoder&) = delete;

  DecoderStep Step(std::span<const uint8_t> in, std::span<uint8_t> out) {
    // The library does not write to its input. Both are below 4 GB: Decompress's callers bound them.
    stream_.next_in = const_cast<char*>(reinterpret_cast<const char*>(in.data()));
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = reinterpret_cast<char*>(out.data());
    stream_.avail_out = static_cast<unsigned>(out.size());
    const int result = BZ2_bzDecompress(&stream_);
    if (result == BZ_MEM_ERROR) throw std::bad_alloc();
    if (result != BZ_OK && result != BZ_STREAM_END) RefuseDamaged("bz2");
    return {in.size() - stream_.avail_in, out.size() - stream_.avail_out, result == BZ_STREAM_END};
  }

 private:
  bz_stream stream_{};
};

template <class Decoder>
void DecompressWith(Decoder decoder, std::span<const uint8_t> compressed, size_t size, std::vector<uint8_t>& out) {
  constexpr size_t kLeast = 1 << 16;
  // One byte more than there should be, so that the decoder comes to the end of the data.
  const size_t most = size + 1;
  out.resize(std::min(most, std::max(4 * compressed.size(), kLeast)));
  size_t used = 0;
  size_t made = 0;
  for (bool finished = false; !finished;) {
    if (made > size) throw MalformedData("compressed data are larger than stated");
    if (made == out.size()) out.resize(std::min(most, 2 * out.size()));
    const DecoderStep step = decoder.Step(compressed.subspan(used), std::span(out).subspan(made));
    used += step.consumed;
    made += step.produced;
    finished = step.finished;
    if (!finished && step.consumed == 0 && step.produced == 0) throw MalformedData("compressed data end early");
  }
  if (made != size) throw MalformedData("compressed data have another size than stated");
  out.resize(size);
}

}  // namespace

void Decompress(std::string_view compression, std::span<const uint8_t> compressed, size_t size,
                std::vector<uint8_t>& out) {
  if (compression == "lz4") return DecompressWith<Lz4Decoder>({}, compressed, size, out);
  if (compression == "zstd") return DecompressWith<ZstdDecoder>({}, compressed, size, out);
  if (compression == "bz2") return DecompressWith<Bz2Decoder>({}, compressed, size, out);
  throw MalformedData("unknown compression '" + Printable(compression.substr(0, 32)) + "'");
}

}  // namespace turnscale
