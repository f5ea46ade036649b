// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/image.h"

#include <png.h>

#include "protocol/base/mote_check.h"

namespace mote::test {
namespace {

/// libpng's control of one picture, whose memory it frees.
struct Png {
    Png() { control.version = PNG_IMAGE_VERSION; }
    ~Png() { png_image_free(&control); }
    Png(const Png&) = delete;
    Png& operator=(const Png&) = delete;

    png_image control{};
};

}  // namespace

Status writePng(const Image& image, const std::filesystem::path& path) {
    MOTE_CHECK(image.pixels.size() == std::size_t{4} * image.width * image.height);
    std::error_code code;
    std::filesystem::create_directories(path.parent_path(), code);
    Png png;
    png.control.width = image.width;
    png.control.height = image.height;
    png.control.format = PNG_FORMAT_RGBA;
    if (!png_image_write_to_file(&png.control, path.c_str(), 0, image.pixels.data(), 0, nullptr)) {
        return Error{ErrorCode::internal, path.string(), png.control.message};
    }
    return success();
}

Result<Image> readPng(const std::filesystem::path& path) {
    Png png;
    if (!png_image_begin_read_from_file(&png.control, path.c_str())) {
        return Error{ErrorCode::notFound, path.string(), png.control.message};
    }
    const auto stored = png.control.format;
    if (!(stored & PNG_FORMAT_FLAG_COLOR) || (stored & PNG_FORMAT_FLAG_LINEAR)) {
        return Error{ErrorCode::unsupported, path.string(), "three or four channels of 8 bits are needed"};
    }
    png.control.format = PNG_FORMAT_RGBA;
    Image image{png.control.width, png.control.height, {}};
    image.pixels.resize(PNG_IMAGE_SIZE(png.control));
    if (!png_image_finish_read(&png.control, nullptr, image.pixels.data(), 0, nullptr)) {
        return Error{ErrorCode::unsupported, path.string(), png.control.message};
    }
    return image;
}

}  // namespace mote::test
