// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/mapped_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "storage/arrays/array_file.h"
#include "storage/blocks/block_budget.h"
#include "storage/manifest.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t checkedAtOnce = std::uint64_t{1} << 16;  // of the index, between two questions

Error withoutColumns(const PathBeneath& directory) {
    return {ErrorCode::notFound, directory.string(),
            "was made without columns, so there are no numbers beside its points; making it again with "
            "mote-prep particles keeps them"};
}

/// A column may be an expression: what parts groups in HDF5 is written as in addresses.
std::string columnArray(const ColumnInfo& column) {
    std::string name = "/columns/";
    for (const char c : column.name) {
        if (c == '/')
            name += "%2F";
        else if (c == '%')
            name += "%25";
        else
            name += c;
    }
    return name;
}

std::vector<ColumnInfo> columnsOf(const proto::ParticlesManifest& particles,
                                  const proto::ParticleStepEntry& entry) {
    std::vector<ColumnInfo> columns;
    for (int i = 0; i < particles.columns_size(); ++i) {
        ColumnInfo info{particles.columns(i).name(), particles.columns(i).unit(), entry.column_offset(i)};
        if (i < entry.column_resolution_size()) info.resolution = entry.column_resolution(i);
        columns.push_back(std::move(info));
    }
    return columns;
}

}  // namespace

std::string columnsName(std::uint32_t step) {
    return fmt::format("columns-{:06}", step);
}

FileLayout columnsLayout(const std::vector<ColumnInfo>& columns, bool ids, std::uint64_t points) {
    FileLayout layout;
    layout.groups = {"/columns"};
    if (ids) layout.groups.push_back("/ids");
    std::vector<double> offsets;
    for (const auto& column : columns) {
        layout.arrays.push_back({columnArray(column), column.doubles ? "f64" : "f32", {points}});
        offsets.push_back(column.offset);
    }
    if (ids) {
        layout.arrays.push_back({"/columns/id", "u64", {points}});
        layout.arrays.push_back({"/ids/point", "u32", {points}});
    }
    if (!offsets.empty()) layout.attributes.push_back({"offset", std::move(offsets)});
    return layout;
}

Result<const proto::ParticleStepEntry*> stepEntry(const PathBeneath& directory,
                                                  const proto::Manifest& manifest, std::uint32_t step) {
    if (!manifest.has_particles()) {
        return invalid(directory.string(),
                       fmt::format("is a dataset of kind \"{}\", not a particle plot", manifest.kind()));
    }
    const auto& steps = manifest.particles().steps();
    if (step < static_cast<std::uint32_t>(steps.size())) return &steps[static_cast<int>(step)];
    return notFound(directory.string(),
                    fmt::format("has {} steps, so none with index {}", steps.size(), step));
}

Result<std::shared_ptr<const ParticleColumns>> ParticleColumns::open(const PathBeneath& directory,
                                                                     const proto::Manifest& manifest,
                                                                     std::uint32_t step,
                                                                     std::shared_ptr<BlockBudget> budget) {
    MOTE_RETURN_IF_ERROR(checkManifest(manifest), (directory / manifestName).string() + ":");
    MOTE_ASSIGN_OR_RETURN(auto opened, MappedColumns::open(directory, manifest, step, std::move(budget)));
    return std::shared_ptr<const ParticleColumns>(std::move(opened));
}

Result<std::shared_ptr<const MappedColumns>> MappedColumns::open(const PathBeneath& directory,
                                                                 const proto::Manifest& manifest,
                                                                 std::uint32_t step,
                                                                 std::shared_ptr<BlockBudget> budget) {
    MOTE_ASSIGN_OR_RETURN(const auto* const found, stepEntry(directory, manifest, step));
    const auto& entry = *found;
    const auto& particles = manifest.particles();
    if (entry.columns_file().empty()) return withoutColumns(directory);
    MOTE_ASSIGN_OR_RETURN(const auto digest, readDigest(directory / entry.columns_digest(),
                                                        *findFile(manifest, entry.columns_digest())));
    const auto& described = *findFile(manifest, entry.columns_file());
    MOTE_ASSIGN_OR_RETURN(auto file, MappedFile::open(directory / entry.columns_file(), described.size()));
    const std::shared_ptr<MappedColumns> mapped(new MappedColumns(std::move(file), std::move(budget)));
    mapped->points_ = entry.particles();
    mapped->ids_ = particles.ids();
    mapped->columns_ = columnsOf(particles, entry);
    mapped->chooseTypes(digest, particles);
    MOTE_RETURN_IF_ERROR(mapped->readArrays(digest));
    if (mapped->budget_) {
        for (const auto& one : mapped->arrays_) mapped->budget_->enter(one);
    }
    return std::shared_ptr<const MappedColumns>(mapped);
}

MappedColumns::~MappedColumns() {
    if (!budget_) return;
    for (const auto& one : arrays_) budget_->leave(one);
}

/// A column that the manifest calls f64 is so in the steps that need it.
void MappedColumns::chooseTypes(const proto::Digest& digest, const proto::ParticlesManifest& particles) {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        if (particles.columns(static_cast<int>(i)).type() != "f64") continue;
        const auto found =
            std::ranges::find(digest.arrays(), columnArray(columns_[i]), &proto::DigestArray::name);
        columns_[i].doubles = found != digest.arrays().end() && found->type() == "f64";
    }
}

Status MappedColumns::readArrays(const proto::Digest& digest) {
    for (const auto& wanted : columnsLayout(columns_, ids_, points_).arrays) {
        const auto found = std::ranges::find(digest.arrays(), wanted.name, &proto::DigestArray::name);
        const auto where = file_.path() + ":" + wanted.name;
        if (found == digest.arrays().end())
            return Error{ErrorCode::corrupt, where, "is missing in the digest"};
        if (found->type() != wanted.type) return Error{ErrorCode::corrupt, where, "has the wrong type"};
        MOTE_ASSIGN_OR_RETURN(auto made, VerifiedArray::make(file_, *found, budget_.get()));
        if (made.shape() != wanted.shape) {
            return Error{ErrorCode::corrupt, where,
                         fmt::format("has the shape [{}], not [{}]", fmt::join(made.shape(), ", "), points_)};
        }
        arrays_.push_back(std::move(made));
    }
    return success();
}

std::span<const float> MappedColumns::values(std::size_t column, std::uint64_t begin,
                                             std::uint64_t count) const {
    MOTE_CHECK(column < columns_.size() && begin <= points_ && count <= points_ - begin);
    MOTE_CHECK(!columns_[column].doubles);
    return arrays_[column].get<float>(begin, count);
}

std::span<const double> MappedColumns::doubles(std::size_t column, std::uint64_t begin,
                                               std::uint64_t count) const {
    MOTE_CHECK(column < columns_.size() && begin <= points_ && count <= points_ - begin);
    MOTE_CHECK(columns_[column].doubles);
    return arrays_[column].get<double>(begin, count);
}

std::span<const std::uint64_t> MappedColumns::ids(std::uint64_t begin, std::uint64_t count) const {
    MOTE_CHECK(ids_ && begin <= points_ && count <= points_ - begin);
    return arrays_[columns_.size()].get<std::uint64_t>(begin, count);
}

std::span<const std::uint32_t> MappedColumns::pointsById(std::uint64_t begin, std::uint64_t count) const {
    MOTE_CHECK(ids_ && begin <= points_ && count <= points_ - begin);
    return arrays_[columns_.size() + 1].get<std::uint32_t>(begin, count);
}

void MappedColumns::check() const {
    if (const auto damage = file_.damage()) throw StorageError(*damage);
}

std::vector<Error> MappedColumns::verify(const std::function<bool()>& cancelled) const {
    std::vector<Error> errors;
    for (const auto& one : arrays_) {
        for (std::size_t block = 0; block < one.blockCount(); ++block) {
            if (cancelled && cancelled()) return {Error{ErrorCode::cancelled, file_.path(), "cancelled"}};
            if (auto error = one.checkBlock(block)) errors.push_back(*std::move(error));
        }
    }
    if (!errors.empty() || !ids_) return errors;
    try {
        if (auto error = checkIndex(cancelled)) errors.push_back(*std::move(error));
    } catch (const StorageError& error) {
        errors.push_back(error.error());
    }
    return errors;
}

/// Ascending pairs of id and point, each a point of the step, are a permutation of all points.
std::optional<Error> MappedColumns::checkIndex(const std::function<bool()>& cancelled) const {
    std::optional<std::pair<std::uint64_t, std::uint64_t>> before;
    for (std::uint64_t begin = 0; begin < points_; begin += checkedAtOnce) {
        if (cancelled && cancelled()) return Error{ErrorCode::cancelled, file_.path(), "cancelled"};
        for (const std::uint64_t point : pointsById(begin, std::min(checkedAtOnce, points_ - begin))) {
            const bool inside = point < points_;
            const std::pair next(inside ? ids(point, 1)[0] : 0, point);
            if (!inside || (before && !(*before < next))) {
                return Error{ErrorCode::corrupt, file_.path() + ":/ids/point",
                             "does not name the points by ascending id"};
            }
            before = next;
        }
    }
    return std::nullopt;
}

}  // namespace mote::storage
