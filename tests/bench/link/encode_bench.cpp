// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-encode [COUNT]: size, time of the encoder and of the decoder, and what is lost, of each encoding side
// by side on the pictures of an orbit, 1280 x 720. Prints a table; asserts nothing.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "client/shared/decode.h"
#include "server/encode/encode.h"
#include "server/encode/frame_encoder.h"
#include "tests/bench/link/bench_pictures.h"

namespace mote::bench {
namespace {

using server::EncodedPicture;
using Clock = std::chrono::steady_clock;
using Encode = std::function<Result<EncodedPicture>(const render::Picture&)>;

double since(Clock::time_point then) {
    return std::chrono::duration<double, std::milli>(Clock::now() - then).count();
}

double squares(const render::Picture& picture, const client::FramePixels& pixels) {
    double sum = 0.0;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        const double difference = i % 4 == 3 ? 0.0 : double{1.0} * picture.pixels[i] - pixels.bytes[i];
        sum += difference * difference;
    }
    return sum;
}

struct Row {
    double bytes = 0.0, encodeMs = 0.0, decodeMs = 0.0, squares = 0.0, samples = 0.0;
};

Row measure(const Orbit& orbit, const Encode& encode) {
    Row row;
    client::FrameDecoder decoder;
    for (std::size_t i = 0; i < orbit.pictures.size(); ++i) {
        const auto& picture = orbit.pictures[i];
        auto begun = Clock::now();
        const auto made = encode(picture);
        const double encodeMs = since(begun);
        if (!made.ok()) throw std::runtime_error(made.error().toString());
        proto::Frame message;
        message.set_width(picture.width);
        message.set_height(picture.height);
        message.set_format(proto::SRGB8);
        message.set_encoding(made->encoding);
        message.set_key(made->key);
        begun = Clock::now();
        const auto pixels = decoder.decode(message, made->payload);
        const double decodeMs = since(begun);
        if (!pixels.ok()) throw std::runtime_error(pixels.error().toString());
        if (i == 0) continue;  // memory is taken, a stream begins
        row.bytes += static_cast<double>(made->payload.size());
        row.encodeMs += encodeMs;
        row.decodeMs += decodeMs;
        row.squares += squares(picture, *pixels);
        row.samples += 0.75 * static_cast<double>(picture.pixels.size());
    }
    return row;
}

void print(const std::string& what, const Row& row, std::size_t count) {
    const auto frames = static_cast<double>(count - 1);
    fmt::print("  {:<22} {:>7.0f} {:>10.2f} {:>10.2f} {:>9}\n", what, row.bytes / frames / 1024.0,
               row.encodeMs / frames, row.decodeMs / frames,
               row.squares == 0.0
                   ? "lossless"
                   : fmt::format("{:.1f}", 10.0 * std::log10(65025.0 * row.samples / row.squares)));
}

void run(int count) {
    fmt::print("1280 x 720, means of {} pictures      KiB     encode     decode   PSNR dB\n", count - 1);
    for (const auto& orbit : orbits(1280, 720, count)) {
        fmt::print("{}\n", orbit.name);
        server::LosslessEncoder lossless;
        print("lossless",
              measure(orbit,
                      [&](const auto& picture) -> Result<EncodedPicture> {
                          auto payload = lossless.encode(picture);
                          MOTE_RETURN_IF_ERROR(payload);
                          return EncodedPicture{proto::Frame::ZSTD, false, *std::move(payload)};
                      }),
              orbit.pictures.size());
        print("JPEG, quality 80",
              measure(orbit,
                      [&](const auto& picture) -> Result<EncodedPicture> {
                          auto payload = server::encodeJpeg(picture);
                          MOTE_RETURN_IF_ERROR(payload);
                          return EncodedPicture{proto::Frame::JPEG, false, *std::move(payload)};
                      }),
              orbit.pictures.size());
        for (const std::size_t most : {30u << 10, 60u << 10, 120u << 10, 1000u << 10}) {
            server::H264Encoder h264;
            print(fmt::format("H.264, {} KiB", most >> 10),
                  measure(orbit,
                          [&](const auto& picture) -> Result<EncodedPicture> {
                              auto made = h264.encode(picture, most, false);
                              MOTE_RETURN_IF_ERROR(made);
                              return EncodedPicture{proto::Frame::H264, made->key, std::move(made->payload)};
                          }),
                  orbit.pictures.size());
        }
    }
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    try {
        mote::bench::run(argc > 1 ? std::max(2, std::atoi(argv[1])) : 20);
        return 0;
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-encode: {}\n", failure.what());
        return 1;
    }
}
