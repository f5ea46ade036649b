// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_files.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

TEST(ViewFiles, ANameThatIsOfferedIsFree) {
    const test::TempDir folder;
    const auto usual = folder / "view.json";
    EXPECT_EQ(freshPath(usual), usual);
    std::ofstream(usual) << "{}";
    EXPECT_EQ(freshPath(usual), folder / "view-2.json");
    std::filesystem::create_symlink("nowhere", folder / "view-2.json");
    EXPECT_EQ(freshPath(usual), folder / "view-3.json");
}

}  // namespace
}  // namespace mote::client
