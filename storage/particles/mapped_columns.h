// SPDX-License-Identifier: GPL-3.0-or-later
//
// MappedColumns: the ParticleColumns that lie in a mapped file. Made by ParticleColumns::open; verify() also
// looks at what nobody has asked for yet.
//
// The arrays of a columns file, for reader and writer: /columns/NAME, f32 or f64, for each of the manifest's
// columns; with ids also /columns/id, u64, and /ids/point, u32. docs/FORMAT.md.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "storage/arrays/hdf5_layout.h"
#include "storage/blocks/mapped_file.h"
#include "storage/blocks/verified_array.h"
#include "storage/particles/particle_columns.h"

namespace mote::storage {

/// "columns-000012".
std::string columnsName(std::uint32_t step);

/// How a columns file of so many points is laid out.
FileLayout columnsLayout(const std::vector<ColumnInfo>& columns, bool ids, std::uint64_t points);

/// Returns the entry of a step. Errors: invalidArgument (a dataset of another kind), notFound.
Result<const proto::ParticleStepEntry*> stepEntry(const PathBeneath& directory,
                                                  const proto::Manifest& manifest, std::uint32_t step);

class MappedColumns final : public ParticleColumns {
  public:
    /// As ParticleColumns::open.
    static Result<std::shared_ptr<const MappedColumns>> open(const PathBeneath& directory,
                                                             const proto::Manifest& manifest,
                                                             std::uint32_t step,
                                                             std::shared_ptr<BlockBudget> budget = nullptr);
    ~MappedColumns() override;

    std::uint64_t pointCount() const override { return points_; }
    const std::vector<ColumnInfo>& columns() const override { return columns_; }
    std::span<const float> values(std::size_t column, std::uint64_t begin,
                                  std::uint64_t count) const override;
    std::span<const double> doubles(std::size_t column, std::uint64_t begin,
                                    std::uint64_t count) const override;
    bool hasIds() const override { return ids_; }
    std::span<const std::uint64_t> ids(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const std::uint32_t> pointsById(std::uint64_t begin, std::uint64_t count) const override;
    void check() const override;

    /// Hashes every block, and holds the index to the ids: what is wrong, nothing if all is well. Stops
    /// early, with a `cancelled` error, if `cancelled` says so.
    std::vector<Error> verify(const std::function<bool()>& cancelled) const;

  private:
    MappedColumns(MappedFile file, std::shared_ptr<BlockBudget> budget)
        : file_(std::move(file)), budget_(std::move(budget)) {}
    Status readArrays(const proto::Digest& digest);
    void chooseTypes(const proto::Digest& digest, const proto::ParticlesManifest& particles);
    std::optional<Error> checkIndex(const std::function<bool()>& cancelled) const;

    MappedFile file_;
    const std::shared_ptr<BlockBudget> budget_;  ///< may be null
    std::uint64_t points_ = 0;
    bool ids_ = false;
    std::vector<ColumnInfo> columns_;
    std::vector<VerifiedArray> arrays_;  ///< by column, then the ids and their index
};

}  // namespace mote::storage
