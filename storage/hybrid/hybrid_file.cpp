// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/hybrid_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "storage/files/packed_file.h"
#include "storage/hybrid/check_hybrid.h"

namespace mote::storage {
namespace {

std::uint64_t brickCount(const GridSize& errorSize) {
    return samplesOf(bricksOf(errorSize, pointBrickSide));
}

/// Arrays of a step's file by their index; those of points begin one later if there are bricks.
constexpr std::size_t lowArray = 0, normalArray = 1, bricksArray = 2, pointsArray = 2;

void addPoints(const HybridStepShape& shape, FileLayout& layout) {
    const auto count = shape.points;
    auto& arrays = layout.arrays;
    layout.groups.emplace_back("/points");
    if (shape.pointBytes == 5) {
        layout.groups.emplace_back("/bricks");
        arrays.push_back({"/bricks/begin", "u64", {brickCount(shape.errorSize) + 1}});
        arrays.push_back({"/points/advance", "u16", {count}});
    } else {
        arrays.push_back({"/points/place", shape.pointBytes == 6 ? "u8" : "u16", {count, 3}});
    }
    for (const auto* name : {"/points/value", "/points/error", "/points/normal"}) {
        arrays.push_back({name, "u8", {count}});
    }
}

Status damaged(const ArrayFile& file, const char* array, std::string message) {
    return Error{ErrorCode::corrupt, file.where(array), std::move(message)};
}

template <class T>
bool anyBeyond(std::span<const T> places, const GridSize& grid) {
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (places[i] >= grid[i % 3]) return true;
    }
    return false;
}

}  // namespace

std::uint64_t mostHybridStepBytes(const proto::HybridManifest& hybrid, const proto::HybridStepEntry& entry) {
    constexpr std::uint64_t besideArrays = 1 << 20;  // HDF5's own, some kB
    return samplesOf(gridSize(hybrid.low_size())) * (hybrid.value_bits() / 8 + 1) +
           entry.points() * hybrid.point_bytes() + (brickCount(gridSize(hybrid.error_size())) + 1) * 8 +
           besideArrays;
}

Result<HybridStepWriter> HybridStepWriter::create(const std::filesystem::path& directory,
                                                  const std::string& name, const HybridStepShape& shape) {
    const auto& size = shape.lowSize;
    const std::vector<std::uint64_t> extents{size[2], size[1], size[0]};
    FileLayout layout{{"/volume"}, {}, {}};
    layout.arrays.push_back({"/volume/value", shape.valueBits == 8 ? "u8" : "u16", extents});
    layout.arrays.push_back({"/volume/normal", "u8", extents});
    if (shape.pointBytes > 0) addPoints(shape, layout);
    MOTE_ASSIGN_OR_RETURN(auto file, ArrayFileWriter::create(directory, name, std::move(layout)));
    return HybridStepWriter(std::move(file), shape.pointBytes);
}

Status HybridStepWriter::writeLow(const LowCodes& codes, std::span<const std::uint8_t> normals) const {
    MOTE_RETURN_IF_ERROR(std::visit([&](auto values) { return put(lowArray, 0, values); }, codes));
    return put(normalArray, 0, normals);
}

Status HybridStepWriter::writePoints(std::uint64_t first, const HybridPoints& some) const {
    const auto place = pointsArray + (pointBytes_ == 5 ? 1 : 0);
    if (pointBytes_ == 5) MOTE_RETURN_IF_ERROR(put(place, first, some.advance));
    if (pointBytes_ == 6) MOTE_RETURN_IF_ERROR(put(place, 3 * first, some.place8));
    if (pointBytes_ == 9) MOTE_RETURN_IF_ERROR(put(place, 3 * first, some.place16));
    MOTE_RETURN_IF_ERROR(put(place + 1, first, some.value));
    MOTE_RETURN_IF_ERROR(put(place + 2, first, some.error));
    return put(place + 3, first, some.normal);
}

Status HybridStepWriter::writeBricks(std::span<const std::uint64_t> begin) const {
    return put(bricksArray, 0, begin);
}

Result<HybridStep> HybridStep::open(const PathBeneath& directory, const proto::Manifest& manifest,
                                    std::uint32_t step) {
    const auto* entry = findHybridStep(manifest, step);
    if (!entry) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("has no step {} of a hybrid volume", step)};
    }
    const auto& hybrid = manifest.hybrid();
    const std::filesystem::path name = entry->file();
    MOTE_ASSIGN_OR_RETURN(auto file,
                          name.extension() == packedSuffix
                              ? ArrayFile::openPacked(directory, manifest, name.stem().stem().string(),
                                                      mostHybridStepBytes(hybrid, *entry))
                              : ArrayFile::open(directory, manifest, name.stem().string()));
    HybridStep opened(std::move(file));
    opened.lowSize_ = gridSize(hybrid.low_size());
    opened.points_.grid = gridSize(hybrid.error_size());
    MOTE_RETURN_IF_ERROR(opened.readLow(hybrid.value_bits()));
    if (hybrid.point_bytes() > 0) {
        MOTE_RETURN_IF_ERROR(opened.readPoints(hybrid.point_bytes(), entry->points()));
        MOTE_RETURN_IF_ERROR(opened.checkPoints());
    }
    MOTE_RETURN_IF_ERROR(opened.check());
    return opened;
}

Status HybridStep::readLow(std::uint32_t bits) {
    const std::vector<std::uint64_t> shape{lowSize_[2], lowSize_[1], lowSize_[0]};
    const auto take = [&]<class T>(const char* name, std::span<const T>& out) -> Status {
        MOTE_ASSIGN_OR_RETURN(out, file_.get<T>(name, shape));
        return success();
    };
    MOTE_RETURN_IF_ERROR(take("/volume/normal", lowNormal_));
    if (bits == 8) {
        return take("/volume/value", low_.emplace<std::span<const std::uint8_t>>());
    }
    return take("/volume/value", low_.emplace<std::span<const std::uint16_t>>());
}

Status HybridStep::readPoints(std::uint32_t bytes, std::uint64_t count) {
    const auto take = [&]<class T>(const char* name, std::span<const T>& out,
                                   const std::vector<std::uint64_t>& shape) -> Status {
        MOTE_ASSIGN_OR_RETURN(out, file_.get<T>(name, shape));
        return success();
    };
    if (bytes == 5) {
        std::span<const std::uint64_t> begin;
        MOTE_RETURN_IF_ERROR(take("/bricks/begin", begin, {brickCount(points_.grid) + 1}));
        brickBegin_.assign(begin.begin(), begin.end());
        points_.brickBegin = brickBegin_;
        MOTE_RETURN_IF_ERROR(take("/points/advance", points_.advance, {count}));
    } else if (bytes == 6) {
        MOTE_RETURN_IF_ERROR(take("/points/place", points_.place8, {count, 3}));
    } else {
        MOTE_RETURN_IF_ERROR(take("/points/place", points_.place16, {count, 3}));
    }
    MOTE_RETURN_IF_ERROR(take("/points/value", points_.value, {count}));
    MOTE_RETURN_IF_ERROR(take("/points/error", points_.error, {count}));
    return take("/points/normal", points_.normal, {count});
}

/// What no hash can say: a file whose hashes were made to fit must not lead a reader astray.
Status HybridStep::checkPoints() const {
    const auto& begin = points_.brickBegin;
    if (begin.empty()) {
        if (!anyBeyond(points_.place8, points_.grid) && !anyBeyond(points_.place16, points_.grid)) {
            return success();
        }
        return damaged(file_, "/points/place", "holds a place outside of the error grid");
    }
    const bool ascending = std::is_sorted(begin.begin(), begin.end());
    if (begin.front() != 0 || begin.back() != points_.size() || !ascending) {
        return damaged(file_, "/bricks/begin", "does not divide the points among the bricks");
    }
    bool inside = true;
    points_.forEach([&](const HybridPoint& point) {
        for (std::size_t a = 0; a < 3; ++a) inside = inside && point.place[a] < points_.grid[a];
    });
    if (inside) return success();
    return damaged(file_, "/points/advance", "holds a place outside of the error grid");
}

}  // namespace mote::storage
