// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/row_filter.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace mote::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(RowFilter, BytesLieAsDocumented) {
    const Bytes rgba{10,  20, 30, 255, 13,  18,  30, 255,  //
                     200, 0,  1,  255, 100, 255, 3,  255};
    Bytes filtered(12);
    filterRows(proto::SRGB8, 2, rgba, filtered);
    EXPECT_EQ(filtered, (Bytes{10, 20, 30, 3, 254, 0, 200, 0, 1, 156, 255, 2}));
}

TEST(RowFilter, HalvesLieAsDocumented) {
    const Bytes rgba{0x01, 0x3c, 0x00, 0x40, 0xff, 0x00, 0x00, 0x3c,  //
                     0x00, 0x3c, 0x10, 0x40, 0x00, 0x02, 0x00, 0x3c};
    Bytes filtered(12);
    filterRows(proto::LINEAR_HALF, 2, rgba, filtered);
    // Differences: 3c01 4000 00ff, then ffff 0010 0101; low bytes first.
    EXPECT_EQ(filtered, (Bytes{0x01, 0x00, 0xff, 0xff, 0x10, 0x01, 0x3c, 0x40, 0x00, 0xff, 0x00, 0x01}));
}

TEST(RowFilter, EveryPictureComesBack) {
    std::mt19937 random(11);
    for (const auto format : {proto::SRGB8, proto::LINEAR_HALF}) {
        const std::size_t size = pixelSize(format);
        for (const std::uint32_t width : {1u, 2u, 15u, 16u, 17u, 101u}) {
            Bytes rgba(size * width * 5);
            for (auto& byte : rgba) byte = static_cast<std::uint8_t>(random());
            for (std::size_t pixel = 0; pixel < rgba.size(); pixel += size) {
                if (format == proto::SRGB8) {
                    rgba[pixel + 3] = 255;
                } else {
                    rgba[pixel + 6] = 0x00;
                    rgba[pixel + 7] = 0x3c;
                }
            }
            Bytes filtered(filteredPixelSize(format) * width * 5);
            Bytes again(rgba.size());
            filterRows(format, width, rgba, filtered);
            unfilterRows(format, width, filtered, again);
            EXPECT_EQ(again, rgba) << width;
        }
    }
}

TEST(RowFilter, AnUnknownFormatHasNoSize) {
    const auto unknown = static_cast<proto::PixelFormat>(99);
    EXPECT_EQ(pixelSize(unknown), 0u);
    EXPECT_EQ(filteredPixelSize(unknown), 0u);
    EXPECT_EQ(pixelSize(proto::PIXEL_FORMAT_UNSPECIFIED), 0u);
}

}  // namespace
}  // namespace mote::wire
