// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/temp_dir.h"

namespace mote::prep {
namespace {

std::string contentOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(Phantom, HoldsAirAndBonesAndDependsOnItsSeedAlone) {
    const test::TempDir folder;
    for (const auto* const name : {"one", "same"})
        ASSERT_TRUE(writePhantom(32, 7, folder.path() / name).ok());
    ASSERT_TRUE(writePhantom(32, 8, folder.path() / "other").ok());
    const std::string one = contentOf(folder.path() / "one");
    EXPECT_TRUE(one == contentOf(folder.path() / "same"));
    EXPECT_FALSE(one == contentOf(folder.path() / "other"));
    const auto begin = one.find("\n\n") + 2;
    ASSERT_EQ(one.size() - begin, 2U * 32 * 32 * 32);
    std::vector<std::int16_t> units(32 * 32 * 32);
    std::memcpy(units.data(), one.data() + begin, 2 * units.size());
    const auto [least, most] = std::minmax_element(units.begin(), units.end());
    EXPECT_LT(*least, -950);
    EXPECT_GT(*most, 400);
    EXPECT_FALSE(writePhantom(32, 7, folder.path() / "one").ok()) << "what is there is not replaced";
}

TEST(Coil, IsClosed) {
    const test::TempDir folder;
    ASSERT_TRUE(writeCoil(folder.path() / "coil.obj").ok());
    std::ifstream file(folder.path() / "coil.obj");
    std::map<std::pair<int, int>, int> edges;
    int vertices = 0;
    for (std::string line; std::getline(file, line);) {
        vertices += line.starts_with("v ") ? 1 : 0;
        if (!line.starts_with("f ")) continue;
        std::istringstream words(line.substr(2));
        std::vector<int> corners;
        for (int corner = 0; words >> corner;) corners.push_back(corner);
        for (std::size_t i = 0; i < corners.size(); ++i)
            ++edges[{corners[i], corners[(i + 1) % corners.size()]}];
    }
    ASSERT_GT(edges.size(), 1000U);
    for (const auto& [edge, count] : edges) {
        ASSERT_LE(std::max(edge.first, edge.second), vertices);
        ASSERT_EQ(count, 1);
        ASSERT_TRUE(edges.contains({edge.second, edge.first})) << edge.first << " to " << edge.second;
    }
}

}  // namespace
}  // namespace mote::prep
