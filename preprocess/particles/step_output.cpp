// SPDX-License-Identifier: GPL-3.0-or-later

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <numeric>
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

constexpr std::uint64_t windowPoints = std::uint64_t{1}
                                       << 19;  // at most in a window, with those of pointsPerLeaf

// Neighbours in the file lie far apart in memory: points are asked for so many leaves before they are read.
constexpr std::size_t leavesAhead = 16;

/// Of the points of a leaf, which lie one after another among all in Morton order.
struct WantedPoints {
    std::uint32_t source, count;
};

/// Writes the points of this rank's slice of the leaves, a window of them at a time, and then the preview.
class PointOutput {
  public:
    /// All references outlive this.
    PointOutput(const BuiltStep& step, const storage::StepFile& file, Communicator& ranks,
                std::function<bool()> cancelled, PreviewSelection selection)
        : step_(step),
          file_(file),
          ranks_(ranks),
          cancelled_(std::move(cancelled)),
          selection_(selection),
          windows_(cutWindows(step.octree, step.octree.slicePoint[own()])),
          previewSlices_(shareOut(size())),
          candidates_(windowCount()) {}

    /// Writes the points of all windows. Errors: resourceExhausted (disk full), cancelled, internal; the same
    /// on all ranks.
    Status run() {
        MOTE_RETURN_IF_ERROR(ask());
        const std::array<std::size_t, 2> mine{
            windowCount(), static_cast<std::size_t>(tbb::this_task_arena::max_concurrency())};
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::size_t>(ranks_, mine));
        std::size_t most = 1;
        for (const auto& of : all) most = std::max(most, of[0]);
        // Ranks may differ in their threads, not in what they expect of each other.
        const std::size_t together = size() == 1 ? most : 2 * all.front()[1];
        return exchangeInRounds(
            ranks_, (most + together - 1) / together,
            [&](std::size_t round) { return gatherRound(round * together, (round + 1) * together); },
            [&](std::size_t round, const std::vector<Bytes>& incoming) {
                return writeRound(round * together, (round + 1) * together, incoming);
            });
    }

    /// Writes the preview, after run(), whose points are no more needed. Errors: as run(), resourceExhausted.
    Status writePreview(std::shared_ptr<StoreMemory> memory) {
        MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(othersCandidates()));
        std::vector<std::span<const PreviewCandidate>> lists;
        std::uint64_t size = 0;
        for (std::size_t rank = 0; rank < incoming.size(); ++rank) {
            if (rank == own()) {
                lists.insert(lists.end(), candidates_.begin(), candidates_.end());
            } else {
                lists.push_back(spanOf<PreviewCandidate>(incoming[rank]));
            }
        }
        for (const auto& list : lists) size += list.size();
        auto room = RecordStore::inMemory(size * sizeof(PreviewCandidate), std::move(memory));
        MOTE_RETURN_IF_ERROR(agree(ranks_, room));
        const auto sorted = room->room<PreviewCandidate>(0, size);
        selection_.sort(lists, previewSlices_[own()], previewSlices_[own() + 1], previewSlices_.back(),
                        sorted);
        return writePreview(sorted);
    }

  private:
    /// Points of the file that are gathered and written at once.
    struct Window {
        std::uint64_t begin, end;
    };
    /// A thread's memory.
    struct Worker {
        std::vector<LeafPoint> buffer;
        std::vector<storage::PackedPosition> positions;
        std::vector<std::uint64_t> rows;
    };
    /// What another rank wants of this one's points, in their order.
    struct Wanted {
        std::vector<std::uint64_t> points;  ///< by window of that rank
        std::vector<std::size_t> first;     ///< by window, where it begins in the list
        std::vector<WantedPoints> list;

        std::span<const WantedPoints> ofWindow(std::size_t i) const {
            return std::span(list).subspan(first[i], first[i + 1] - first[i]);
        }
    };
    /// By rank, what came of it for a window.
    using Streams = std::vector<std::span<const LeafPoint>>;

    std::size_t own() const { return static_cast<std::size_t>(ranks_.rank()); }
    std::size_t size() const { return static_cast<std::size_t>(ranks_.size()); }

    std::size_t windowCount() const { return windows_.size() - 1; }

    Window window(std::size_t index) const { return {windows_[index], windows_[index + 1]}; }

    /// The first point of each window of this rank's slice, and one more.
    static std::vector<std::uint64_t> cutWindows(const Octree& octree, std::uint64_t begin) {
        std::vector<std::uint64_t> windows{begin};
        std::uint64_t leaves = 0;
        for (const auto points : octree.leafPointCount) {
            const std::uint64_t end = begin + points;
            ++leaves;
            while (end - windows.back() + leaves * pointsPerLeaf >= windowPoints) {
                windows.push_back(std::min(end, windows.back() + windowPoints));
                leaves = 0;
                if (windows.back() == end) break;
            }
            begin = end;
        }
        if (windows.back() < begin) windows.push_back(begin);
        return windows;
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

    /// Tells the others what this rank wants of their points, and learns what they want.
    Status ask() {
        if (size() == 1) {
            wanted_.resize(1);
            return success();
        }
        std::vector<std::vector<std::uint64_t>> points(size(), std::vector<std::uint64_t>(windowCount()));
        std::vector<std::vector<std::uint64_t>> parts = points;
        std::vector<std::vector<WantedPoints>> lists(size());
        for (std::size_t i = 0; i < windowCount(); ++i) {
            forEachPart(window(i), [&](std::size_t leaf, std::uint32_t first, std::size_t count) {
                const std::size_t rank = rankOf(leaf);
                if (rank == own()) return;
                points[rank][i] += count;
                ++parts[rank][i];
                lists[rank].push_back(
                    {step_.octree.leafSource[leaf] + first, static_cast<std::uint32_t>(count)});
            });
        }
        std::vector<Bytes> outgoing(size());
        for (std::size_t rank = 0; rank < size(); ++rank) {
            if (rank == own()) continue;
            addList<std::uint64_t>(outgoing[rank], points[rank]);
            addList<std::uint64_t>(outgoing[rank], parts[rank]);
            addList<WantedPoints>(outgoing[rank], std::exchange(lists[rank], {}));
        }
        MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(std::move(outgoing)));
        wanted_.resize(size());
        for (std::size_t rank = 0; rank < size(); ++rank) {
            if (rank == own()) continue;
            std::span<const std::byte> rest(incoming[rank]);
            const auto ofWindow = takeList<std::uint64_t>(rest);
            const auto partsOf = takeList<std::uint64_t>(rest);
            const auto list = takeList<WantedPoints>(rest);
            auto& wanted = wanted_[rank];
            wanted.points.assign(ofWindow.begin(), ofWindow.end());
            wanted.first.resize(partsOf.size() + 1);
            std::inclusive_scan(partsOf.begin(), partsOf.end(), wanted.first.begin() + 1);
            wanted.list.assign(list.begin(), list.end());
        }
        return success();
    }

    /// What this rank has of windows [first, last) of the others, as far as they have so many.
    Result<std::vector<Bytes>> gatherRound(std::size_t first, std::size_t last) {
        std::vector<Bytes> outgoing(size());
        std::vector<std::function<Status()>> work;
        for (std::size_t rank = 0; rank < size(); ++rank) {
            const auto& points = wanted_[rank].points;
            const std::size_t end = std::min(last, points.size());
            std::size_t bytes = 0;
            for (std::size_t i = first; i < end; ++i) bytes += listBytes<LeafPoint>(points[i]);
            outgoing[rank].reserve(bytes);
            for (std::size_t i = first; i < end; ++i) {
                const std::size_t at = addRoom<LeafPoint>(outgoing[rank], points[i]);
                work.emplace_back([this, &to = outgoing[rank], rank, i, at] {
                    return gather(wanted_[rank].ofWindow(i), std::span(to).subspan(at));
                });
            }
        }
        MOTE_RETURN_IF_ERROR(inParallel(work.size(), [&](std::size_t i) { return work[i](); }));
        return outgoing;
    }

    /// Windows [first, last) of this rank, as far as it has so many, with what others have of them.
    Status writeRound(std::size_t first, std::size_t last, const std::vector<Bytes>& incoming) {
        const std::size_t begin = std::min(first, windowCount());
        const std::size_t end = std::min(last, windowCount());
        std::vector<Streams> streams(end - begin, Streams(size()));
        for (std::size_t rank = 0; rank < size(); ++rank) {
            std::span<const std::byte> rest(incoming[rank]);
            for (std::size_t i = 0; rank != own() && i < streams.size(); ++i)
                streams[i][rank] = takeList<LeafPoint>(rest);
        }
        tbb::enumerable_thread_specific<Worker> workers;
        return inParallel(end - begin, [&](std::size_t i) -> Status {
            if (cancelled_()) return wasCancelled();
            return write(begin + i, streams[i], workers.local());
        });
    }

    /// Points of this rank to the front of `to`.
    Status gather(std::span<const WantedPoints> wanted, std::span<std::byte> to) const {
        const std::uint64_t base = step_.firstPoint[own()];
        std::vector<LeafPoint> buffer;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            if (i + leavesAhead < wanted.size())
                step_.points.expect<LeafPoint>(wanted[i + leavesAhead].source - base,
                                               wanted[i + leavesAhead].count);
            MOTE_ASSIGN_OR_RETURN(const auto points,
                                  step_.points.read(wanted[i].source - base, wanted[i].count, buffer));
            std::memcpy(to.data(), points.data(), points.size_bytes());
            to = to.subspan(points.size_bytes());
        }
        return success();
    }

    /// `streams` are used up.
    Status write(std::size_t index, Streams& streams, Worker& worker) {
        const auto where = window(index);
        worker.positions.resize(where.end - where.begin);
        worker.rows.resize(where.end - where.begin);
        std::size_t at = 0;
        Status status = success();
        auto& candidates = candidates_[index];
        candidates.reserve(selection_.expected(where.end - where.begin) * 5 / 4 + 1024);
        forEachPart(where, [&](std::size_t leaf, std::uint32_t first, std::size_t count) {
            expectPoints(leaf + leavesAhead);
            const auto points = pointsOf(leaf, first, count, streams, worker);
            if (!points.ok()) {
                status = points.error();
                return;
            }
            const auto positions = std::span(worker.positions).subspan(at, count);
            for (std::size_t i = 0; i < count; ++i) {
                positions[i] = (*points)[i].position;
                worker.rows[at + i] = (*points)[i].row;
            }
            at += count;
            selection_.add(leaf, first, positions, candidates);
        });
        MOTE_RETURN_IF_ERROR(status);
        MOTE_RETURN_IF_ERROR(file_.write(StepArray::pointPosition,
                                         where.begin * sizeof(storage::PackedPosition),
                                         std::as_bytes(std::span(worker.positions))));
        return file_.write(StepArray::pointRow, where.begin * sizeof(std::uint64_t),
                           std::as_bytes(std::span(worker.rows)));
    }

    /// Asks for a leaf's points, if they are this rank's.
    void expectPoints(std::size_t leaf) const {
        if (leaf >= step_.octree.leafNode.size() || rankOf(leaf) != own()) return;
        step_.points.expect<LeafPoint>(step_.octree.leafSource[leaf] - step_.firstPoint[own()],
                                       step_.octree.leafPointCount[leaf]);
    }

    /// Points [first, first + count) of a leaf. Those of other ranks are taken off the front of their stream.
    Result<std::span<const LeafPoint>> pointsOf(std::size_t leaf, std::uint32_t first, std::size_t count,
                                                Streams& streams, Worker& worker) const {
        const std::size_t rank = rankOf(leaf);
        if (rank == own()) {
            const auto source = step_.octree.leafSource[leaf] - step_.firstPoint[rank] + first;
            return step_.points.read(source, count, worker.buffer);
        }
        auto& stream = streams[rank];
        MOTE_CHECK(stream.size() >= count);
        const auto points = stream.first(count);
        stream = stream.subspan(count);
        return points;
    }

    /// Candidates that other ranks put in order, by rank; this one keeps the rest.
    std::vector<Bytes> othersCandidates() {
        std::vector<Bytes> outgoing(size());
        if (size() == 1) return outgoing;
        std::vector<std::size_t> next(size());
        for (const auto& ofWindow : candidates_) {
            for (const auto& candidate : ofWindow) ++next[ownerOf(candidate)];
        }
        for (std::size_t rank = 0; rank < size(); ++rank) {
            const std::size_t count = std::exchange(next[rank], 0);
            if (rank != own()) outgoing[rank].resize(count * sizeof(PreviewCandidate));
        }
        for (auto& ofWindow : candidates_) {
            std::size_t kept = 0;
            for (const auto& candidate : ofWindow) {
                const std::size_t rank = ownerOf(candidate);
                if (rank == own()) {
                    ofWindow[kept++] = candidate;
                } else {
                    std::memcpy(outgoing[rank].data() + next[rank], &candidate, sizeof candidate);
                    next[rank] += sizeof candidate;
                }
            }
            ofWindow.resize(kept);
        }
        return outgoing;
    }

    std::size_t ownerOf(const PreviewCandidate& candidate) const {
        const std::size_t slice = selection_.sliceOf(candidate, previewSlices_.back());
        const auto after = std::upper_bound(previewSlices_.begin(), previewSlices_.end(), slice);
        return static_cast<std::size_t>(after - previewSlices_.begin()) - 1;
    }

    /// The first of each rank's slices of the preview, and one more: fewer for rank 0, which makes the hashes
    /// of all points meanwhile, in .4 times the time that one rank would need for the whole preview.
    static std::vector<std::size_t> shareOut(std::size_t ranks) {
        if (ranks == 1) return {0, 1};
        constexpr std::size_t hashes = 4, whole = 10;
        const std::size_t each = (whole + hashes) * (ranks - 1);  // of ranks * whole * (ranks - 1) slices
        const std::size_t least = hashes * ranks * (ranks - 1);
        const std::size_t all = whole * ranks * (ranks - 1);
        const std::size_t first = each > least ? each - least : 0;
        std::vector<std::size_t> begin{0};
        for (std::size_t rank = 0; rank < ranks; ++rank)
            begin.push_back(first + (all - first) * rank / (ranks - 1));
        return begin;
    }

    /// Writes what of this rank's slices is in the preview.
    Status writePreview(std::span<const PreviewCandidate> sorted) {
        const std::uint64_t size = sorted.size();
        MOTE_ASSIGN_OR_RETURN(const auto sizes, shareValues<std::uint64_t>(ranks_, std::span(&size, 1)));
        std::uint64_t before = 0, all = 0;
        for (std::size_t rank = 0; rank < sizes.size(); ++rank) {
            if (rank == own()) before = all;
            all += sizes[rank].front();
        }
        MOTE_CHECK(all >= previewSize(step_.counts.particles));
        constexpr std::size_t together = std::size_t{1} << 18;
        return agree(ranks_, inParallel((sorted.size() + together - 1) / together, [&](std::size_t i) {
                         const auto piece =
                             sorted.subspan(i * together, std::min(together, sorted.size() - i * together));
                         return write(selection_.preview(piece, before + i * together));
                     }));
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
    std::vector<std::uint64_t> windows_;                     ///< cutWindows()
    std::vector<std::size_t> previewSlices_;                 ///< shareOut()
    std::vector<Wanted> wanted_;                             ///< by rank
    std::vector<std::vector<PreviewCandidate>> candidates_;  ///< by window
};

using storage::StepFile;

class StepFiles {
  public:
    StepFiles(BuiltStep& step, const StepOutput& output)
        : step_(step),
          output_(output),
          ranks_(*output.ranks),
          path_(output.directory / (output.name + ".h5")) {
        const auto points = step.counts.particles;
        shape_ = {step.octree.nodeTotal, step.octree.leafTotal, points, previewSize(points), step.volumeSize};
    }

    Result<StepFile::Places> run() {
        MOTE_RETURN_IF_ERROR(openFile());
        if (!output_.rows.empty()) file_->holdRows(output_.rows);
        if (!output_.rowsAreRead) file_->leaveRows();
        if (ranks_.first()) file_->hashAhead(output_.cancelled);
        MOTE_ASSIGN_OR_RETURN(auto selection, PreviewSelection::make(step_.octree, ranks_));
        PointOutput points(step_, *file_, ranks_, output_.cancelled, selection);
        MOTE_RETURN_IF_ERROR(ranks_.size() == 1 ? writeAlone(points) : writeTogether(points));
        step_.points = RecordStore();
        MOTE_RETURN_IF_ERROR(points.writePreview(output_.stores));
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

    /// What this rank has of an array of nodes.
    template <class T>
    Status writeNodes(StepArray which, const std::vector<T>& values) {
        for (const auto& run : step_.octree.runs) {
            MOTE_RETURN_IF_ERROR(
                file_->write(which, run.place * sizeof(T),
                             std::as_bytes(std::span(values).subspan(run.first, run.count))));
        }
        return written(which);
    }

    template <class T>
    Status writeLeaves(StepArray which, const std::vector<T>& values) {
        MOTE_RETURN_IF_ERROR(
            file_->write(which, step_.octree.leafBefore * sizeof(T), std::as_bytes(std::span(values))));
        return written(which);
    }

    /// Of the volume, which all ranks know, each writes as much.
    Status writeVolume() {
        const auto size = static_cast<std::size_t>(ranks_.size());
        const auto rank = static_cast<std::size_t>(ranks_.rank());
        const auto& volume = step_.volume;
        const std::size_t begin = volume.size() * rank / size, end = volume.size() * (rank + 1) / size;
        MOTE_RETURN_IF_ERROR(file_->write(StepArray::volumeDensity, begin * sizeof(float),
                                          std::as_bytes(std::span(volume).subspan(begin, end - begin))));
        return written(StepArray::volumeDensity);
    }

    Status written(StepArray which) {
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

    /// Octree, leaves and volume, as far as they are this rank's.
    Status writeTree() {
        const auto& tree = step_.octree;
        const std::vector<std::function<Status()>> parts{
            [&] { return writeNodes(StepArray::octreeLevel, tree.level); },
            [&] { return writeNodes(StepArray::octreeMorton, tree.morton); },
            [&] { return writeNodes(StepArray::octreeFirstChild, tree.firstChild); },
            [&] { return writeNodes(StepArray::octreeChildCount, tree.childCount); },
            [&] { return writeNodes(StepArray::octreeCount, tree.count); },
            [&] { return writeNodes(StepArray::octreeDensity, tree.density); },
            [&] { return writeNodes(StepArray::octreeMinDensity, tree.minDensity); },
            [&] { return writeLeaves(StepArray::leafNode, tree.leafNode); },
            [&] { return writeLeaves(StepArray::leafPointBegin, tree.leafPointBegin); },
            [&] { return writeLeaves(StepArray::leafPointCount, tree.leafPointCount); },
            [&] { return writeLeaves(StepArray::leafDensity, tree.leafDensity); },
            [&] { return writeVolume(); },
        };
        return inParallel(parts.size(), [&](std::size_t i) { return parts[i](); });
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

    BuiltStep& step_;
    const StepOutput& output_;
    Communicator& ranks_;
    std::filesystem::path path_;
    storage::StepShape shape_;
    std::optional<StepFile> file_;
};

}  // namespace

Result<StepFile::Places> writeBuiltStep(BuiltStep& step, const StepOutput& output) {
    return StepFiles(step, output).run();
}

}  // namespace mote::prep
