// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/temp_dir.h"

#include <gtest/gtest.h>

#include <fstream>

namespace mote::test {
namespace {

TEST(TempDir, IsFreshAndGoesWithAllThatIsInIt) {
    std::filesystem::path path;
    {
        const TempDir one;
        const TempDir other;
        path = one.path();
        EXPECT_NE(one.path(), other.path());
        EXPECT_TRUE(std::filesystem::is_empty(path));
        std::filesystem::create_directories(one / "a/b");
        std::ofstream(one / "a/b/c") << "x";
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace mote::test
