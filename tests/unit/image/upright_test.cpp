// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/read_picture.h"

#include <gtest/gtest.h>

namespace mote::test {
namespace {

/// What a viewer shows of the stored rows "abc" / "def" (Exif 2.3, orientation), by letters.
std::string shown(int orientation) {
    const auto turned = prep::upright({3, 2, {'a', 'b', 'c', 'd', 'e', 'f'}}, orientation);
    std::string text;
    for (std::size_t i = 0; i < turned.values.size(); ++i) {
        if (i > 0 && i % turned.width == 0) text += '/';
        text += static_cast<char>(turned.values[i]);
    }
    return text;
}

TEST(Upright, allOrientations) {
    EXPECT_EQ(shown(1), "abc/def");
    EXPECT_EQ(shown(2), "cba/fed");
    EXPECT_EQ(shown(3), "fed/cba");
    EXPECT_EQ(shown(4), "def/abc");
    EXPECT_EQ(shown(5), "ad/be/cf");
    EXPECT_EQ(shown(6), "da/eb/fc");  // turned a quarter clockwise
    EXPECT_EQ(shown(7), "fc/eb/da");
    EXPECT_EQ(shown(8), "cf/be/ad");
    EXPECT_EQ(shown(0), "abc/def");
    EXPECT_EQ(shown(9), "abc/def");
}

}  // namespace
}  // namespace mote::test
