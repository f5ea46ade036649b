// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/step_file.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "protocol/base/json.h"
#include "protocol/base/system_error.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/files/dataset_file.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

FileLayout layoutOf(const StepShape& shape, const StepAttributes& attributes) {
    FileLayout layout;
    layout.groups.assign(stepGroups.begin(), stepGroups.end());
    for (std::size_t i = 0; i < stepArrays.size(); ++i) {
        layout.arrays.push_back(
            {stepArrays[i].name, std::string(stepArrays[i].type), shape.of(static_cast<StepArray>(i))});
    }
    const auto row = [](const auto& values) { return std::vector(values.begin(), values.end()); };
    layout.attributes = {{"axes", row(attributes.axes)},
                         {"bounds_min", row(attributes.boundsMin)},
                         {"bounds_max", row(attributes.boundsMax)},
                         {"total_weight", attributes.totalWeight}};
    return layout;
}

// Pages of the cache that are new to a machine cost many times what the disk takes, and come by reading at
// less. Smaller files are read back before the disk has them.
constexpr std::uint64_t fewestPastCache = std::uint64_t{1} << 26;  // bytes

PageCache cacheFor(const StepFile::Places& places) {
    std::uint64_t bytes = 0;
    for (const auto& place : places) bytes += place.bytes;
    return bytes < fewestPastCache ? PageCache::kept : PageCache::passed;
}

std::uint64_t blocksOf(std::uint64_t bytes) {
    return (bytes + blockBytes - 1) / blockBytes;
}

StepShape shapeOf(const StepContent& content) {
    return {content.nodes.size(), content.leaves.size(), content.rows.size(), content.previewPoints.size(),
            content.volumeSize};
}

Status writeArrays(const StepFile& file, const StepContent& content) {
    const auto write = [&](StepArray which, auto values) {
        return file.write(which, 0, std::as_bytes(values));
    };
    const auto& nodes = content.nodes;
    const auto& leaves = content.leaves;
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeLevel, nodes.level));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeMorton, nodes.morton));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeFirstChild, nodes.firstChild));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeChildCount, nodes.childCount));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeCount, nodes.count));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeDensity, nodes.density));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeMinDensity, nodes.minDensity));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafNode, leaves.node));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafPointBegin, leaves.pointBegin));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafPointCount, leaves.pointCount));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafDensity, leaves.density));
    MOTE_RETURN_IF_ERROR(write(StepArray::pointPosition, content.positions));
    MOTE_RETURN_IF_ERROR(write(StepArray::pointRow, content.rows));
    MOTE_RETURN_IF_ERROR(write(StepArray::volumeDensity, content.volume));
    MOTE_RETURN_IF_ERROR(write(StepArray::previewPoint, content.previewPoints));
    return write(StepArray::previewThreshold, content.previewThreshold);
}

}  // namespace

std::vector<std::uint64_t> StepShape::of(StepArray which) const {
    if (which <= StepArray::octreeMinDensity) return {nodes};
    if (which <= StepArray::leafDensity) return {leaves};
    switch (which) {
        case StepArray::pointPosition:
            return {points, 3};
        case StepArray::pointRow:
            return {points};
        case StepArray::volumeDensity:
            return {volumeSize, volumeSize, volumeSize};
        case StepArray::previewPoint:
            return {previewPoints, 4};
        default:
            return {(previewPoints + Preview::blockPoints - 1) / Preview::blockPoints};
    }
}

Result<StepFile> StepFile::create(const fs::path& path, const StepShape& shape,
                                  const StepAttributes& attributes) {
    MOTE_ASSIGN_OR_RETURN(const auto laidOut, layOutFile(path, layoutOf(shape, attributes)));
    Places places;
    std::copy(laidOut.begin(), laidOut.end(), places.begin());
    return open(path, places);
}

Result<StepFile> StepFile::open(const fs::path& path, const Places& places) {
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return StepFile(path, std::move(file), places);
}

Status StepFile::write(StepArray which, std::uint64_t at, std::span<const std::byte> bytes) const {
    const auto& place = places_[static_cast<std::size_t>(which)];
    MOTE_CHECK(at <= place.bytes && bytes.size() <= place.bytes - at);
    if (which != StepArray::pointRow || rows_.empty())
        return writeAt(file_.get(), place.offset + at, bytes, path_, cacheFor(places_));
    const auto held = heldRows(at, bytes.size());
    for (std::size_t i = 0; i < held.size(); ++i) {
        std::uint64_t row = 0;
        std::memcpy(&row, bytes.data() + i * sizeof row, sizeof row);
        held[i] = static_cast<std::uint32_t>(row);
    }
    return writeAt(file_.get(), place.offset + at, bytes, path_, PageCache::passed);
}

void StepFile::holdRows(std::span<std::uint32_t> rows) {
    MOTE_CHECK(rows.size() * sizeof(std::uint64_t) ==
               places_[static_cast<std::size_t>(StepArray::pointRow)].bytes);
    rows_ = rows;
}

std::span<std::uint32_t> StepFile::heldRows(std::uint64_t at, std::size_t bytes) const {
    MOTE_CHECK(at % sizeof(std::uint64_t) == 0 && bytes % sizeof(std::uint64_t) == 0);
    return rows_.subspan(at / sizeof(std::uint64_t), bytes / sizeof(std::uint64_t));
}

void StepFile::readHeld(std::uint64_t at, std::span<std::byte> bytes) const {
    const auto held = heldRows(at, bytes.size());
    for (std::size_t i = 0; i < held.size(); ++i) {
        const std::uint64_t row = held[i];
        std::memcpy(bytes.data() + i * sizeof row, &row, sizeof row);
    }
}

Status StepFile::read(StepArray which, std::uint64_t at, std::span<std::byte> bytes) const {
    const auto& place = places_[static_cast<std::size_t>(which)];
    MOTE_CHECK(at <= place.bytes && bytes.size() <= place.bytes - at);
    if (which != StepArray::pointRow || rows_.empty())
        return readAt(file_.get(), place.offset + at, bytes, path_);
    readHeld(at, bytes);
    return success();
}

Status StepFile::sync() const {
    if (::fsync(file_.get()) == 0) return success();
    return systemError(errno, path_.string(), "cannot be written to the disk");
}

HashPass::File StepFile::forHashes() const {
    HashPass::File file{file_.get(), path_, {places_.begin(), places_.end()}, {}};
    file.cache.assign(places_.size(), PageCache::kept);
    file.cache[static_cast<std::size_t>(StepArray::pointPosition)] = cacheFor(places_);
    if (rowsUnread_) file.cache[static_cast<std::size_t>(StepArray::pointRow)] = cacheFor(places_);
    file.held = [this](std::size_t array, std::uint64_t at, std::span<std::byte> bytes) {
        const bool held = static_cast<StepArray>(array) == StepArray::pointRow && !rows_.empty();
        if (held) readHeld(at, bytes);
        return held;
    };
    return file;
}

void StepFile::hashAhead(std::function<bool()> cancelled) {
    pass_ = std::make_unique<HashPass>(forHashes(), std::move(cancelled));
    pass_->begin();
}

void StepFile::complete(StepArray which) const {
    if (pass_) pass_->complete(static_cast<std::size_t>(which));
}

Result<StepFile::Hashes> StepFile::hashes(const std::function<bool()>& cancelled) const {
    std::optional<HashPass> own;
    if (!pass_) own.emplace(forHashes(), cancelled);
    auto& pass = pass_ ? *pass_ : *own;
    Hashes hashes;
    MOTE_ASSIGN_OR_RETURN(hashes.whole, pass.finish());
    for (std::size_t i = 0; i < places_.size(); ++i) {
        const auto& blocks = pass.blocks(i);
        hashes.blocks.insert(hashes.blocks.end(), blocks.begin(), blocks.end());
    }
    return hashes;
}

proto::Digest StepFile::digest(const StepShape& shape, std::span<const std::uint64_t> blocks) const {
    proto::Digest digest;
    std::size_t next = 0;
    for (std::size_t i = 0; i < stepArrays.size(); ++i) {
        auto& array = *digest.add_arrays();
        array.set_name(stepArrays[i].name);
        array.set_type(std::string(stepArrays[i].type));
        for (const auto extent : shape.of(static_cast<StepArray>(i))) array.add_shape(extent);
        array.set_offset(places_[i].offset);
        const std::uint64_t count = blocksOf(places_[i].bytes);
        for (std::uint64_t block = 0; block < count; ++block) array.add_blocks(blocks[next++]);
    }
    MOTE_CHECK(next == blocks.size());
    return digest;
}

Status writeStep(const std::filesystem::path& directory, const std::string& name,
                 const StepContent& content) {
    const auto shape = shapeOf(content);
    MOTE_ASSIGN_OR_RETURN(const auto file, StepFile::create(directory / (name + ".h5"), shape, content));
    MOTE_RETURN_IF_ERROR(writeArrays(file, content));
    MOTE_ASSIGN_OR_RETURN(const auto hashes, file.hashes({}));
    return writeNewFile(directory / (name + ".digest"), toJson(file.digest(shape, hashes.blocks)));
}

std::string stepName(std::uint32_t step) {
    return fmt::format("step-{:06}", step);
}

}  // namespace mote::storage
