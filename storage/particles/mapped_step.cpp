// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/mapped_step.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "storage/arrays/array_file.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_columns.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

/// What stands for the preview of a file that has none: both of its arrays, empty.
proto::Digest withPreview(proto::Digest digest) {
    const auto isPreview = [](const auto& array) { return array.name().rfind("/preview/", 0) == 0; };
    if (std::any_of(digest.arrays().begin(), digest.arrays().end(), isPreview)) return digest;
    for (const auto which : {StepArray::previewPoint, StepArray::previewThreshold}) {
        const auto& layout = stepArrays[static_cast<std::size_t>(which)];
        auto& array = *digest.add_arrays();
        array.set_name(layout.name);
        array.set_type(std::string(layout.type));
        array.add_shape(0);
        if (which == StepArray::previewPoint) array.add_shape(4);
    }
    return digest;
}

}  // namespace

Result<std::shared_ptr<const ParticleStep>> ParticleStep::open(const PathBeneath& directory,
                                                               const proto::Manifest& manifest,
                                                               std::uint32_t step,
                                                               std::shared_ptr<BlockBudget> budget) {
    MOTE_RETURN_IF_ERROR(checkManifest(manifest), (directory / manifestName).string() + ":");
    MOTE_ASSIGN_OR_RETURN(auto opened, MappedStep::open(directory, manifest, step, std::move(budget)));
    return std::shared_ptr<const ParticleStep>(std::move(opened));
}

Result<std::shared_ptr<const MappedStep>> MappedStep::open(const PathBeneath& directory,
                                                           const proto::Manifest& manifest,
                                                           std::uint32_t step,
                                                           std::shared_ptr<BlockBudget> budget) {
    MOTE_ASSIGN_OR_RETURN(const auto* const found, stepEntry(directory, manifest, step));
    const auto& entry = *found;
    const auto& particles = manifest.particles();
    MOTE_ASSIGN_OR_RETURN(const auto digest,
                          readDigest(directory / entry.digest(), *findFile(manifest, entry.digest())));
    const auto path = directory / entry.file();
    const auto& described = *findFile(manifest, entry.file());
    MOTE_ASSIGN_OR_RETURN(auto file, MappedFile::open(path, described.size()));
    const std::shared_ptr<MappedStep> mapped(
        new MappedStep(std::move(file), path.string(), std::move(budget)));
    mapped->origin_ = {path.path(), described.xxh3_128()};
    mapped->volumeSize_ = 1U << particles.volume_level();
    mapped->maxLevel_ = particles.max_level();
    mapped->logDensity_ = {particles.density_min(), particles.density_max()};
    MOTE_RETURN_IF_ERROR(mapped->readArrays(withPreview(digest)));
    MOTE_RETURN_IF_ERROR(mapped->checkShapes(entry));
    MOTE_RETURN_IF_ERROR(mapped->enterBudget());
    return std::shared_ptr<const MappedStep>(mapped);
}

MappedStep::~MappedStep() {
    if (!budget_) return;
    for (const auto& one : arrays_) budget_->leave(one);
    if (tree_) budget_->leave(*tree_);
}

Status MappedStep::enterBudget() const {
    if (!budget_) return success();
    for (const auto& one : arrays_) budget_->enter(one);
    budget_->enter(*tree_);
    if (bytesAtOnce() <= budget_->limit()) return success();
    return Error{ErrorCode::resourceExhausted, name_,
                 fmt::format("its octree and volume take {} MiB of memory where {} MiB are left for data; "
                             "raise --memory by {} MiB or more",
                             bytesAtOnce() >> 20, budget_->limit() >> 20,
                             ((bytesAtOnce() - budget_->limit()) >> 20) + 1)};
}

Status MappedStep::readArrays(const proto::Digest& digest) {
    for (const auto& wanted : stepArrays) {
        const proto::DigestArray* found = nullptr;
        for (const auto& candidate : digest.arrays()) {
            if (candidate.name() == wanted.name) found = &candidate;
        }
        const auto where = name_ + ":" + wanted.name;
        if (!found) return Error{ErrorCode::corrupt, where, "is missing in the digest"};
        if (found->type() != wanted.type) return Error{ErrorCode::corrupt, where, "has the wrong type"};
        MOTE_ASSIGN_OR_RETURN(auto made, VerifiedArray::make(file_, *found, budget_.get()));
        arrays_.push_back(std::move(made));
    }
    tree_.emplace(arrays_, budget_, StepTree::Bounds{pointCount(), maxLevel_}, name_);
    return success();
}

Status MappedStep::checkShapes(const proto::ParticleStepEntry& entry) const {
    using Shape = std::vector<std::uint64_t>;
    const std::uint64_t nodes = array(StepArray::octreeLevel).size();
    const std::uint64_t leaves = array(StepArray::leafNode).size();
    const std::uint64_t points = entry.particles();
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (nodes < 1 || nodes > most || leaves < 1 || leaves > nodes) {
        return Error{ErrorCode::corrupt, name_, "the octree has no sensible number of nodes and leaves"};
    }
    const std::uint64_t shown = array(StepArray::previewPoint).size() / 4;
    if (shown > std::min<std::uint64_t>(points / 4, Preview::mostPoints)) {
        return Error{ErrorCode::corrupt, name_ + ":/preview/point", "has more points than a preview may"};
    }
    for (std::size_t i = 0; i < stepArrays.size(); ++i) {
        const auto which = static_cast<StepArray>(i);
        Shape expected{leaves};
        if (which <= StepArray::octreeMinDensity) expected = {nodes};
        if (which == StepArray::pointPosition) expected = {points, 3};
        if (which == StepArray::pointRow) expected = {points};
        if (which == StepArray::volumeDensity) expected = Shape(3, volumeSize_);
        if (which == StepArray::previewPoint) expected = {shown, 4};
        if (which == StepArray::previewThreshold) {
            expected = {(shown + Preview::blockPoints - 1) / Preview::blockPoints};
        }
        if (arrays_[i].shape() == expected) continue;
        return Error{ErrorCode::corrupt, name_ + ":" + stepArrays[i].name,
                     fmt::format("has the shape [{}], not [{}]", fmt::join(arrays_[i].shape(), ", "),
                                 fmt::join(expected, ", "))};
    }
    return success();
}

/// Not all ranges come from leaves that were checked: a columns file names points too.
void MappedStep::requirePoints(std::uint64_t begin, std::uint64_t count) const {
    if (begin <= pointCount() && count <= pointCount() - begin) return;
    throw StorageError(
        Error{ErrorCode::corrupt, name_ + ":/points/position", "has no points where some are asked for"});
}

std::span<const PackedPosition> MappedStep::positions(std::uint64_t begin, std::uint64_t count) const {
    requirePoints(begin, count);
    const auto numbers = array(StepArray::pointPosition).get<std::uint16_t>(3 * begin, 3 * count);
    return {reinterpret_cast<const PackedPosition*>(numbers.data()), count};
}

std::span<const std::uint64_t> MappedStep::rows(std::uint64_t begin, std::uint64_t count) const {
    requirePoints(begin, count);
    return array(StepArray::pointRow).get<std::uint64_t>(begin, count);
}

std::span<const float> MappedStep::volume() const {
    return array(StepArray::volumeDensity).all<float>();
}

LogDensity MappedStep::ownScale() const {
    const std::lock_guard lock(scaleMutex_);
    if (!scaleKnown_.load(std::memory_order_relaxed)) {
        scale_ = findScale();
        scaleKnown_.store(true, std::memory_order_release);
    }
    return scale_;
}

LogDensity MappedStep::findScale() const {
    const auto& densities = array(StepArray::leafDensity);
    const auto at = [&](std::uint64_t leaf) { return densities.get<float>(leaf, 1)[0]; };
    // By halves, so that a few blocks are read; leaves that weigh nothing come first.
    std::uint64_t first = 0;
    std::uint64_t last = densities.size() - 1;
    while (first < last) {
        const std::uint64_t middle = first + (last - first) / 2;
        if (at(middle) > 0.0F) {
            last = middle;
        } else {
            first = middle + 1;
        }
    }
    const float least = at(first);
    const float greatest = at(densities.size() - 1);
    if (!std::isfinite(greatest) || !(least >= 0.0F) || least > greatest) {
        throw StorageError(
            Error{ErrorCode::corrupt, name_ + ":/leaves/density", "is not in ascending order"});
    }
    return greatest > 0.0F ? LogDensity{least, greatest} : LogDensity{};
}

Preview MappedStep::preview(std::uint64_t most) const {
    Preview preview;
    preview.total = array(StepArray::previewPoint).size() / 4;
    if (preview.total == 0) return preview;
    const std::uint64_t count = std::min(most, preview.total);
    const auto numbers = array(StepArray::previewPoint).get<std::uint16_t>(0, 4 * count);
    preview.points = {reinterpret_cast<const PreviewPoint*>(numbers.data()), count};
    preview.threshold = array(StepArray::previewThreshold).all<float>();
    preview.scale = ownScale();
    // Every comparison with a number that is none is false.
    const auto& threshold = preview.threshold;
    if (!(threshold.front() >= 0.0F && threshold.back() <= 1.0F) ||
        std::adjacent_find(threshold.begin(), threshold.end(), [](float a, float b) { return !(a <= b); }) !=
            threshold.end()) {
        throw StorageError(
            Error{ErrorCode::corrupt, name_ + ":/preview/threshold", "does not ascend from 0 to 1"});
    }
    return preview;
}

bool MappedStep::octreeReady() const {
    return !budget_ || tree_->ready();
}

bool MappedStep::volumeReady() const {
    const auto& densities = array(StepArray::volumeDensity);
    return densities.ready(0, densities.bytes()) == densities.bytes();
}

std::uint64_t MappedStep::positionsReady(std::uint64_t begin, std::uint64_t count) const {
    requirePoints(begin, count);
    constexpr auto size = sizeof(PackedPosition);
    return array(StepArray::pointPosition).ready(size * begin, size * count) / size;
}

std::uint64_t MappedStep::previewReady(std::uint64_t most) const {
    const auto& thresholds = array(StepArray::previewThreshold);
    if (thresholds.ready(0, thresholds.bytes()) != thresholds.bytes()) return 0;
    if (budget_ && thresholds.size() > 0 && !scaleKnown_.load(std::memory_order_acquire)) return 0;
    const auto& points = array(StepArray::previewPoint);
    const auto bytes = std::min<std::uint64_t>(most * sizeof(PreviewPoint), points.bytes());
    const auto ready = points.ready(0, bytes);
    return ready == points.bytes() ? most : ready / sizeof(PreviewPoint);
}

void MappedStep::check() const {
    if (const auto damage = file_.damage()) throw StorageError(*damage);
    const std::lock_guard lock(failureMutex_);
    if (failure_) throw StorageError(*failure_);
}

void MappedStep::fail(const Error& error) const {
    const std::lock_guard lock(failureMutex_);
    if (!failure_) failure_ = error;
}

std::uint64_t MappedStep::bytesAtOnce() const {
    return array(StepArray::volumeDensity).bytes() + tree_->bytes();
}

std::vector<MappedStep::Ahead> MappedStep::aheadOf(const StepNeed& need) const {
    std::vector<Ahead> ahead;
    const auto bytes = [&](StepArray which, std::uint64_t begin, std::uint64_t end) {
        const auto& wanted = array(which);
        end = std::min(end, wanted.bytes());
        if (begin < end) ahead.push_back({&wanted, begin / blockBytes, (end - 1) / blockBytes + 1});
    };
    const auto whole = [&](StepArray which) { bytes(which, 0, array(which).bytes()); };
    if (need.preview > 0 && array(StepArray::previewThreshold).size() > 0) {
        whole(StepArray::previewThreshold);
        ahead.push_back({.follows = Ahead::Follows::previewScale});
        bytes(StepArray::previewPoint, 0, std::min(need.preview, Preview::mostPoints) * sizeof(PreviewPoint));
    }
    if (need.volume) whole(StepArray::volumeDensity);
    if (need.octree) ahead.push_back({.follows = Ahead::Follows::tree});
    for (const auto& range : need.points) {
        const auto begin = std::min(range.begin, pointCount());
        const auto end = begin + std::min(range.count, pointCount() - begin);
        bytes(StepArray::pointPosition, begin * sizeof(PackedPosition), end * sizeof(PackedPosition));
    }
    return ahead;
}

bool MappedStep::follow(Ahead::Follows follows, BlockBudget::Generation generation) const {
    if (follows == Ahead::Follows::previewScale) {
        ownScale();
        return true;
    }
    // Threads that draw come first.
    tbb::task_arena arena(tbb::task_arena::automatic, 1, tbb::task_arena::priority::low);
    return arena.execute([&] { return tree_->bring(generation); });
}

std::vector<Error> MappedStep::verify(const std::function<bool()>& cancelled) const {
    std::vector<Error> errors;
    for (const auto& one : arrays_) {
        for (std::size_t block = 0; block < one.blockCount(); ++block) {
            if (cancelled && cancelled()) return {Error{ErrorCode::cancelled, name_, "cancelled"}};
            if (auto error = one.checkBlock(block)) errors.push_back(*std::move(error));
        }
    }
    if (!errors.empty()) return errors;
    try {
        tree_->get();
        preview(Preview::mostPoints);
    } catch (const StorageError& error) {
        errors.push_back(error.error());
    }
    return errors;
}

}  // namespace mote::storage
