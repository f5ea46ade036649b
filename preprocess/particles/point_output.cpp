// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/point_output.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_reduce.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "preprocess/job.h"
#include "preprocess/particles/cell_plan.h"
#include "protocol/scene/drawn_points.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

using storage::Preview;

std::uint32_t drawnOf(const Octree& octree, std::size_t leaf, double fraction) {
    const auto node = octree.leafNode[leaf];
    return drawnPoints(fraction, octree.leafPointCount[leaf], octree.level[node], octree.morton[node]);
}

/// All candidates by their fraction, stably. Fractions are spread evenly, so each of many parts is small.
std::vector<PreviewCandidate> sortedByFraction(const std::vector<std::span<const PreviewCandidate>>& lists,
                                               double greatest) {
    std::size_t size = 0;
    for (const auto& list : lists) size += list.size();
    const std::size_t parts = size / 1024 + 1;
    const auto partOf = [&](const PreviewCandidate& candidate) {
        const double at = candidate.from / greatest * static_cast<double>(parts);
        return std::min(parts - 1, static_cast<std::size_t>(at));
    };
    std::vector<std::size_t> next(parts + 1);
    for (const auto& list : lists) {
        for (const auto& candidate : list) ++next[partOf(candidate) + 1];
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    const auto begin = next;
    std::vector<PreviewCandidate> sorted(size);
    for (const auto& list : lists) {
        for (const auto& candidate : list) sorted[next[partOf(candidate)]++] = candidate;
    }
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
        std::stable_sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin[part]),
                         sorted.begin() + static_cast<std::ptrdiff_t>(begin[part + 1]),
                         [](const auto& a, const auto& b) { return a.from < b.from; });
    });
    return sorted;
}

using storage::StepArray;

constexpr std::uint64_t windowPoints = std::uint64_t{1} << 19;

/// The first error, if there is one.
Status firstOf(const std::vector<Status>& all) {
    for (const auto& status : all) MOTE_RETURN_IF_ERROR(status);
    return success();
}

void append(Bytes& bytes, std::span<const std::byte> more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
}

}  // namespace

std::uint64_t previewSize(std::uint64_t points) {
    return std::min<std::uint64_t>(points / 4, Preview::mostPoints);
}

PreviewSelection::PreviewSelection(const Octree& octree)
    : octree_(octree), total_(previewSize(octree.count.front())) {
    if (total_ == 0) return;
    fraction_ = fractionFor(total_);
    const auto& density = octree.leafDensity;
    const auto first = std::upper_bound(density.begin(), density.end(), 0.0F);
    if (first != density.end()) scale_ = {*first, density.back()};
}

/// A fraction that draws at least `total` points, and few more.
double PreviewSelection::fractionFor(std::uint64_t total) const {
    double fraction = static_cast<double>(total) / static_cast<double>(octree_.count.front());
    // The drawn points are as many as wanted but for chance; a fraction of 1 draws all.
    for (; fraction < 1.0; fraction *= 1.01) {
        const auto drawn = tbb::parallel_reduce(
            tbb::blocked_range<std::size_t>(0, octree_.leafNode.size(), 1 << 14), std::uint64_t{0},
            [&](const tbb::blocked_range<std::size_t>& part, std::uint64_t count) {
                for (auto leaf = part.begin(); leaf < part.end(); ++leaf) {
                    count += drawnOf(octree_, leaf, fraction);
                }
                return count;
            },
            std::plus<>());
        if (drawn >= total) break;
    }
    // A little more, so that no point is lost to the rounding of drawnPoints.
    return std::min(1.0, fraction * (1.0 + 1e-9));
}

void PreviewSelection::add(std::size_t leaf, std::uint32_t first,
                           std::span<const storage::PackedPosition> positions,
                           std::vector<PreviewCandidate>& candidates) const {
    if (total_ == 0) return;
    const auto drawn = drawnOf(octree_, leaf, fraction_);
    if (drawn <= first) return;
    const auto node = octree_.leafNode[leaf];
    const unsigned level = octree_.level[node];
    const double offset = leafOffset(octree_.level[node], octree_.morton[node]);
    const auto cell = mortonCell(octree_.morton[node]);
    const double density = octree_.leafDensity[leaf];
    const double t = density > 0.0 ? scale_.ofLeaf(density) : 0.0;
    const auto shade = static_cast<std::uint16_t>(std::lround(65535.0 * t));
    const auto place = [&](std::size_t axis, std::uint16_t within) {
        return static_cast<std::uint16_t>(((std::uint64_t{cell[axis]} << 16) | within) >> level);
    };
    for (std::size_t i = 0; i < std::min<std::size_t>(drawn - first, positions.size()); ++i) {
        const auto& at = positions[i];
        candidates.push_back(
            {drawnFrom(static_cast<std::uint32_t>(first + i), octree_.leafPointCount[leaf], offset),
             {place(0, at.x), place(1, at.y), place(2, at.z), shade}});
    }
}

BuiltPreview PreviewSelection::choose(const std::vector<std::span<const PreviewCandidate>>& lists) const {
    BuiltPreview preview;
    if (total_ == 0) return preview;
    const auto candidates = sortedByFraction(lists, fraction_);
    MOTE_CHECK(candidates.size() >= total_);
    preview.points.resize(total_);
    for (std::size_t i = 0; i < total_; ++i) {
        preview.points[i] = candidates[i].point;
        if (i % Preview::blockPoints == 0)
            preview.threshold.push_back(static_cast<float>(candidates[i].from));
    }
    return preview;
}

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
