// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/client/frames.h"

#include <turbojpeg.h>
#include <zstd.h>

#include <stdexcept>

#include "protocol/wire/row_filter.h"

namespace mote::test {
namespace {

void require(bool condition, const char* what) {
    if (!condition) throw std::runtime_error(what);
}

}  // namespace

std::vector<std::uint8_t> samplePixels(std::uint32_t width, std::uint32_t height, proto::PixelFormat format) {
    const std::size_t size = wire::pixelSize(format), channel = size / 4;
    std::vector<std::uint8_t> bytes(size * width * height);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const std::size_t pixel = i / size, row = pixel / width, column = pixel % width;
        // A slope, a slope across it, and steps: differences of both signs and zero. As halves all these
        // are positive and finite.
        bytes[i] = static_cast<std::uint8_t>((3 * column + 5 * row + 17 * ((i % size) / channel)) % 61);
        if (i % size < 3 * channel) continue;
        bytes[i] = format == proto::SRGB8 ? 255 : (i % 2 == 0 ? 0x00 : 0x3c);
    }
    return bytes;
}

proto::Frame frameMessage(std::uint32_t width, std::uint32_t height, proto::PixelFormat format,
                          proto::Frame::Encoding encoding) {
    proto::Frame frame;
    frame.set_width(width);
    frame.set_height(height);
    frame.set_format(format);
    frame.set_encoding(encoding);
    frame.set_final(true);
    return frame;
}

std::string zstdPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width,
                        proto::PixelFormat format) {
    const std::size_t pixels = rgba.size() / wire::pixelSize(format);
    std::vector<std::uint8_t> filtered(pixels * wire::filteredPixelSize(format));
    wire::filterRows(format, width, rgba, filtered);
    std::string packed(ZSTD_compressBound(filtered.size()), '\0');
    const auto size = ZSTD_compress(packed.data(), packed.size(), filtered.data(), filtered.size(), 1);
    require(!ZSTD_isError(size), "zstd");
    packed.resize(size);
    return packed;
}

std::string jpegPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width) {
    const tjhandle jpeg = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    const int rows = static_cast<int>(rgba.size() / (4 * width));
    const int status = tjCompress2(jpeg, rgba.data(), static_cast<int>(width), 0, rows, TJPF_RGBA, &bytes,
                                   &size, TJSAMP_444, 100, 0);
    std::string payload(reinterpret_cast<char*>(bytes), status == 0 ? size : 0);
    tjFree(bytes);
    tjDestroy(jpeg);
    require(status == 0, "libjpeg-turbo");
    return payload;
}

}  // namespace mote::test
