// SPDX-License-Identifier: GPL-3.0-or-later
//
// A residual of which bytes were changed or cut off, its hash made to fit: whatever comes of it is an error
// or as many bricks as the manifest promised, never a death and never more memory.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <fstream>
#include <iterator>
#include <sstream>

#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/hash.h"
#include "storage/hybrid/residual_file.h"
#include "storage/hybrid/residual_reader.h"
#include "storage/manifest.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::test {
namespace {

using storage::GridSize;
using testing::HasSubstr;

constexpr std::uint64_t promisedBricks = 2, promisedSamples = 3;

/// Eight other values of a byte.
std::array<char, 8> otherBytes(char byte) {
    const auto b = static_cast<unsigned char>(byte);
    std::array<char, 8> others;
    for (unsigned bit = 0; bit < 8; ++bit) others[bit] = static_cast<char>(b ^ (1U << bit));
    return others;
}

class ResidualBytes : public testing::Test {
  protected:
    ResidualBytes() {
        writeSmallHybrid(dataset_, smallPoints(5), smallManifest(5, 8));
        std::ifstream file(path_, std::ios::binary);
        bytes_.assign(std::istreambuf_iterator<char>(file), {});
    }

    /// Reads them as a residual that is promised to be the small one.
    static Status read(const std::string& bytes, const std::function<bool()>& cancelled = {}) {
        std::stringbuf source(bytes, std::ios::in);
        storage::ResidualReader reader(source, {smallErrorGrid, promisedBricks, promisedSamples}, "residual");
        std::uint64_t bricks = 0;
        auto status = reader.read(
            [&](const GridSize& brick, std::span<const float, storage::residualBrickSamples>) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    EXPECT_LT(brick[axis] * storage::residualBrickSide, smallErrorGrid[axis]);
                return ++bricks <= promisedBricks;
            },
            cancelled);
        EXPECT_LE(bricks, promisedBricks);
        EXPECT_TRUE(status.ok() || !status.error().message.empty());
        return status;
    }

    TempDir dir_;
    const std::filesystem::path dataset_ = dir_ / "a.mote";
    const std::filesystem::path path_ = dataset_ / storage::residualName(0);
    std::string bytes_;
};

TEST_F(ResidualBytes, EachByteChanged) {
    ASSERT_TRUE(read(bytes_).ok());
    std::size_t errors = 0, grids = 0, childless = 0;
    for (std::size_t at = 0; at < bytes_.size(); ++at) {
        auto changed = bytes_;
        for (const char other : otherBytes(bytes_[at])) {
            changed[at] = other;
            const auto status = read(changed);
            ++(status.ok() ? grids : errors);
            childless += !status.ok() && status.error().message == "holds a node without samples" ? 1 : 0;
        }
    }
    EXPECT_GT(childless, 0U);
    EXPECT_GT(errors, grids);  // the masks of nodes are most of it
    fmt::print("{} bytes changed in 8 ways: {} errors, {} grids, 0 deaths\n", bytes_.size(), errors, grids);
}

TEST_F(ResidualBytes, CutOffAnywhereItIsAnError) {
    for (std::size_t size = 0; size < bytes_.size(); ++size)
        EXPECT_FALSE(read(bytes_.substr(0, size)).ok()) << size;
    EXPECT_FALSE(read(bytes_ + '\0').ok());
}

TEST_F(ResidualBytes, CountsAtTheirLimitsTakeNoMemory) {
    for (std::size_t at = 0; at + sizeof(std::uint32_t) <= bytes_.size(); ++at) {
        auto changed = bytes_;
        changed.replace(at, sizeof(std::uint32_t), sizeof(std::uint32_t), '\xff');
        EXPECT_NO_THROW(static_cast<void>(read(changed)));
    }
}

TEST_F(ResidualBytes, TheTreeAsksWhetherItIsCancelled) {
    const auto status = read(bytes_, [] { return true; });
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, ErrorCode::cancelled);
}

TEST_F(ResidualBytes, WithItsHashMadeAnewItLoadsOrSaysWhyNot) {
    auto manifest = *storage::readManifest(dataset_);
    Random random(1, 4);
    std::size_t errors = 0, grids = 0;
    for (int round = 0; round < 400; ++round) {
        auto changed = bytes_;
        const auto at = random.below(changed.size());
        changed[at] = otherBytes(changed[at])[random.below(8)];
        if (random.chance(0.1)) changed.resize(at);
        std::ofstream(path_, std::ios::binary | std::ios::trunc) << changed;
        for (auto& file : *manifest.mutable_files()) {
            if (file.name() != storage::residualName(0)) continue;
            file.set_size(changed.size());
            file.set_xxh3_128(storage::hash128(std::as_bytes(std::span(changed))));
        }
        const auto loaded = render::loadHybrid(dataset_, manifest, 0, HybridRepresentation::residual);
        ++(loaded.ok() ? grids : errors);
        if (!loaded.ok()) {
            EXPECT_THAT(loaded.error().where, HasSubstr(storage::residualName(0)));
        }
    }
    EXPECT_GT(errors, 0U);
    fmt::print("400 forged: {} errors, {} grids, 0 deaths\n", errors, grids);
}

}  // namespace
}  // namespace mote::test
