// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenVDB's files, and FloatGrid: a grid for them, made here. A file is written so that a full disk
// is an error and the same grid gives the same bytes. OpenVDB's trees take longer to compile than anything
// else of storage; they are compiled behind this header, once. A grid is a handle that its copies share; one
// thread.
#pragma once

#include <openvdb/version.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/hybrid/hybrid_limits.h"

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
class GridBase;
}
}  // namespace openvdb

namespace mote::storage {

/// Samples a side of a leaf (a brick), and of the two kinds of nodes above it.
inline constexpr int vdbLeafSide = 8, vdbNodeSide = 128, vdbTopSide = 4096;

/// What writes the contents of a grid whose tree is not in memory, in the order of OpenVDB's own trees.
struct TreeWriters {
    std::function<void(std::ostream&)> topology, values;
};

class FloatGrid {
  public:
    /// A grid without samples, 0 everywhere, or one of which `tree` writes what is in it. The transform is
    /// from indices to the world.
    FloatGrid(const std::string& name, const glm::dmat4& indexToWorld, TreeWriters tree = {});
    /// Metadata.
    void note(const std::string& name, const std::string& text) const;
    void note(const std::string& name, std::int32_t number) const;
    void note(const std::string& name, double number) const;
    /// What OpenVDB says of grids that it writes: the box of the samples (the last included) and their count.
    using Indices = std::array<int, 3>;
    void noteSamples(const Indices& first, const Indices& last, std::int64_t count) const;
    /// The same, counted.
    void noteSamples() const;
    void setFog() const;
    void setHalves(bool halves) const;

    /// Fills a box from (0, 0, 0) on, x fastest: all values become samples, or those that are not 0.
    void fill(const GridSize& size, const std::function<float(std::size_t)>& value) const;
    void fillNonzero(const GridSize& size, std::span<const float> values) const;

    /// Samples at these places, which become some.
    using SetSample = std::function<void(const Indices&, float)>;
    SetSample setter() const;

    /// What of a file is the grid's alone.
    const std::shared_ptr<openvdb::GridBase>& base() const { return base_; }
    void writeTopology(std::ostream& out) const;
    void writeValues(std::ostream& out) const;

  private:
    std::shared_ptr<openvdb::GridBase> base_;
    TreeWriters tree_;
};

/// How the values of active samples are written: zip brick by brick, or as they are, for a file that is
/// packed as a whole.
enum class VdbValues { zip, plain };

/// The same as OpenVDB says it.
std::uint32_t vdbCompression(VdbValues values);

/// Writes `path`, which is replaced, with an identity made from the bytes, where OpenVDB takes a random one.
/// Grids have names of their own; their statistics (noteSamples) are the caller's to add. The file is
/// not synced. Errors: resourceExhausted (it cannot be written whole), internal (OpenVDB's own), those of a
/// StorageError that a grid throws.
Status writeVdbFile(const std::filesystem::path& path, const std::vector<FloatGrid>& grids,
                    VdbValues values = VdbValues::zip);

}  // namespace mote::storage
