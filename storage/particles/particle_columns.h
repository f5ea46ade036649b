// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleColumns: what lies beside the points of one step of a particle plot: the source's columns, in the
// order of the points, so that a leaf's range of points is a range of each column. Immutable and safe to use
// from any number of threads; shared by all who ask for numbers of the step. Layout: docs/FORMAT.md.
//
// A value is offset + what the file holds, a float: the offset lies near the middle of the step's points.
// If the steps of floats would be too coarse for them, the file holds the values themselves, doubles.
// Every accessor verifies the MiB blocks that it returns, at their first use, and throws StorageError
// (corrupt, naming file, array and offset) if they differ from the digest. With a budget, blocks come and
// go as those of ParticleStep do.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/path_beneath.h"
#include "storage/storage_error.h"

namespace mote::storage {

class BlockBudget;

struct ColumnInfo {
    std::string name;      ///< "x", "px", ..., "weight", or the source's own; never "id"
    std::string unit;      ///< "m", "eV/c", "s", "1", ...
    double offset = 0.0;   ///< in the unit; a value is offset + float; NaN if the source has no finite one
    bool doubles = false;  ///< the file holds the values themselves
    double resolution =
        0.0;  ///< greatest step from a value to the next; 0: finer than asked about, or not known
};

class ParticleColumns {
  public:
    /// `directory` is the dataset; checks the digest's shapes against the manifest. Errors: notFound (the
    /// dataset was made without columns: says how to make them), corrupt.
    static Result<std::shared_ptr<const ParticleColumns>> open(const PathBeneath& directory,
                                                               const proto::Manifest& manifest,
                                                               std::uint32_t step,
                                                               std::shared_ptr<BlockBudget> budget = nullptr);
    virtual ~ParticleColumns() = default;

    virtual std::uint64_t pointCount() const = 0;
    virtual const std::vector<ColumnInfo>& columns() const = 0;
    /// Points [begin, begin + count) of a column of floats, in the order of ParticleStep's points.
    virtual std::span<const float> values(std::size_t column, std::uint64_t begin,
                                          std::uint64_t count) const = 0;

    /// The same of a column of doubles, which are the values.
    virtual std::span<const double> doubles(std::size_t, std::uint64_t, std::uint64_t) const { return {}; }
    /// Values of points [begin, begin + out.size()) of any column.
    void read(std::size_t column, std::uint64_t begin, std::span<double> out) const {
        const auto& info = columns()[column];
        if (info.doubles) {
            std::ranges::copy(doubles(column, begin, out.size()), out.begin());
            return;
        }
        const auto stored = values(column, begin, out.size());
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = info.offset + static_cast<double>(stored[i]);
    }
    double value(std::size_t column, std::uint64_t point) const {
        double one = 0.0;
        read(column, point, {&one, 1});
        return one;
    }

    virtual bool hasIds() const = 0;
    /// The ids of points [begin, begin + count); only if there are ids.
    virtual std::span<const std::uint64_t> ids(std::uint64_t begin, std::uint64_t count) const = 0;
    /// Ranks [begin, begin + count) of the id index: points by ascending id, of equal ids by ascending point.
    /// The numbers are the file's: whoever goes by one reads it by pointOfRank().
    virtual std::span<const std::uint32_t> pointsById(std::uint64_t begin, std::uint64_t count) const = 0;
    /// The point of a rank, which is one of the step's. Throws StorageError (corrupt).
    std::uint32_t pointOfRank(std::uint64_t rank) const {
        const std::uint32_t point = pointsById(rank, 1)[0];
        if (point < pointCount()) return point;
        throw StorageError(Error{ErrorCode::corrupt, "/ids/point", "names a point that is not there"});
    }

    /// Throws StorageError if what was read may have been something else (the file changed).
    virtual void check() const {}

    /// The index of a column in columns().
    std::optional<std::size_t> find(std::string_view name) const {
        for (std::size_t i = 0; i < columns().size(); ++i) {
            if (columns()[i].name == name) return i;
        }
        return std::nullopt;
    }
};

}  // namespace mote::storage
