// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/golden_files.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace mote::test {

void keep(const Image& image, const std::string& name) {
    const auto path = std::filesystem::path(MOTE_GOLDEN_FOLDER) / (name + ".png");
    const auto status = writePng(image, path);
    EXPECT_TRUE(status.ok()) << status.error().toString();
}

bool keepAll() {
    return std::getenv("MOTE_GOLDEN_KEEP") != nullptr;
}

}  // namespace mote::test
