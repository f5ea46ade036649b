// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidualReader: an OpenVDB file of just the form that residual_encoder.h makes, read front to back without
// OpenVDB, which takes the memory that a file's bytes ask for. Here it is what was promised besides: the
// places of the bricks, of which every node of the tree must have one. One owner, one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <streambuf>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// What a residual must be, from a manifest that was checked.
struct ResidualPromise {
    GridSize size{};  ///< of the error grid
    std::uint64_t bricks = 0, samples = 0;
};

class ResidualReader {
  public:
    /// A brick's index along x, y, z and its values as they lie in the file, which has z fastest; 0 if
    /// there is no sample. Ends if it returns false.
    using Visit = std::function<bool(const GridSize&, std::span<const float, residualBrickSamples>)>;
    using Cancelled = std::function<bool()>;

    /// `bytes` outlives this; `where` names them in errors.
    ResidualReader(std::streambuf& bytes, const ResidualPromise& promise, std::string where)
        : bytes_(bytes), promise_(promise), where_(std::move(where)) {}

    /// All bricks, in the file's order. `cancelled` is asked at every node of the tree. Errors: corrupt
    /// (another form, or other counts than promised; some bricks may have been visited by then), cancelled.
    Status read(const Visit& visit, const Cancelled& cancelled);

  private:
    Error damaged(std::string message) const;
    Status take(std::span<std::byte> bytes);
    template <class T>
    Status take(T& value);
    Status skip(std::uint64_t count);
    Status takeText(std::string& text);

    Status readHead();
    Status readMetadata();
    Status readTransform();
    Status readTree(const Cancelled& cancelled);
    Status readTop(const Cancelled& cancelled);
    Status readNode(const GridSize& origin, const Cancelled& cancelled);
    template <std::size_t Words>
    Status readNodeMasks(std::span<std::uint64_t, Words> children);
    Status readValues(const Visit& visit);
    Status readBrick(const GridSize& brick, std::span<float, residualBrickSamples> values);

    std::streambuf& bytes_;
    ResidualPromise promise_;
    std::string where_;
    std::uint64_t at_ = 0;  // bytes taken so far
    std::uint64_t valuesAt_ = 0, endAt_ = 0;
    bool halves_ = false;
    std::uint64_t samples_ = 0;
    std::vector<GridSize> bricks_;
    std::int64_t lastTop_ = -1;  // its number among all, ascending
};

}  // namespace mote::storage
