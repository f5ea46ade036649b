// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/hybrid_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "storage/hybrid/check_hybrid.h"

namespace mote::storage {
namespace {

std::uint64_t brickCount(const HybridPoints& points) {
    return samplesOf(points.bricks());
}

void addPoints(const HybridPoints& points, ArrayFileContent& content) {
    const auto count = points.size();
    auto& arrays = content.arrays;
    content.groups.emplace_back("/points");
    if (!points.brickBegin.empty()) {
        content.groups.emplace_back("/bricks");
        arrays.push_back(arrayContent("/bricks/begin", {brickCount(points) + 1}, points.brickBegin));
        arrays.push_back(arrayContent("/points/place", {count}, points.placeInBrick));
    } else if (!points.place8.empty()) {
        arrays.push_back(arrayContent("/points/place", {count, 3}, points.place8));
    } else {
        arrays.push_back(arrayContent("/points/place", {count, 3}, points.place16));
    }
    arrays.push_back(arrayContent("/points/value", {count}, points.value));
    arrays.push_back(arrayContent("/points/error", {count}, points.error));
    arrays.push_back(arrayContent("/points/normal", {count}, points.normal));
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

Status writeHybridStep(const std::filesystem::path& directory, const std::string& name,
                       const HybridStepContent& content) {
    const auto& size = content.lowSize;
    const std::vector<std::uint64_t> shape{size[2], size[1], size[0]};
    ArrayFileContent file{{"/volume"}, {}, {}};
    std::visit([&](auto codes) { file.arrays.push_back(arrayContent("/volume/value", shape, codes)); },
               content.low);
    file.arrays.push_back(arrayContent("/volume/normal", shape, content.lowNormal));
    if (content.points) addPoints(*content.points, file);
    return writeArrayFile(directory, name, file);
}

Result<HybridStep> HybridStep::open(const std::filesystem::path& directory, const proto::Manifest& manifest,
                                    std::uint32_t step) {
    const auto* entry = findHybridStep(manifest, step);
    if (!entry) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("has no step {} of a hybrid volume", step)};
    }
    const auto& hybrid = manifest.hybrid();
    auto file = ArrayFile::open(directory, manifest, std::filesystem::path(entry->file()).stem().string());
    if (!file.ok()) return file.error();
    HybridStep opened(*std::move(file));
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
        const auto array = file_.get<T>(name, shape);
        if (!array.ok()) return array.error();
        out = *array;
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
        const auto array = file_.get<T>(name, shape);
        if (!array.ok()) return array.error();
        out = *array;
        return success();
    };
    if (bytes == 5) {
        MOTE_RETURN_IF_ERROR(take("/bricks/begin", points_.brickBegin, {brickCount(points_) + 1}));
        MOTE_RETURN_IF_ERROR(take("/points/place", points_.placeInBrick, {count}));
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
    return damaged(file_, "/points/place", "holds a place outside of the error grid");
}

}  // namespace mote::storage
