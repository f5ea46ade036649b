// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-video --film FILE PICTURE...: pictures of one size as a film; bytes and processor time a frame, and
// how near the decoded film is to them. Asserts nothing.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <chrono>
#include <stdexcept>

#include "client/frames/video/gif_palette.h"
#include "client/frames/video/video_writer.h"
#include "protocol/cli/command.h"
#include "tests/bench/video/plain_encoder.h"
#include "tests/unit/client/film_reader.h"

namespace mote::bench {
namespace {

using namespace client;

struct Options {
    std::string film, encoder;
    std::vector<std::string> pictures;
    int crf = -1;
    bool halved = false;
};

template <class T>
T valueOf(Result<T> result) {
    if (!result.ok()) throw std::runtime_error("bench-video: " + result.error().toString());
    return std::move(*result);
}

std::vector<std::uint8_t> readPicture(const std::string& path, VideoSettings& settings) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input) throw std::runtime_error("bench-video: " + OIIO::geterror());
    settings.width = static_cast<std::uint32_t>(input->spec().width);
    settings.height = static_cast<std::uint32_t>(input->spec().height);
    std::vector<std::uint8_t> rgba(std::size_t{4} * settings.width * settings.height, 255);
    input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, rgba.data(), 4);
    return rgba;
}

/// As mote-frames does it.
double encodeFilm(const Options& options, const VideoSettings& settings, const Frames& frames) {
    const double before = processorTime();
    std::optional<GifPalette> palette;
    if (settings.format == VideoFormat::gif) {
        PaletteMaker maker;
        for (const auto& frame : frames) maker.add(frame);
        palette = maker.make();
    }
    const auto writer = valueOf(VideoWriter::create(options.film, settings, palette));
    for (const auto& frame : frames) valueOf(writer->add(frame));
    valueOf(writer->finish());
    return processorTime() - before;
}

double encode(const Options& options, const VideoSettings& settings, const Frames& frames) {
    if (options.encoder.empty()) return encodeFilm(options, settings, frames);
    const auto colon = options.encoder.find(':');
    const auto rest = colon == std::string::npos ? "" : options.encoder.substr(colon + 1);
    return encodePlainly(options.film, settings, options.encoder.substr(0, colon), rest, frames);
}

void run(const Options& options) {
    VideoSettings settings;
    settings.format =
        videoFormat(std::filesystem::path(options.film).extension().string()).value_or(VideoFormat::mp4);
    settings.chroma = options.halved ? VideoChroma::halved : VideoChroma::full;
    if (options.crf >= 0) settings.quality = static_cast<unsigned>(options.crf);
    Frames frames;
    for (const auto& picture : options.pictures) frames.push_back(readPicture(picture, settings));
    const auto begin = std::chrono::steady_clock::now();
    const double used = encode(options, settings, frames);
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    const auto count = static_cast<double>(frames.size());
    fmt::print("{:.2f} dB  {:.0f} KB  {:.1f} ms of processor time, {:.1f} ms passed  a frame of {}: {} {}\n",
               test::psnr(test::readFilm(options.film).frames, frames),
               static_cast<double>(std::filesystem::file_size(options.film)) / 1000 / count,
               1e3 * used / count, 1e3 * passed.count() / count, frames.size(),
               options.halved ? "halved" : "full", options.encoder);
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    mote::bench::Options options;
    const mote::cli::Program program("What a film's encoder takes, and what it leaves of its frames",
                                     "bench-video");
    const auto command = program.command();
    command.option("--film", options.film, "The film to make, .mp4, .webm or .gif").required();
    command.option("--crf", options.crf, "As of mote-frames");
    command.flag("--halved", options.halved, "Chroma for two by two pixels");
    command.option("--encoder", options.encoder, "Another: libx264:preset=medium:crf=18");
    command.option("PICTURE", options.pictures, "Of one size, in their order").required();
    if (const auto end = program.parse(argc, argv)) return *end;
    try {
        mote::bench::run(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
    return 0;
}
