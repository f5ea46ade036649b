// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/point_output.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

using storage::StepArray;

constexpr std::uint64_t windowPoints = std::uint64_t{1} << 19;

Error cancelledError() {
    return {ErrorCode::cancelled, "", "cancelled"};
}

/// The first error, if there is one.
Status firstOf(const std::vector<Status>& all) {
    for (const auto& status : all) MOTE_RETURN_IF_ERROR(status);
    return success();
}

void append(Bytes& bytes, std::span<const std::byte> more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
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
    const std::size_t together = all.front().front() * all.size();
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
            written[i] = cancelled_() ? cancelledError() : gather(window(i), worker);
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
        if (i % size != static_cast<std::size_t>(ranks_.rank())) continue;
        auto& streams = mine.emplace_back(i, std::vector<std::span<const LeafPoint>>()).second;
        for (auto& bytes : rest) {
            const auto count = *reinterpret_cast<const std::uint64_t*>(bytes.data());
            bytes = bytes.subspan(sizeof count);
            streams.emplace_back(reinterpret_cast<const LeafPoint*>(bytes.data()), count);
            bytes = bytes.subspan(count * sizeof(LeafPoint));
        }
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
    std::vector<Worker> workers(last - first);
    std::vector<Status> gathered(last - first, success());
    tbb::parallel_for(first, last,
                      [&](std::size_t i) { gathered[i - first] = gather(window(i), workers[i - first]); });
    MOTE_RETURN_IF_ERROR(firstOf(gathered));
    const auto size = static_cast<std::size_t>(ranks_.size());
    std::vector<Bytes> outgoing(size);
    for (std::size_t i = first; i < last; ++i) {
        auto& bytes = outgoing[i % size];
        bytes.reserve(bytes.size() + sizeof(std::uint64_t) +
                      workers[i - first].gathered.size() * sizeof(LeafPoint));
    }
    for (std::size_t i = first; i < last; ++i) {
        const auto& points = workers[i - first].gathered;
        const std::uint64_t count = points.size();
        append(outgoing[i % size], std::as_bytes(std::span(&count, 1)));
        append(outgoing[i % size], std::as_bytes(std::span(points)));
    }
    return outgoing;
}

/// This rank's points of a window, in their order.
Status PointOutput::gather(const Window& window, Worker& worker) const {
    worker.gathered.clear();
    const auto rank = static_cast<std::size_t>(ranks_.rank());
    const std::uint64_t base = step_.firstPoint[rank];
    Status status = success();
    forEachPart(window, [&](std::size_t leaf, std::uint32_t first, std::size_t count) {
        if (!status.ok() || rankOf(leaf) != rank) return;
        const auto points =
            step_.points.read(step_.octree.leafSource[leaf] - base + first, count, worker.buffer);
        if (!points.ok()) {
            status = points.error();
            return;
        }
        worker.gathered.insert(worker.gathered.end(), points->begin(), points->end());
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

Result<BuiltPreview> PointOutput::preview() {
    if (ranks_.size() == 1) return selection_.choose({candidates_.begin(), candidates_.end()});
    std::vector<std::uint64_t> sizes;
    std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
    for (auto& ofWindow : candidates_) {
        sizes.push_back(ofWindow.size());
        append(outgoing[0], std::as_bytes(std::span(ofWindow)));
        ofWindow = std::vector<PreviewCandidate>();
    }
    MOTE_ASSIGN_OR_RETURN(const auto allSizes, shareValues<std::uint64_t>(ranks_, sizes));
    MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(std::move(outgoing)));
    if (!ranks_.first()) return BuiltPreview();
    // Each window's candidates come from the one rank that wrote it.
    std::vector<std::span<const PreviewCandidate>> lists;
    std::vector<const PreviewCandidate*> next;
    for (const auto& bytes : incoming) {
        next.push_back(reinterpret_cast<const PreviewCandidate*>(bytes.data()));
    }
    for (std::size_t i = 0; i < windowCount(); ++i) {
        for (std::size_t rank = 0; rank < next.size(); ++rank) {
            lists.emplace_back(next[rank], allSizes[rank][i]);
            next[rank] += lists.back().size();
        }
    }
    return selection_.choose(lists);
}

}  // namespace mote::prep
