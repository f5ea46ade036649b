// SPDX-License-Identifier: GPL-3.0-or-later
//
// A hybrid dataset of a few samples, made by hand: 4 x 3 x 2 low, 70 x 40 x 33 on the error grid, five points
// and two residual bricks.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "protocol/mote.pb.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_encoder.h"

namespace mote::test {

/// Owns what a HybridPoints shows.
struct SmallPoints {
    std::vector<std::uint64_t> brickBegin;
    std::vector<std::uint16_t> advance;
    std::vector<std::uint8_t> place8;
    std::vector<std::uint16_t> place16;
    std::vector<std::uint8_t> value, error, normal;

    storage::HybridPoints view() const;
};

inline constexpr storage::GridSize smallErrorGrid{70, 40, 33};

/// The same points in the form of 5, 6 or 9 bytes.
SmallPoints smallPoints(int bytes);

/// The manifest, but for the files, of one step.
proto::Manifest smallManifest(int pointBytes, int valueBits);

/// Makes a residual's file of these bricks, by their indices.
void writeBricks(const std::vector<std::pair<storage::GridSize, std::array<std::int32_t, 512>>>& bricks,
                 const storage::ResidualCoding& coding, const std::filesystem::path& path);

/// Publishes `directory`, changed as `change` says.
void writeSmallHybrid(const std::filesystem::path& directory, const SmallPoints& points,
                      const proto::Manifest& manifest);

}  // namespace mote::test
