// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/point_output.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "preprocess/job.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

using storage::StepArray;

constexpr std::uint64_t windowPoints = std::uint64_t{1} << 19;

/// The first error, if there is one.
Status firstOf(const std::vector<Status>& all) {
    for (const auto& status : all) MOTE_RETURN_IF_ERROR(status);
    return success();
}

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

}  // namespace

PointOutput::PointOutput(const BuiltStep& step, const storage::StepFile& file, Communicator& ranks,
                         std::function<bool()> cancelled)
    : step_(step),
      file_(file),
      ranks_(ranks),
      cancelled_(std::move(cancelled)),
      selection_(step.octree),
      candidates_(windowCount()) {}

std::size_t PointOutput::windowCount() const {
    return (step_.counts.particles + windowPoints - 1) / windowPoints;
}

PointOutput::Window PointOutput::window(std::size_t index) const {
    const std::uint64_t begin = index * windowPoints;
    return {begin, std::min(step_.counts.particles, begin + windowPoints)};
}

/// Calls `use(leaf, first, count)` for the leaves of a window: which of their points lie in it.
template <class Use>
void PointOutput::forEachPart(const Window& window, Use use) const {
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

std::size_t PointOutput::rankOf(std::size_t leaf) const {
    const auto& first = step_.firstPoint;
    const auto after = std::upper_bound(first.begin(), first.end(), step_.octree.leafSource[leaf]);
    return static_cast<std::size_t>(after - first.begin()) - 1;
}

Status PointOutput::run() {
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

Status PointOutput::runAlone() {
    tbb::enumerable_thread_specific<Worker> workers;
    std::vector<Status> written(windowCount(), success());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, windowCount(), 1), [&](const auto& part) {
        auto& worker = workers.local();
        for (auto i = part.begin(); i < part.end(); ++i) {
            worker.gathered.resize(window(i).end - window(i).begin);
            written[i] = cancelled_() ? cancelledError()
                                      : gather(window(i), std::as_writable_bytes(std::span(worker.gathered)));
            if (written[i].ok()) written[i] = write(i, {worker.gathered}, worker);
        }
    });
    return firstOf(written);
}

/// Windows [first, last), in turn one for each rank.
Status PointOutput::runRound(std::size_t first, std::size_t last) {
    auto outgoing = gatherRound(first, last);
    MOTE_RETURN_IF_ERROR(agree(ranks_, outgoing.ok() ? success() : Status(outgoing.error())));
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
    std::vector<Status> written(mine.size(), success());
    tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t i) {
        written[i] = write(mine[i].first, std::move(mine[i].second), workers.local());
    });
    return firstOf(written);
}

/// This rank's points of all windows, by the rank that writes them.
Result<std::vector<Bytes>> PointOutput::gatherRound(std::size_t first, std::size_t last) {
    if (cancelled_()) return cancelledError();
    std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
    std::vector<std::size_t> begin;
    for (std::size_t i = first; i < last; ++i) {
        begin.push_back(addList<LeafPoint>(outgoing[i % outgoing.size()], ownPoints(window(i))));
    }
    std::vector<Status> gathered(last - first, success());
    tbb::parallel_for(first, last, [&](std::size_t i) {
        gathered[i - first] =
            gather(window(i), std::span(outgoing[i % outgoing.size()]).subspan(begin[i - first]));
    });
    MOTE_RETURN_IF_ERROR(firstOf(gathered));
    return outgoing;
}

std::uint64_t PointOutput::ownPoints(const Window& window) const {
    std::uint64_t points = 0;
    forEachPart(window, [&](std::size_t leaf, std::uint32_t, std::size_t count) {
        if (rankOf(leaf) == own()) points += count;
    });
    return points;
}

/// This rank's points of a window, in their order, to the front of `to`.
Status PointOutput::gather(const Window& window, std::span<std::byte> to) const {
    const std::uint64_t base = step_.firstPoint[own()];
    std::vector<LeafPoint> buffer;
    Status status = success();
    forEachPart(window, [&](std::size_t leaf, std::uint32_t first, std::size_t count) {
        if (!status.ok() || rankOf(leaf) != own()) return;
        const auto points = step_.points.read(step_.octree.leafSource[leaf] - base + first, count, buffer);
        if (!points.ok()) {
            status = points.error();
            return;
        }
        std::memcpy(to.data(), points->data(), points->size_bytes());
        to = to.subspan(points->size_bytes());
    });
    return status;
}

Status PointOutput::write(std::size_t index, std::vector<std::span<const LeafPoint>> streams,
                          Worker& worker) {
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
    MOTE_RETURN_IF_ERROR(file_.write(StepArray::pointPosition, where.begin * sizeof(storage::PackedPosition),
                                     std::as_bytes(std::span(worker.positions))));
    return file_.write(StepArray::pointRow, where.begin * sizeof(std::uint64_t),
                       std::as_bytes(std::span(worker.rows)));
}

Status PointOutput::writePreview() {
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

/// This rank's candidates by the rank that puts them in order, each window's a list; they are gone then.
std::vector<Bytes> PointOutput::slices() {
    std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
    std::vector<std::vector<PreviewCandidate>> ofSlice(outgoing.size());
    for (auto& ofWindow : candidates_) {
        for (const auto& candidate : std::exchange(ofWindow, {})) {
            ofSlice[selection_.sliceOf(candidate, ofSlice.size())].push_back(candidate);
        }
        for (std::size_t slice = 0; slice < ofSlice.size(); ++slice) {
            const auto list = std::as_bytes(std::span(ofSlice[slice]));
            const auto begin = addList<PreviewCandidate>(outgoing[slice], ofSlice[slice].size());
            std::copy(list.begin(), list.end(), outgoing[slice].begin() + static_cast<std::ptrdiff_t>(begin));
            ofSlice[slice].clear();
        }
    }
    return outgoing;
}

/// Puts this rank's slice in order and writes what of it is in the preview.
Status PointOutput::writePreview(const std::vector<std::span<const PreviewCandidate>>& lists) {
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

Status PointOutput::write(const BuiltPreview& preview) {
    constexpr auto blockPoints = storage::Preview::blockPoints;
    const std::uint64_t block = (preview.first + blockPoints - 1) / blockPoints;
    MOTE_RETURN_IF_ERROR(file_.write(StepArray::previewPoint, preview.first * sizeof(storage::PreviewPoint),
                                     std::as_bytes(std::span(preview.points))));
    return file_.write(StepArray::previewThreshold, block * sizeof(float),
                       std::as_bytes(std::span(preview.threshold)));
}

}  // namespace mote::prep
