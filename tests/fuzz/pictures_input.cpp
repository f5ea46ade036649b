// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenImageIO and its libraries do not stand any bytes: they write the pictures that they then read.
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <vector>

#include "tests/fuzz/input_folder.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

// Pictures from a line of text, written by OpenImageIO. A function without state.
//
//   NAME.png WIDTH HEIGHT CHANNELS TYPE [tiled] [alpha] [bits=N] [pages=N] [cut=BYTES]     or NAME.tif
//   NAME TEXT                                                                 of other names than those

constexpr int mostPicturePixels = 4096, mostChannels = 5, mostPages = 8;

/// Its writers end the process where they are asked for others.
OIIO::TypeDesc pictureTypeOf(std::string_view name) {
    constexpr std::array<const char*, 9> known{"uint8", "int8", "uint16", "int16", "uint32",
                                               "int32", "half", "float",  "double"};
    const auto* const found = std::find(known.begin(), known.end(), name);
    return OIIO::TypeDesc(found != known.end() ? *found : known.front());
}

/// What a line says of a picture.
struct Picture {
    OIIO::ImageSpec spec;
    int pages = 1;
    std::uintmax_t cut = 0;  ///< bytes that are cut off its end
};

/// "WIDTH HEIGHT CHANNELS TYPE [tiled] [alpha] [bits=N] [pages=N] [cut=N]..."
Picture pictureOf(Words words) {
    const int width = std::clamp(words.number(3), 1, mostPicturePixels);
    const int height = std::clamp(words.number(2), 1, mostPicturePixels / width);
    const int channels = std::clamp(words.number(1), 1, mostChannels);
    Picture picture{{width, height, channels, pictureTypeOf(words.next())}, 1, 0};
    while (!words.atEnd()) {
        Words option(words.next(), '=');
        const std::string name = option.next();
        if (name == "tiled") picture.spec.tile_width = picture.spec.tile_height = 16;
        if (name == "alpha") picture.spec.alpha_channel = channels - 1;
        if (name == "bits") picture.spec.attribute("oiio:BitsPerSample", option.number(8));
        if (name == "pages") picture.pages = std::clamp(option.number(2), 1, mostPages);
        if (name == "cut") picture.cut = option.number<std::uintmax_t>(1);
    }
    return picture;
}

/// One after the other, with values of no meaning; what the format cannot hold is left out.
void writePages(const std::filesystem::path& path, const Picture& picture) {
    const auto output = OIIO::ImageOutput::create(path.string());
    if (!output) return;
    const auto& spec = picture.spec;
    std::vector<float> pixels(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i % 7) / 7.0F;
    for (int page = 0; page < picture.pages; ++page) {
        const auto mode = page == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
        if (!output->open(path.string(), spec, mode)) return;
        if (!output->write_image(OIIO::TypeDesc::FLOAT, pixels.data())) return;
    }
    output->close();
}

/// What the format cannot hold is left out.
void writePicture(const InputFolder& folder, std::string_view line) {
    Words words(line);
    const std::string name = words.next();
    if (!isPlainName(name)) return;
    const auto path = folder.path() / name;
    if (!name.ends_with(".png") && !name.ends_with(".tif")) return folder.write(name, words.rest());
    Picture picture = pictureOf(words);
    // Its writer of PNG ends the process if it cannot begin one in tiles, which that format has not.
    if (name.ends_with(".png")) picture.spec.tile_width = picture.spec.tile_height = 0;
    writePages(path, picture);
    std::error_code code;
    const auto bytes = std::filesystem::file_size(path, code);
    if (!code && picture.cut > 0) std::filesystem::resize_file(path, bytes - std::min(bytes, picture.cut));
}

constexpr int mostPictures = 16;

}  // namespace

std::string picturesInput(std::string_view input) {
    auto [line, rest] = firstLine(input);
    Words words(line);
    proto::VolumeSourceOptions options;
    options.set_format(words.next());
    const std::string name = words.next();
    if (options.format() == "vdb" || (name != "." && !isPlainName(name))) return "another reader";
    const InputFolder folder;
    for (int i = 0; i < mostPictures && !rest.empty(); ++i) {
        std::tie(line, rest) = firstLine(rest);
        writePicture(folder, line);
    }
    return readVolume(options, name == "." ? folder.path() : folder.path() / name);
}

}  // namespace mote::test
