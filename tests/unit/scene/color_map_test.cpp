// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/color_map.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "protocol/scene/srgb.h"

namespace mote {
namespace {

void expectSrgb(const glm::dvec3& linear, const glm::dvec3& bytes) {
    const glm::dvec3 encoded = 255.0 * linearToSrgb(linear);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(encoded[i], bytes[i], 1e-9) << i;
}

/// The colours of a published table, sRGB-encoded; empty where the file is not there.
std::vector<glm::dvec3> publishedColors(const std::string& file) {
    std::ifstream lines(std::filesystem::path(MOTE_SHARED_DATA) / "colormaps" / file);
    std::vector<glm::dvec3> colors;
    glm::dvec3 color;
    for (std::string line; std::getline(lines, line);) {
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &color.x, &color.y, &color.z) == 3)
            colors.push_back(color);
    }
    return colors;
}

TEST(ColorMap, HasEveryColorOfThePublishedTables) {
    std::size_t compared = 0;
    for (const auto name : ColorMap::names()) {
        auto published = publishedColors(std::string(name) + ".csv");
        if (published.empty()) published = publishedColors("crameri_" + std::string(name) + ".csv");
        const auto map = ColorMap::find(name).value();
        for (std::size_t i = 0; i < published.size(); ++i, ++compared) {
            const double x = static_cast<double>(i) / static_cast<double>(published.size() - 1);
            const glm::dvec3 encoded = linearToSrgb(map(x));
            // Half a step of the 8 bits that the tables have; place and encoding cost some 1e-12.
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(encoded[c], published[i][c], 0.5 / 255.0 + 1e-6) << name << " " << i;
        }
    }
    if (compared == 0) GTEST_SKIP() << "the published tables are not here";
}

TEST(ColorMap, EndsAreThoseOfThePublishedTables) {
    // matplotlib's _cm_listed.py, to 8 bits.
    expectSrgb((*ColorMap::find("viridis"))(0.0), {68, 1, 84});
    expectSrgb((*ColorMap::find("viridis"))(1.0), {253, 231, 37});
    expectSrgb((*ColorMap::find("inferno"))(0.0), {0, 0, 4});
    expectSrgb((*ColorMap::find("plasma"))(0.0), {13, 8, 135});
}

TEST(ColorMap, AllAreKnownByTheirNamesAndDiffer) {
    std::set<std::string_view> names(ColorMap::names().begin(), ColorMap::names().end());
    EXPECT_EQ(names.size(), ColorMap::names().size());
    EXPECT_TRUE(names.contains(ColorMap::defaultName));
    EXPECT_EQ(ColorMap::standard().name(), ColorMap::defaultName);
    std::set<std::array<double, 3>> middles;
    for (const auto name : names) {
        const auto map = ColorMap::find(name);
        ASSERT_TRUE(map.ok());
        EXPECT_EQ(map->name(), name);
        const auto color = (*map)(0.3);
        middles.insert({color.x, color.y, color.z});
    }
    EXPECT_EQ(middles.size(), names.size());
}

TEST(ColorMap, AreContinuousColors) {
    for (const auto name : ColorMap::names()) {
        const auto map = ColorMap::find(name).value();
        glm::dvec3 before = map(0.0);
        for (int i = 1; i <= 5000; ++i) {
            const auto color = map(i / 5000.0);
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(color[c], 0.0);
                EXPECT_LE(color[c], 1.0);
                // No map changes by more than some 10 of 255 from one of 256 entries to the next.
                EXPECT_LT(std::abs(color[c] - before[c]), 0.01) << name << " at " << i / 5000.0;
            }
            before = color;
        }
    }
}

TEST(ColorMap, InterpolatesInLinearLight) {
    const auto map = ColorMap::find("viridis").value();
    const glm::dvec3 a = map(10.0 / 255.0), b = map(11.0 / 255.0), between = map(10.25 / 255.0);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(between[c], 0.75 * a[c] + 0.25 * b[c], 1e-12);
}

TEST(ColorMap, IsConstantBeyondItsEnds) {
    const auto map = ColorMap::standard();
    EXPECT_EQ(map(-3.0), map(0.0));
    EXPECT_EQ(map(7.0), map(1.0));
    EXPECT_EQ(map(std::numeric_limits<double>::infinity()), map(1.0));
}

TEST(ColorMap, AnUnknownNameTellsTheKnownOnes) {
    for (const char* name : {"", "Viridis", "jet", "viridis "}) {
        const auto map = ColorMap::find(name);
        ASSERT_FALSE(map.ok()) << name;
        EXPECT_EQ(map.error().code, ErrorCode::notFound);
        for (const auto known : ColorMap::names()) {
            EXPECT_NE(map.error().message.find(known), std::string::npos) << known;
        }
    }
}

}  // namespace
}  // namespace mote
