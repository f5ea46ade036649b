// SPDX-License-Identifier: GPL-3.0-or-later
//
// A hybrid volume from its dataset to picture files: each representation, and what is wrong in a script.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <fstream>

#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"
#include "tests/e2e/station.h"
#include "tests/support/image.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

/// The small volume is 140 x 80 x 66 units large, its values -10 to 245. Without a camera, the view fits it.
std::string smallView(const std::string& style, int step = 0) {
    return "{'width': 200, 'height': 120, 'layers': [{'dataset': 'data/small', 'step': " +
           std::to_string(step) +
           ", 'hybrid': {'curve': [{'value': -10, 'opacity': 0.001}, {'value': 245, 'opacity': 0.9}]" +
           style + "}}]}";
}

class Hybrids : public testing::Test {
  protected:
    void SetUp() override {
        writeSmallHybrid(station_.root() / "small.mote", smallPoints(5), smallManifest(5, 8));
        station_.startServer();
    }
    Image picture(const std::string& name) const { return readPng(station_.out() / name).value(); }

    Station station_;
};

std::size_t litPixels(const Image& image) {
    std::size_t lit = 0;
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) lit += image.pixels[i] > 0 ? 1 : 0;
    return lit;
}

TEST_F(Hybrids, AreDrawnInEachRepresentation) {
    const auto done = station_.frames(
        scriptOf({smallView(""), smallView(", 'representation': 'residual'"),
                  smallView(", 'representation': 'points'"), smallView(", 'representation': 'volume'")}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto best = picture("frame-000000.png"), residual = picture("frame-000001.png");
    const auto points = picture("frame-000002.png"), volume = picture("frame-000003.png");
    // The fitted view is filled to a good part by a box of these proportions.
    EXPECT_GT(litPixels(volume), volume.pixels.size() / 4 / 8);
    EXPECT_EQ(best.pixels, residual.pixels);
    EXPECT_NE(residual.pixels, volume.pixels);
    EXPECT_NE(points.pixels, volume.pixels);
}

TEST_F(Hybrids, BadScriptsAreNamed) {
    const auto bad = [&](const std::string& view) {
        const auto done = station_.frames(scriptOf({view}));
        EXPECT_NE(done.status, 0);
        return done.errors;
    };
    const std::pair<std::string, std::string> wrong[]{
        {"'pointShape': 'star'", "pointShape"},
        {"'representation': 'source'", "representation"},
        {"'colorMap': 'mud'", "colorMap"},
        {"'colorRange': [3, 2]", "colorRange"},
        {"'pointOpacity': 1.5", "pointOpacity"},
        {"'light': {'direction': [0, 0, 0]}", "light.direction"},
        {"'light': {'ambient': -1}", "light.ambient"},
        {"'light': {'shadow': true}", "light.shadow"},
        {"'clipPlanes': [{'normal': [0, 0, 0], 'distance': 1}]", "clipPlanes[0].normal"},
        {"'clipBox': {'min': [0, 0, 0], 'max': [1, 1, 0]}", "clipBox.max[2]"},
        {"'curvature': 1", "curvature"},
    };
    for (const auto& [field, name] : wrong)
        EXPECT_THAT(bad(smallView(", " + field)), HasSubstr("layers[0].hybrid." + name)) << field;
    EXPECT_THAT(bad(smallView("", 3)), HasSubstr("layers[0].step"));
    EXPECT_THAT(bad("{'width': 20, 'height': 20, 'layers': [{'dataset': 'data/small', 'particles': {}}]}"),
                HasSubstr("hybrid"));
}

// Hybrid datasets that are not what they say: whoever wants to see one is told what is wrong with it, and the
// server goes on.

std::string viewOf(const std::string& dataset) {
    return "{'width': 60, 'height': 40, 'layers': [{'dataset': 'data/" + dataset + "', 'hybrid': {}}]}";
}

/// Turns one bit in the middle of a file.
void flip(const std::filesystem::path& file) {
    auto bytes = bytesOf(file);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
}

/// The first `from` after `place`.
void changeManifest(const std::filesystem::path& directory, const std::string& place, const std::string& from,
                    const std::string& to) {
    auto text = bytesOf(directory / "manifest.json");
    const auto at = text.find(from, text.find(place));
    ASSERT_NE(at, std::string::npos);
    text.replace(at, from.size(), to);
    std::ofstream(directory / "manifest.json") << text;
    std::filesystem::remove(directory / storage::manifestDigestName);  // no hash tells
}

class DamagedHybrids : public testing::Test {
  protected:
    std::filesystem::path write(const std::string& name) const {
        const auto directory = station_.root() / (name + ".mote");
        writeSmallHybrid(directory, smallPoints(5), smallManifest(5, 8));
        return directory;
    }
    std::string said(const std::string& dataset) const {
        const auto done = station_.frames(scriptOf({viewOf(dataset)}));
        EXPECT_NE(done.status, 0) << dataset;
        return done.errors;
    }

    Station station_;
};

TEST_F(DamagedHybrids, AreToldApartAndTheServerGoesOn) {
    const auto residual = storage::residualName(0);
    write("whole");
    std::filesystem::remove(write("missing") / residual);
    const auto cut = write("cut") / "step-000000.h5";
    std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
    flip(write("flipped") / residual);
    changeManifest(write("contradicting"), "\"pointBytes\"", "5", "6");
    changeManifest(write("unknown"), "", "pointBytes", "pointBites");
    station_.startServer();

    EXPECT_THAT(said("missing"), HasSubstr(residual));
    EXPECT_THAT(said("cut"), HasSubstr("step-000000.h5"));
    EXPECT_THAT(said("flipped"), AllOf(HasSubstr(residual), HasSubstr("damaged")));
    EXPECT_THAT(said("contradicting"), HasSubstr("step-000000.h5"));
    EXPECT_THAT(said("unknown"), HasSubstr("there is no dataset"));
    const auto done = station_.frames(scriptOf({viewOf("whole")}));
    EXPECT_EQ(done.status, 0) << done.errors;
}

TEST_F(DamagedHybrids, OneThatIsRepairedIsDrawn) {
    const auto file = write("mended") / storage::residualName(0);
    std::filesystem::rename(file, station_.root() / "kept");
    station_.startServer();
    EXPECT_THAT(said("mended"), HasSubstr("residual"));
    std::filesystem::rename(station_.root() / "kept", file);
    const auto done = station_.frames(scriptOf({viewOf("mended")}));
    EXPECT_EQ(done.status, 0) << done.errors;
}

}  // namespace
}  // namespace mote::test
