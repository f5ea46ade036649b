// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/row_filter.h"

#include <algorithm>
#include <cstring>

#include "protocol/base/mote_check.h"

namespace mote::wire {
namespace {

constexpr std::size_t channels = 3;  // of a filtered pixel
constexpr std::uint8_t opaqueByte = 255;
constexpr std::uint8_t opaqueHalf[2] = {0x00, 0x3c};  // 1.0 as an IEEE half, little-endian

constexpr std::size_t block = 512;  // pixels whose differences are taken before they are packed

/// Differences of whole words are what a processor does sixteen at a time; then three bytes of each four go
/// out.
void filterBytes(const std::uint8_t* rgba, std::size_t width, std::uint8_t* out) {
    std::uint8_t differences[4 * block];
    for (std::size_t begin = 0; begin < width; begin += block) {
        const std::size_t count = std::min(block, width - begin);
        const std::uint8_t* pixels = rgba + 4 * begin;
        const std::size_t first = begin == 0 ? 4 : 0;  // bytes that have no left neighbour
        std::copy(pixels, pixels + first, differences);
        for (std::size_t i = first; i < 4 * count; ++i) {
            differences[i] = static_cast<std::uint8_t>(pixels[i] - pixels[i - 4]);
        }
        std::uint8_t* to = out + channels * begin;
        // Four bytes at a time, the last of which the next pixel overwrites.
        for (std::size_t i = 0; i + 1 < count; ++i) std::memcpy(to + channels * i, differences + 4 * i, 4);
        std::memcpy(to + channels * (count - 1), differences + 4 * (count - 1), channels);
    }
}

void unfilterBytes(const std::uint8_t* in, std::size_t width, std::uint8_t* rgba) {
    std::uint8_t left[channels] = {0, 0, 0};
    for (std::size_t i = 0; i < width; ++i) {
        for (std::size_t c = 0; c < channels; ++c) {
            left[c] = static_cast<std::uint8_t>(left[c] + in[channels * i + c]);
            rgba[4 * i + c] = left[c];
        }
        rgba[4 * i + 3] = opaqueByte;
    }
}

std::uint16_t half(const std::uint8_t* bytes) {
    return static_cast<std::uint16_t>(bytes[0] | (bytes[1] << 8));
}

void filterHalves(const std::uint8_t* rgba, std::size_t width, std::uint8_t* out) {
    std::uint8_t* low = out;
    std::uint8_t* high = out + channels * width;
    std::uint16_t left[channels] = {0, 0, 0};
    for (std::size_t i = 0; i < width; ++i) {
        for (std::size_t c = 0; c < channels; ++c) {
            const std::uint16_t value = half(rgba + 8 * i + 2 * c);
            const auto difference = static_cast<std::uint16_t>(value - left[c]);
            left[c] = value;
            *low++ = static_cast<std::uint8_t>(difference);
            *high++ = static_cast<std::uint8_t>(difference >> 8);
        }
    }
}

void unfilterHalves(const std::uint8_t* in, std::size_t width, std::uint8_t* rgba) {
    const std::uint8_t* low = in;
    const std::uint8_t* high = in + channels * width;
    std::uint16_t left[channels] = {0, 0, 0};
    for (std::size_t i = 0; i < width; ++i) {
        for (std::size_t c = 0; c < channels; ++c) {
            left[c] = static_cast<std::uint16_t>(left[c] + (*low++ | (*high++ << 8)));
            rgba[8 * i + 2 * c] = static_cast<std::uint8_t>(left[c]);
            rgba[8 * i + 2 * c + 1] = static_cast<std::uint8_t>(left[c] >> 8);
        }
        rgba[8 * i + 6] = opaqueHalf[0];
        rgba[8 * i + 7] = opaqueHalf[1];
    }
}

/// The number of rows, once it is sure that both sides hold the same whole ones.
std::size_t rowCount(proto::PixelFormat format, std::uint32_t width, std::size_t rgba, std::size_t filtered) {
    MOTE_CHECK(pixelSize(format) != 0 && width != 0);
    const std::size_t rows = rgba / (pixelSize(format) * width);
    MOTE_CHECK(rgba == rows * pixelSize(format) * width);
    MOTE_CHECK(filtered == rows * filteredPixelSize(format) * width);
    return rows;
}

}  // namespace

std::size_t pixelSize(proto::PixelFormat format) {
    return format == proto::SRGB8 ? 4 : format == proto::LINEAR_HALF ? 8 : 0;
}

std::size_t filteredPixelSize(proto::PixelFormat format) {
    return format == proto::SRGB8 ? 3 : format == proto::LINEAR_HALF ? 6 : 0;
}

void filterRows(proto::PixelFormat format, std::uint32_t width, std::span<const std::uint8_t> rgba,
                std::span<std::uint8_t> filtered) {
    const std::size_t rows = rowCount(format, width, rgba.size(), filtered.size());
    const auto filter = format == proto::SRGB8 ? filterBytes : filterHalves;
    for (std::size_t row = 0; row < rows; ++row) {
        filter(rgba.data() + row * width * pixelSize(format), width,
               filtered.data() + row * width * filteredPixelSize(format));
    }
}

void unfilterRows(proto::PixelFormat format, std::uint32_t width, std::span<const std::uint8_t> filtered,
                  std::span<std::uint8_t> rgba) {
    const std::size_t rows = rowCount(format, width, rgba.size(), filtered.size());
    const auto unfilter = format == proto::SRGB8 ? unfilterBytes : unfilterHalves;
    for (std::size_t row = 0; row < rows; ++row) {
        unfilter(filtered.data() + row * width * filteredPixelSize(format), width,
                 rgba.data() + row * width * pixelSize(format));
    }
}

}  // namespace mote::wire
