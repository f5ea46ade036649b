// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/image.h"

#include <OpenImageIO/imageio.h>

#include "protocol/scene/mote_check.h"

namespace mote::test {

Status writePng(const Image& image, const std::filesystem::path& path) {
    MOTE_CHECK(image.pixels.size() == std::size_t{4} * image.width * image.height);
    std::error_code code;
    std::filesystem::create_directories(path.parent_path(), code);
    const auto output = OIIO::ImageOutput::create(path.string());
    if (!output) return Error{ErrorCode::internal, path.string(), OIIO::geterror()};
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 4, OIIO::TypeUInt8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (!output->open(path.string(), spec) || !output->write_image(OIIO::TypeUInt8, image.pixels.data()) ||
        !output->close()) {
        return Error{ErrorCode::internal, path.string(), output->geterror()};
    }
    return success();
}

Result<Image> readPng(const std::filesystem::path& path) {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path.string(), &config);
    if (!input) return Error{ErrorCode::notFound, path.string(), OIIO::geterror()};
    const auto& spec = input->spec();
    if (spec.nchannels < 3 || spec.nchannels > 4 || spec.format != OIIO::TypeUInt8) {
        return Error{ErrorCode::unsupported, path.string(), "three or four channels of 8 bits are needed"};
    }
    Image image{static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height), {}};
    image.pixels.assign(std::size_t{4} * image.width * image.height, 255);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeUInt8, image.pixels.data(), 4)) {
        return Error{ErrorCode::unsupported, path.string(), input->geterror()};
    }
    return image;
}

}  // namespace mote::test
