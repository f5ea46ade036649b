// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hybrid datasets that are not what they say: whoever wants to see one is told what is wrong with it, and the
// server goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"
#include "tests/e2e/station.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

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
