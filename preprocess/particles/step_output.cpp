// SPDX-License-Identifier: GPL-3.0-or-later

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/on_threads.h"
#include "preprocess/particles/preview_selection.h"
#include "preprocess/particles/range_builder.h"
#include "preprocess/particles/step_builder.h"
#include "protocol/base/json.h"
#include "protocol/base/mote_check.h"
#include "storage/files/dataset_file.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_file.h"

namespace mote::prep {
namespace {

using storage::StepArray;

constexpr std::uint64_t windowPoints = std::uint64_t{1} << 19;

// A message between ranks is a sequence of lists, each of which begins with its length.

/// Room for a list at the end of a message: where its values begin.
template <class T>
std::size_t addList(Bytes& message, std::uint64_t length) {
    const std::size_t at = message.size();
    message.resize(at + sizeof length + length * sizeof(T));
    std::memcpy(message.data() + at, &length, sizeof length);
    return at + sizeof length;
}

/// Takes a list off the front of a message.
template <class T>
std::span<const T> takeList(std::span<const std::byte>& message) {
    std::uint64_t length = 0;
    std::memcpy(&length, message.data(), sizeof length);
    const std::span values(reinterpret_cast<const T*>(message.data() + sizeof length), length);
    message = message.subspan(sizeof length + values.size_bytes());
    return values;
}

class PointOutput {
  public:
    /// All references outlive this.
    PointOutput(const BuiltStep& step, const storage::StepFile& file, Communicator& ranks,
                std::function<bool()> cancelled)
        : step_(step),
          file_(file),
          ranks_(ranks),
          cancelled_(std::move(cancelled)),
          selection_(step.octree),
          candidates_(windowCount()) {}

    /// Writes the points of all windows. Errors: resourceExhausted (disk full), cancelled, internal; the same
    /// on all ranks.
    Status run() {
        if (ranks_.size() == 1) return runAlone();
        const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
        // Ranks may differ in their threads, not in what they expect of each other.
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::size_t>(ranks_, std::span(&threads, 1)));
        const std::size_t together = 2 * all.front().front() * all.size();
        for (std::size_t first = 0; first < windowCount(); first += together) {
            MOTE_RETURN_IF_ERROR(agree(ranks_, runRound(first, std::min(windowCount(), first + together))));
        }
        return success();
    }

    /// Writes the preview, after run(). Errors: as run().
    Status writePreview() {
        if (ranks_.size() == 1) return writePreview({candidates_.begin(), candidates_.end()});
        MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(slices()));
        std::vector<std::span<const std::byte>> rest(incoming.begin(), incoming.end());
        std::vector<std::span<const PreviewCandidate>> lists;
        // Each window's candidates come from the one rank that wrote it; of the others, none.
        for (std::size_t i = 0; i < windowCount(); ++i) {
            for (auto& bytes : rest) lists.push_back(takeList<PreviewCandidate>(bytes));
        }
        return writePreview(lists);
    }

  private:
    /// Points of the file that are gathered and written at once.
    struct Window {
        std::uint64_t begin, end;
    };
    /// A thread's memory.
    struct Worker {
        std::vector<LeafPoint> gathered;
        std::vector<storage::PackedPosition> positions;
        std::vector<std::uint64_t> rows;
    };

    std::size_t own() const { return static_cast<std::size_t>(ranks_.rank()); }

    std::size_t windowCount() const { return (step_.counts.particles + windowPoints - 1) / windowPoints; }

    Window window(std::size_t index) const {
        const std::uint64_t begin = index * windowPoints;
        return {begin, std::min(step_.counts.particles, begin + windowPoints)};
    }

    /// Calls `use(leaf, first, count)` for the leaves of a window: which of their points lie in it.
    template <class Use>
    void forEachPart(const Window& window, Use use) const {
        const auto& begins = step_.octree.leafPointBegin;
        const auto after = std::upper_bound(begins.begin(), begins.end(), window.begin);
        for (auto leaf = static_cast<std::size_t>(after - begins.begin()) - 1;
             leaf < begins.size() && begins[leaf] < window.end; ++leaf) {
            const std::uint64_t first = std::max(window.begin, begins[leaf]) - begins[leaf];
            const std::uint64_t end =
                std::min(window.end - begins[leaf], std::uint64_t{step_.octree.leafPointCount[leaf]});
            use(leaf, static_cast<std::uint32_t>(first), static_cast<std::size_t>(end - first));
        }
    }

    std::size_t rankOf(std::size_t leaf) const {
        const auto& first = step_.firstPoint;
        const auto after = std::upper_bound(first.begin(), first.end(), step_.octree.leafSource[leaf]);
        return static_cast<std::size_t>(after - first.begin()) - 1;
    }

    Status runAlone() {
        tbb::enumerable_thread_specific<Worker> workers;
        return inParallel(windowCount(), [&](std::size_t i) -> Status {
            if (cancelled_()) return wasCancelled();
            auto& worker = workers.local();
            worker.gathered.resize(window(i).end - window(i).begin);
            MOTE_RETURN_IF_ERROR(gather(window(i), std::as_writable_bytes(std::span(worker.gathered))));
            return write(i, {worker.gathered}, worker);
        });
    }

    /// Windows [first, last), in turn one for each rank.
    Status runRound(std::size_t first, std::size_t last) {
        auto outgoing = gatherRound(first, last);
        MOTE_RETURN_IF_ERROR(agree(ranks_, outgoing));
        MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(*std::move(outgoing)));
        const auto size = static_cast<std::size_t>(ranks_.size());
        std::vector<std::span<const std::byte>> rest(incoming.begin(), incoming.end());
        std::vector<std::pair<std::size_t, std::vector<std::span<const LeafPoint>>>> mine;
        for (std::size_t i = first; i < last; ++i) {
            if (i % size != own()) continue;
            auto& streams = mine.emplace_back(i, std::vector<std::span<const LeafPoint>>()).second;
            for (auto& bytes : rest) streams.push_back(takeList<LeafPoint>(bytes));
        }
        tbb::enumerable_thread_specific<Worker> workers;
        return inParallel(mine.size(), [&](std::size_t i) {
            return write(mine[i].first, std::move(mine[i].second), workers.local());
        });
    }

    /// This rank's points of all windows, by the rank that writes them.
    Result<std::vector<Bytes>> gatherRound(std::size_t first, std::size_t last) {
        if (cancelled_()) return wasCancelled();
        std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
        std::vector<std::size_t> begin;
        for (std::size_t i = first; i < last; ++i) {
            begin.push_back(addList<LeafPoint>(outgoing[i % outgoing.size()], ownPoints(window(i))));
        }
        MOTE_RETURN_IF_ERROR(inParallel(last - first, [&](std::size_t i) {
            auto& to = outgoing[(first + i) % outgoing.size()];
            return gather(window(first + i), std::span(to).subspan(begin[i]));
        }));
        return outgoing;
    }

    std::uint64_t ownPoints(const Window& window) const {
        std::uint64_t points = 0;
        forEachPart(window, [&](std::size_t leaf, std::uint32_t, std::size_t count) {
            if (rankOf(leaf) == own()) points += count;
        });
        return points;
    }

    /// This rank's points of a window, in their order, to the front of `to`.
    Status gather(const Window& window, std::span<std::byte> to) const {
        const std::uint64_t base = step_.firstPoint[own()];
        std::vector<LeafPoint> buffer;
        Status status = success();
        forEachPart(window, [&](std::size_t leaf, std::uint32_t first, std::size_t count) {
            if (!status.ok() || rankOf(leaf) != own()) return;
            const auto points =
                step_.points.read(step_.octree.leafSource[leaf] - base + first, count, buffer);
            if (!points.ok()) {
                status = points.error();
                return;
            }
            std::memcpy(to.data(), points->data(), points->size_bytes());
            to = to.subspan(points->size_bytes());
        });
        return status;
    }

    Status write(std::size_t index, std::vector<std::span<const LeafPoint>> streams, Worker& worker) {
        const auto where = window(index);
        worker.positions.clear();
        worker.rows.clear();
        forEachPart(where, [&](std::size_t leaf, std::uint32_t first, std::size_t count) {
            auto& stream = streams[rankOf(leaf)];
            MOTE_CHECK(stream.size() >= count);
            for (const auto& point : stream.first(count)) {
                worker.positions.push_back(point.position);
                worker.rows.push_back(point.row);
            }
            stream = stream.subspan(count);
            selection_.add(leaf, first, std::span(worker.positions).last(count), candidates_[index]);
        });
        MOTE_RETURN_IF_ERROR(file_.write(StepArray::pointPosition,
                                         where.begin * sizeof(storage::PackedPosition),
                                         std::as_bytes(std::span(worker.positions))));
        return file_.write(StepArray::pointRow, where.begin * sizeof(std::uint64_t),
                           std::as_bytes(std::span(worker.rows)));
    }

    /// This rank's candidates by the rank that puts them in order, each window's a list; they are gone then.
    std::vector<Bytes> slices() {
        std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
        std::vector<std::vector<PreviewCandidate>> ofSlice(outgoing.size());
        for (auto& ofWindow : candidates_) {
            for (const auto& candidate : std::exchange(ofWindow, {})) {
                ofSlice[selection_.sliceOf(candidate, ofSlice.size())].push_back(candidate);
            }
            for (std::size_t slice = 0; slice < ofSlice.size(); ++slice) {
                const auto list = std::as_bytes(std::span(ofSlice[slice]));
                const auto begin = addList<PreviewCandidate>(outgoing[slice], ofSlice[slice].size());
                std::copy(list.begin(), list.end(),
                          outgoing[slice].begin() + static_cast<std::ptrdiff_t>(begin));
                ofSlice[slice].clear();
            }
        }
        return outgoing;
    }

    /// Puts this rank's slice in order and writes what of it is in the preview.
    Status writePreview(const std::vector<std::span<const PreviewCandidate>>& lists) {
        const auto sorted = selection_.sorted(lists, own(), static_cast<std::size_t>(ranks_.size()));
        const std::uint64_t size = sorted.size();
        MOTE_ASSIGN_OR_RETURN(const auto sizes, shareValues<std::uint64_t>(ranks_, std::span(&size, 1)));
        std::uint64_t before = 0, all = 0;
        for (std::size_t rank = 0; rank < sizes.size(); ++rank) {
            if (rank == own()) before = all;
            all += sizes[rank].front();
        }
        MOTE_CHECK(all >= previewSize(step_.counts.particles));
        return agree(ranks_, write(selection_.preview(sorted, before)));
    }

    Status write(const BuiltPreview& preview) {
        constexpr auto blockPoints = storage::Preview::blockPoints;
        const std::uint64_t block = (preview.first + blockPoints - 1) / blockPoints;
        MOTE_RETURN_IF_ERROR(file_.write(StepArray::previewPoint,
                                         preview.first * sizeof(storage::PreviewPoint),
                                         std::as_bytes(std::span(preview.points))));
        return file_.write(StepArray::previewThreshold, block * sizeof(float),
                           std::as_bytes(std::span(preview.threshold)));
    }

    const BuiltStep& step_;
    const storage::StepFile& file_;
    Communicator& ranks_;
    std::function<bool()> cancelled_;
    PreviewSelection selection_;
    std::vector<std::vector<PreviewCandidate>> candidates_;  ///< by window
};

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
        if (!output_.rows.empty()) file_->holdRows(output_.rows);
        if (ranks_.size() > 1 || tbb::this_task_arena::max_concurrency() > 1) file_->writeTogether();
        if (!output_.rowsAreRead) file_->leaveRows();
        if (ranks_.first()) file_->hashAhead(output_.cancelled);
        PointOutput points(step_, *file_, ranks_, output_.cancelled);
        MOTE_RETURN_IF_ERROR(ranks_.size() == 1 ? writeAlone(points) : writeTogether(points));
        MOTE_RETURN_IF_ERROR(points.writePreview());
        MOTE_RETURN_IF_ERROR(syncOthers());
        completeTo(static_cast<StepArray>(storage::stepArrays.size()));
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
        MOTE_RETURN_IF_ERROR(file_->write(which, 0, std::as_bytes(std::span(values))));
        if (ranks_.size() == 1) file_->complete(which);
        return success();
    }

    /// All ranks have written what stands before an array in the file.
    void completeTo(StepArray end) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(end); ++i)
            file_->complete(static_cast<StepArray>(i));
    }

    Status writeAlone(PointOutput& points) {
        Status tree = success();
        Status written = success();
        tbb::parallel_invoke([&] { written = points.run(); }, [&] { tree = writeTree(); });
        MOTE_RETURN_IF_ERROR(written);
        MOTE_RETURN_IF_ERROR(tree);
        completeTo(StepArray::previewPoint);
        return success();
    }

    /// What stands first in the file is hashed while points are exchanged and written.
    Status writeTogether(PointOutput& points) {
        MOTE_RETURN_IF_ERROR(agree(ranks_, writeTree()));
        MOTE_RETURN_IF_ERROR(syncOthers());
        completeTo(StepArray::pointPosition);
        MOTE_RETURN_IF_ERROR(points.run());
        MOTE_RETURN_IF_ERROR(syncOthers());
        completeTo(StepArray::previewPoint);
        return success();
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
        const auto size = static_cast<std::size_t>(ranks_.size());
        const auto rank = static_cast<std::size_t>(ranks_.rank());
        return inParallel(parts.size(),
                          [&](std::size_t i) { return i % size == rank ? parts[i]() : success(); });
    }

    /// What the other ranks have written can be read by the first, which hashes it, once they have synced it.
    Status syncOthers() {
        if (ranks_.size() == 1) return success();
        return agree(ranks_, ranks_.first() || ranks_.onOneMachine() ? success() : file_->sync());
    }

    Status hash() { return agree(ranks_, ranks_.first() ? hashWhole() : success()); }

    Status hashWhole() {
        output_.written();
        MOTE_ASSIGN_OR_RETURN(auto hashes, file_->hashes(output_.cancelled));
        output_.complete(std::move(hashes.whole));
        return storage::writeNewFile(output_.directory / (output_.name + ".digest"),
                                     toJson(file_->digest(shape_, hashes.blocks)));
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
