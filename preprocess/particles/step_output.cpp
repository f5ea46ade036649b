// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_output.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <optional>

#include "preprocess/job.h"
#include "preprocess/particles/point_output.h"
#include "protocol/scene/json.h"
#include "storage/files/dataset_file.h"

namespace mote::prep {
namespace {

using storage::StepArray;
using storage::StepFile;

class StepFiles {
  public:
    StepFiles(const BuiltStep& step, const StepOutput& output)
        : step_(step),
          output_(output),
          ranks_(*output.ranks),
          path_(output.directory / (output.name + ".h5")) {
        const auto points = step.counts.particles;
        shape_ = {step.octree.level.size(), step.octree.leafNode.size(), points, previewSize(points),
                  step.volumeSize};
    }

    Result<StepFile::Places> run() {
        MOTE_RETURN_IF_ERROR(openFile());
        PointOutput points(step_, *file_, ranks_, output_.cancelled);
        Status tree = success();
        Status written = success();
        tbb::parallel_invoke([&] { written = points.run(); }, [&] { tree = writeTree(); });
        MOTE_RETURN_IF_ERROR(written);
        MOTE_RETURN_IF_ERROR(agree(ranks_, tree));
        MOTE_RETURN_IF_ERROR(points.writePreview());
        MOTE_RETURN_IF_ERROR(hash());
        return file_->places();
    }

  private:
    /// Rank 0 makes the file; the others learn from it where the arrays lie.
    Status openFile() {
        StepFile::Places places;
        Status status = success();
        if (ranks_.first()) {
            auto created = StepFile::create(path_, shape_, output_.attributes);
            if (!created.ok()) status = created.error();
            if (created.ok()) file_.emplace(*std::move(created));
        }
        MOTE_RETURN_IF_ERROR(agree(ranks_, status));
        if (file_) places = file_->places();
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<StepFile::Place>(ranks_, places));
        if (!file_) {
            std::copy(all.front().begin(), all.front().end(), places.begin());
            auto opened = StepFile::open(path_, places);
            if (!opened.ok()) status = opened.error();
            if (opened.ok()) file_.emplace(*std::move(opened));
        }
        return agree(ranks_, status);
    }

    template <class T>
    Status write(StepArray which, const std::vector<T>& values) {
        return file_->write(which, 0, std::as_bytes(std::span(values)));
    }

    /// Octree, leaves and volume, which all ranks know: each writes some.
    Status writeTree() {
        const auto& tree = step_.octree;
        const std::vector<std::function<Status()>> parts{
            [&] { return write(StepArray::octreeLevel, tree.level); },
            [&] { return write(StepArray::octreeMorton, tree.morton); },
            [&] { return write(StepArray::octreeFirstChild, tree.firstChild); },
            [&] { return write(StepArray::octreeChildCount, tree.childCount); },
            [&] { return write(StepArray::octreeCount, tree.count); },
            [&] { return write(StepArray::octreeDensity, tree.density); },
            [&] { return write(StepArray::octreeMinDensity, tree.minDensity); },
            [&] { return write(StepArray::leafNode, tree.leafNode); },
            [&] { return write(StepArray::leafPointBegin, tree.leafPointBegin); },
            [&] { return write(StepArray::leafPointCount, tree.leafPointCount); },
            [&] { return write(StepArray::leafDensity, tree.leafDensity); },
            [&] { return write(StepArray::volumeDensity, step_.volume); },
        };
        std::vector<Status> written(parts.size(), success());
        tbb::parallel_for(static_cast<std::size_t>(ranks_.rank()), parts.size(),
                          static_cast<std::size_t>(ranks_.size()),
                          [&](std::size_t i) { written[i] = parts[i](); });
        for (const auto& status : written) MOTE_RETURN_IF_ERROR(status);
        return success();
    }

    /// Blocks by all ranks but the first, which meanwhile looks at the whole file.
    Status hash() {
        const std::uint64_t blocks = file_->blockCount();
        const auto size = static_cast<std::uint64_t>(ranks_.size());
        const auto rank = static_cast<std::uint64_t>(ranks_.rank());
        const std::uint64_t begin = size == 1 ? 0 : rank == 0 ? 0 : blocks * (rank - 1) / (size - 1);
        const std::uint64_t end = size == 1 ? blocks : blocks * rank / std::max<std::uint64_t>(1, size - 1);
        Result<std::vector<std::uint64_t>> mine(std::vector<std::uint64_t>{});
        Status complete = success();
        tbb::parallel_invoke([&] { mine = hashBlocks(begin, end); },
                             [&] { complete = ranks_.first() ? output_.complete() : file_->sync(); });
        MOTE_RETURN_IF_ERROR(agree(ranks_, mine.ok() ? complete : Status(mine.error())));
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::uint64_t>(ranks_, *mine));
        return agree(ranks_, ranks_.first() ? writeDigest(all) : success());
    }

    Result<std::vector<std::uint64_t>> hashBlocks(std::uint64_t begin, std::uint64_t end) {
        constexpr std::uint64_t together = 16;
        const std::uint64_t parts = (end - begin + together - 1) / together;
        std::vector<Result<std::vector<std::uint64_t>>> hashed(parts, std::vector<std::uint64_t>{});
        tbb::parallel_for(std::uint64_t{0}, parts, [&](std::uint64_t part) {
            if (output_.cancelled()) {
                hashed[part] = cancelledError();
                return;
            }
            const std::uint64_t from = begin + part * together;
            hashed[part] = file_->hashBlocks(from, std::min(end, from + together));
        });
        std::vector<std::uint64_t> hashes;
        for (const auto& part : hashed) {
            if (!part.ok()) return part.error();
            hashes.insert(hashes.end(), part->begin(), part->end());
        }
        return hashes;
    }

    Status writeDigest(const std::vector<std::vector<std::uint64_t>>& hashes) {
        std::vector<std::uint64_t> blocks;
        for (const auto& part : hashes) blocks.insert(blocks.end(), part.begin(), part.end());
        return storage::writeNewFile(output_.directory / (output_.name + ".digest"),
                                     toJson(file_->digest(shape_, blocks)));
    }

    const BuiltStep& step_;
    const StepOutput& output_;
    Communicator& ranks_;
    std::filesystem::path path_;
    storage::StepShape shape_;
    std::optional<StepFile> file_;
};

}  // namespace

Result<StepFile::Places> writeBuiltStep(const BuiltStep& step, const StepOutput& output) {
    return StepFiles(step, output).run();
}

}  // namespace mote::prep
