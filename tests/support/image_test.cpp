// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/image.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

TEST(Image, ComesBackFromItsFile) {
    const TempDir folder;
    Image image{3, 2, {}};
    // Alpha other than 255 as well: pixels must come back as they were, not multiplied by it.
    for (int i = 0; i < 24; ++i) image.pixels.push_back(static_cast<std::uint8_t>(10 * i + 3));
    const auto path = folder / "deeper/image.png";
    const auto status = writePng(image, path);
    ASSERT_TRUE(status.ok()) << status.error().toString();
    const auto again = readPng(path);
    ASSERT_TRUE(again.ok()) << again.error().toString();
    EXPECT_EQ(*again, image);
}

TEST(Image, WhatIsNoPictureIsAnError) {
    const TempDir folder;
    EXPECT_EQ(readPng(folder / "absent.png").error().code, ErrorCode::notFound);
    std::ofstream(folder / "text.png") << "no picture";
    EXPECT_FALSE(readPng(folder / "text.png").ok());
}

}  // namespace
}  // namespace mote::test
