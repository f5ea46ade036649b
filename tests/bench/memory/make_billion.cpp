// SPDX-License-Identifier: GPL-3.0-or-later
//
// make-billion: a dataset of one step with as many particles as one likes, a core and a halo, written piece
// by piece: memory goes with the octree and not with the points. For measurements; the same arguments give
// the same bytes.
//
//   make-billion OUT.mote [PARTICLES] [SEED]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "protocol/base/json.h"
#include "protocol/scene/drawn_points.h"
#include "server/render/plan/octree_cell.h"
#include "storage/dataset_writer.h"
#include "storage/files/dataset_file.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/particles/step_file.h"
#include "storage/storage_error.h"
#include "tests/bench/memory/synthetic_tree.h"

namespace mote::bench {
namespace {

using storage::PackedPosition;
using storage::Preview;
using storage::StepArray;

constexpr unsigned volumeLevel = 6;
constexpr std::uint64_t piece = std::uint64_t{1} << 22;  // points

void require(const Status& status) {
    if (!status.ok()) throw storage::StorageError(status.error());
}

template <class T>
T require(Result<T> result) {
    if (!result.ok()) throw storage::StorageError(result.error());
    return *std::move(result);
}

struct Candidate {
    double from;  ///< the fraction that draws it
    storage::PreviewPoint point;
};

class BeamStep {
  public:
    BeamStep(std::uint64_t points, std::uint64_t seed)
        : points_(points),
          seed_(seed),
          tree_(points, seed),
          volume_(std::size_t{1} << (3 * volumeLevel)),
          scale_{tree_.leafDensity.front(), tree_.leafDensity.back()},
          previewed_(std::min<std::uint64_t>(points / 4, Preview::mostPoints)),
          fraction_(std::min(1.0, 1.05 * static_cast<double>(previewed_) / static_cast<double>(points))) {
        countVolume();
    }

    void write(const std::filesystem::path& directory, const std::string& name) {
        const storage::StepShape shape{.nodes = tree_.level.size(),
                                       .leaves = tree_.leafNode.size(),
                                       .points = points_,
                                       .previewPoints = previewed_,
                                       .volumeSize = 1U << volumeLevel};
        const storage::StepAttributes attributes{
            {"x", "px", "y"}, {-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}, static_cast<double>(points_)};
        file_.emplace(require(storage::StepFile::create(directory / (name + ".h5"), shape, attributes)));
        writeTree();
        writePoints();
        writePreview();
        const auto blocks = require(file_->hashes({})).blocks;
        require(storage::writeNewFile(directory / (name + ".digest"), toJson(file_->digest(shape, blocks))));
    }

    proto::Manifest manifest(const std::string& name) const {
        proto::Manifest manifest;
        manifest.set_kind("particles");
        manifest.set_format(storage::formatVersion);
        manifest.set_title(fmt::format("{} synthetic particles", points_));
        auto& particles = *manifest.mutable_particles();
        for (const char* axisName : {"x", "px", "y"}) {
            auto& axis = *particles.add_axes();
            axis.set_name(axisName);
            axis.set_min(-1.0);
            axis.set_max(1.0);
        }
        particles.set_density_min(scale_.min);
        particles.set_density_max(scale_.max);
        particles.set_volume_level(volumeLevel);
        particles.set_leaf_capacity(SyntheticTree::leafCapacity);
        particles.set_max_level(SyntheticTree::maxLevel);
        auto& step = *particles.add_steps();
        step.set_file(name + ".h5");
        step.set_digest(name + ".digest");
        step.set_particles(points_);
        step.set_total_weight(static_cast<double>(points_));
        std::vector<std::uint64_t> histogram(storage::densityHistogramBins);
        for (std::size_t leaf = 0; leaf < tree_.leafNode.size(); ++leaf) {
            const double bin = scale_.ofLeaf(tree_.leafDensity[leaf]) * storage::densityHistogramBins;
            histogram[std::min(histogram.size() - 1, static_cast<std::size_t>(bin))] += tree_.leafCount[leaf];
        }
        for (const auto bin : histogram) step.add_density_histogram(bin);
        return manifest;
    }

  private:
    template <class T>
    void put(StepArray which, const std::vector<T>& values, std::uint64_t at = 0) {
        require(file_->write(which, at * sizeof(T), std::as_bytes(std::span(values))));
    }

    void writeTree() {
        put(StepArray::octreeLevel, tree_.level);
        put(StepArray::octreeMorton, tree_.morton);
        put(StepArray::octreeFirstChild, tree_.firstChild);
        put(StepArray::octreeChildCount, tree_.childCount);
        put(StepArray::octreeCount, tree_.count);
        put(StepArray::octreeDensity, tree_.density);
        put(StepArray::octreeMinDensity, tree_.minDensity);
        put(StepArray::leafNode, tree_.leafNode);
        put(StepArray::leafPointBegin, tree_.leafBegin);
        put(StepArray::leafPointCount, tree_.leafCount);
        put(StepArray::leafDensity, tree_.leafDensity);
        put(StepArray::volumeDensity, volume_);
    }

    /// Evenly spread in the leaf, and so is every prefix; rows are numbered as the points lie.
    void writePoints() {
        std::vector<PackedPosition> positions;
        std::vector<std::uint64_t> rows;
        std::uint64_t done = 0;
        const auto flush = [&] {
            require(file_->write(StepArray::pointPosition, done * sizeof(PackedPosition),
                                 std::as_bytes(std::span(positions))));
            put(StepArray::pointRow, rows, done);
            done += positions.size();
            positions.clear();
            rows.clear();
        };
        for (std::size_t leaf = 0; leaf < tree_.leafNode.size(); ++leaf) {
            for (std::uint32_t i = 0; i < tree_.leafCount[leaf]; ++i) {
                const std::uint64_t h = mixed(seed_ ^ mixed(tree_.leafBegin[leaf] + i));
                positions.push_back({static_cast<std::uint16_t>(h), static_cast<std::uint16_t>(h >> 16),
                                     static_cast<std::uint16_t>(h >> 32)});
                rows.push_back(tree_.leafBegin[leaf] + i);
            }
            preview(leaf, positions);
            if (positions.size() >= piece) flush();
        }
        flush();
    }

    /// The leaf's points are the last of `positions`.
    void preview(std::size_t leaf, const std::vector<PackedPosition>& positions) {
        const auto node = tree_.leafNode[leaf];
        const unsigned level = tree_.level[node];
        const double offset = leafOffset(tree_.level[node], tree_.morton[node]);
        const auto cell = render::cellPlace(tree_.morton[node]);
        const auto shade =
            static_cast<std::uint16_t>(std::lround(65535.0 * scale_.ofLeaf(tree_.leafDensity[leaf])));
        const std::uint32_t count = tree_.leafCount[leaf];
        for (std::uint32_t i = 0; i < count && drawnFrom(i, count, offset) <= fraction_; ++i) {
            const auto& at = positions[positions.size() - count + i];
            const auto place = [&](std::uint32_t corner, std::uint16_t within) {
                return static_cast<std::uint16_t>(((std::uint64_t{corner} << 16) | within) >> level);
            };
            candidates_.push_back({drawnFrom(i, count, offset),
                                   {place(cell.x, at.x), place(cell.y, at.y), place(cell.z, at.z), shade}});
        }
    }

    void writePreview() {
        if (candidates_.size() < previewed_) {
            throw storage::StorageError(Error{ErrorCode::internal, "", "too few points for the preview"});
        }
        std::stable_sort(candidates_.begin(), candidates_.end(),
                         [](const Candidate& a, const Candidate& b) { return a.from < b.from; });
        std::vector<storage::PreviewPoint> shown;
        std::vector<float> threshold;
        for (std::uint64_t i = 0; i < previewed_; ++i) {
            if (i % Preview::blockPoints == 0) threshold.push_back(static_cast<float>(candidates_[i].from));
            shown.push_back(candidates_[i].point);
        }
        put(StepArray::previewPoint, shown);
        put(StepArray::previewThreshold, threshold);
    }

    /// From the nodes of its level, and the leaves above it.
    void countVolume() {
        for (std::size_t node = 0; node < tree_.level.size(); ++node) {
            const unsigned level = tree_.level[node];
            if (level > volumeLevel || (level < volumeLevel && tree_.childCount[node] != 0)) continue;
            const std::uint32_t edge = 1U << (volumeLevel - level);
            const auto corner = render::cellPlace(tree_.morton[node]) * edge;
            for (std::uint32_t i = 0; i < edge * edge * edge; ++i) {
                const std::size_t x = corner.x + i % edge;
                const std::size_t y = corner.y + i / edge % edge;
                const std::size_t z = corner.z + i / edge / edge;
                volume_[(z << volumeLevel | y) << volumeLevel | x] = tree_.density[node];
            }
        }
    }

    std::uint64_t points_, seed_;
    SyntheticTree tree_;
    std::vector<float> volume_;
    LogDensity scale_;
    std::uint64_t previewed_;
    double fraction_;  ///< draws the preview, and a little more
    std::vector<Candidate> candidates_;
    std::optional<storage::StepFile> file_;
};

int run(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: make-billion OUT.mote [PARTICLES] [SEED]\n");
        return 2;
    }
    const auto points = static_cast<std::uint64_t>(argc > 2 ? std::atof(argv[2]) : 1e9);
    auto writer = require(storage::DatasetWriter::create(argv[1]));
    BeamStep step(points, argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
    const auto name = storage::stepName(0);
    step.write(writer.directory(), name);
    require(writer.add(name + ".h5"));
    require(writer.add(name + ".digest"));
    require(writer.publish(step.manifest(name)));
    return 0;
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    try {
        return mote::bench::run(argc, argv);
    } catch (const std::exception& failure) {
        fmt::print(stderr, "make-billion: {}\n", failure.what());
        return 1;
    }
}
