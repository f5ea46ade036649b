// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/rank_frame.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/scene/mote_check.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/ranks/byte_stream.h"
#include "server/render/ranks/cell_bytes.h"
#include "server/render/ranks/distribution.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {
namespace {

/// Carries a stop that is requested on rank 0 to the work of all ranks, while it lives. Meanwhile nobody else
/// on this rank may call Ranks.
class StopRelay {
  public:
    /// `asked`: of rank 0; not looked at on the others.
    StopRelay(Ranks& ranks, std::uint64_t picture, std::stop_token asked)
        : ranks_(ranks),
          picture_(picture),
          onAsked_(std::move(asked), [this] { source_.request_stop(); }),
          thread_([this] { ranks_.rank() == 0 ? send() : receive(); }) {}
    ~StopRelay() {
        {
            const std::lock_guard lock(mutex_);
            ended_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }
    StopRelay(const StopRelay&) = delete;
    StopRelay& operator=(const StopRelay&) = delete;

    /// The token that stops the work.
    std::stop_token token() const { return source_.get_token(); }

  private:
    void send() {
        std::unique_lock lock(mutex_);
        if (!wake_.wait(lock, source_.get_token(), [this] { return ended_; })) ranks_.sendStop(picture_);
    }
    void receive() {
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, std::chrono::milliseconds(1), [this] { return ended_; })) {
            if (ranks_.stopArrived(picture_)) {
                source_.request_stop();
                return;
            }
        }
    }

    Ranks& ranks_;
    const std::uint64_t picture_;
    std::stop_source source_;
    std::stop_callback<std::function<void()>> onAsked_;
    std::mutex mutex_;
    std::condition_variable_any wake_;
    bool ended_ = false;  // under the mutex
    std::thread thread_;
};

using Counts = std::span<std::uint32_t>;

/// The counts that a rank adds up.
Counts partOf(Counts counts, std::size_t rank, std::size_t ranks) {
    const std::size_t begin = counts.size() * rank / ranks;
    return counts.subspan(begin, counts.size() * (rank + 1) / ranks - begin);
}

Bytes bytesOf(Counts counts) {
    const auto bytes = std::as_bytes(counts);
    return {bytes.begin(), bytes.end()};
}

void add(const Bytes& bytes, Counts sums) {
    MOTE_CHECK(bytes.size() == sums.size_bytes());
    const std::byte* next = bytes.data();
    for (auto& sum : sums) {
        std::uint32_t more = 0;
        std::memcpy(&more, next, sizeof(more));
        next += sizeof(more);
        sum += more;
        if (sum < more) sum = std::numeric_limits<std::uint32_t>::max();
    }
}

/// The sums of all ranks' counts of the points in each pixel, on rank 0; they stay at the greatest number
/// rather than wrap. Each rank adds up a part of them, so none receives more than twice what there is.
void addUpCounts(Ranks& ranks, Counts counts) {
    const auto size = static_cast<std::size_t>(ranks.size()), mine = static_cast<std::size_t>(ranks.rank());
    std::vector<Bytes> outgoing(size);
    for (std::size_t rank = 0; rank < size; ++rank)
        if (rank != mine) outgoing[rank] = bytesOf(partOf(counts, rank, size));
    const auto parts = ranks.exchange(outgoing);
    const Counts own = partOf(counts, mine, size);
    for (std::size_t rank = 0; rank < size; ++rank)
        if (rank != mine) add(parts[rank], own);
    outgoing.assign(size, {});
    if (mine != 0) outgoing[0] = bytesOf(own);
    const auto sums = ranks.exchange(outgoing);
    if (mine != 0) return;
    for (std::size_t rank = 1; rank < size; ++rank) {
        MOTE_CHECK(sums[rank].size() == partOf(counts, rank, size).size_bytes());
        if (!sums[rank].empty())
            std::memcpy(partOf(counts, rank, size).data(), sums[rank].data(), sums[rank].size());
    }
}

/// A picture of points where depth does not matter is the sum of everyone's counts.
std::optional<Picture> drawFlat(Ranks& ranks, CpuParts& parts, const FrameOrder& order, Agreement& agreement,
                                const std::stop_token& stop) {
    agreement.attempt([&] {
        const PointsPlan& only = order.plan.points[*order.flatPoints];
        const StopRelay relay(ranks, order.number, stop);
        parts.arena.execute([&] {
            const auto cells = parts.leaves.of(only.step).upTo(*only.step, only.selection->drawn.size());
            parts.flat.draw(order.plan, only, cells, relay.token());
        });
        only.step->check();
    });
    if (!agreement.all(stop)) return std::nullopt;
    addUpCounts(ranks, parts.flat.counts());
    const auto drawn = ranks.sum(parts.flat.pointsDrawn());
    if (ranks.rank() != 0) return std::nullopt;
    auto picture = parts.arena.execute([&] {
        const auto only = *order.flatPoints;
        return flatPicture(order.plan, order.plan.points[only], parts.flat, order.colors[only].get(),
                           order.format);
    });
    picture.pointsDrawn = drawn;
    return picture;
}

/// One picture in which depth matters, drawn by all ranks in batches of tiles: gather the points of the
/// others' tiles, hand them over, composite one's own.
class MixedFrame {
  public:
    MixedFrame(Ranks& ranks, CpuParts& parts, const FrameOrder& order, Agreement& agreement,
               const std::stop_token& stop);

    /// As drawTogether().
    std::optional<Picture> draw();

  private:
    struct Batch {
        std::uint32_t begin, end;  ///< tiles
    };
    void sort();
    bool drawBatch(Batch batch);
    std::vector<Bytes> gather(Batch batch);
    void composite(Batch batch, const std::vector<Bytes>& incoming);
    void compositeTile(std::uint32_t tile, const std::vector<std::span<const std::byte>>& packed);
    /// Brings the pixels of all tiles to rank 0.
    void collect();
    template <class Visit>
    void forRows(std::uint32_t rank, Visit visit);

    Ranks& ranks_;
    CpuParts& parts_;
    const FrameOrder& order_;
    const FramePlan& plan_;
    Agreement& agreement_;
    const std::stop_token& stop_;
    const TileDistribution tiles_;
    const std::uint32_t rank_;
    std::optional<CompositeFrame> frame_;
    Picture picture_;
};

/// The most bytes that the cells of a tile take that one rank has for another.
std::size_t tileBytes(const FramePlan& plan) {
    const bool points = std::any_of(plan.points.begin(), plan.points.end(),
                                    [](const PointsPlan& one) { return one.pointsDrawn > 0; });
    return points ? mostCellBytes(plan.slabs, plan.points.size()) : 0;
}

/// The messages of one rank, one after another.
Bytes join(const std::vector<Bytes>& tiles) {
    ByteWriter out;
    for (const auto& bytes : tiles) out.putList(bytes);
    return out.take();
}

MixedFrame::MixedFrame(Ranks& ranks, CpuParts& parts, const FrameOrder& order, Agreement& agreement,
                       const std::stop_token& stop)
    : ranks_(ranks),
      parts_(parts),
      order_(order),
      plan_(order.plan),
      agreement_(agreement),
      stop_(stop),
      tiles_(plan_.width, plan_.height, tileBytes(plan_), ranks.size()),
      rank_(static_cast<std::uint32_t>(ranks.rank())) {}

std::optional<Picture> MixedFrame::draw() {
    agreement_.attempt([this] { sort(); });
    for (std::uint32_t begin = 0; begin < tiles_.tiles; begin += tiles_.batch) {
        if (!drawBatch({begin, std::min(tiles_.tiles, begin + tiles_.batch)})) return std::nullopt;
    }
    agreement_.attempt([this] {
        for (const auto& points : plan_.points) points.step->check();
    });
    if (!agreement_.all(stop_)) return std::nullopt;
    collect();
    if (rank_ != 0) return std::nullopt;
    return std::move(picture_);
}

void MixedFrame::sort() {
    const StopRelay relay(ranks_, order_.number, stop_);
    parts_.arena.execute([&] {
        frame_.emplace(plan_, order_.format, parts_.fields.of(plan_), order_.colors);
        parts_.points.sort(plan_, parts_.leaves, order_.colors, relay.token());
        parts_.dots.sort(plan_, relay.token());
    });
    picture_ = {.width = plan_.width, .height = plan_.height, .format = order_.format, .pixels = {}};
    picture_.pixels.resize(std::size_t{plan_.width} * plan_.height * bytesPerPixel(order_.format));
}

bool MixedFrame::drawBatch(Batch batch) {
    // A rank may have been stopped in the middle of its sort: its lists are not to be touched.
    if (!agreement_.all(stop_)) return false;
    std::vector<Bytes> outgoing;
    agreement_.attempt([&] { parts_.arena.execute([&] { outgoing = gather(batch); }); });
    if (!agreement_.all(stop_)) return false;
    const auto incoming = ranks_.exchange(outgoing);
    agreement_.attempt([&] { parts_.arena.execute([&] { composite(batch, incoming); }); });
    return true;
}

std::vector<Bytes> MixedFrame::gather(Batch batch) {
    std::vector<std::vector<Bytes>> tiles(tiles_.ranks);
    for (std::uint32_t rank = 0; rank < tiles_.ranks; ++rank) {
        if (rank != rank_) tiles[rank].resize(tiles_.countOf(rank, batch.begin, batch.end));
    }
    oneapi::tbb::parallel_for(batch.begin, batch.end, [&](std::uint32_t tile) {
        const std::uint32_t owner = tiles_.owner(tile);
        if (owner == rank_ || !parts_.points.any(tiles_.at(tile))) return;
        const std::size_t place = (tile - tiles_.firstOf(owner, batch.begin)) / tiles_.ranks;
        tiles[owner][place] = packCells(parts_.points.gather(tiles_.at(tile)));
    });
    std::vector<Bytes> outgoing;
    for (const auto& ofRank : tiles) outgoing.push_back(join(ofRank));
    return outgoing;
}

void MixedFrame::composite(Batch batch, const std::vector<Bytes>& incoming) {
    const std::uint32_t count = tiles_.countOf(rank_, batch.begin, batch.end);
    // Each tile's bytes lie in the order of the ranks, so that sums are the same every time.
    std::vector<std::vector<std::span<const std::byte>>> packed(count);
    for (const auto& bytes : incoming) {
        if (bytes.empty()) continue;
        ByteReader in(bytes);
        for (auto& tile : packed) tile.push_back(in.getSpan());
    }
    oneapi::tbb::parallel_for(0U, count, [&](std::uint32_t i) {
        compositeTile(tiles_.firstOf(rank_, batch.begin) + i * tiles_.ranks, packed[i]);
    });
}

void MixedFrame::compositeTile(std::uint32_t tile, const std::vector<std::span<const std::byte>>& packed) {
    const Tile at = tiles_.at(tile);
    const TileDots* const dots = parts_.dots.of(at, parts_.points);
    const bool more = std::any_of(packed.begin(), packed.end(), [](auto bytes) { return !bytes.empty(); });
    if (!more && !parts_.points.any(at)) {
        return render::compositeTile(*frame_, at, {}, dots, picture_.pixels.data());
    }
    const auto cells = parts_.points.gather(at);
    for (const auto bytes : packed) {
        if (!bytes.empty()) addCells(bytes, cells);
    }
    for (auto& layer : cells) layer.settle();
    render::compositeTile(*frame_, at, cells, dots, picture_.pixels.data());
}

template <class Visit>
void MixedFrame::forRows(std::uint32_t rank, Visit visit) {
    const std::size_t size = bytesPerPixel(order_.format);
    for (std::uint32_t tile = tiles_.firstOf(rank, 0); tile < tiles_.tiles; tile += tiles_.ranks) {
        const std::uint32_t x = tiles_.at(tile).column * Tile::edge, y = tiles_.at(tile).row * Tile::edge;
        const std::uint32_t columns = std::min(Tile::edge, plan_.width - x);
        for (std::uint32_t row = y; row < std::min(plan_.height, y + Tile::edge); ++row) {
            std::uint8_t* const first = picture_.pixels.data() + (std::size_t{row} * plan_.width + x) * size;
            visit(std::as_writable_bytes(std::span(first, columns * size)));
        }
    }
}

void MixedFrame::collect() {
    std::vector<Bytes> outgoing(tiles_.ranks);
    if (rank_ != 0) {
        forRows(rank_, [&](auto row) { outgoing[0].insert(outgoing[0].end(), row.begin(), row.end()); });
    }
    const auto incoming = ranks_.exchange(outgoing);
    // Every rank has all points that stand alone: rank 0 counts them.
    picture_.pointsDrawn = ranks_.sum(parts_.points.pointsDrawn(rank_ == 0));
    if (rank_ != 0) return;
    for (std::uint32_t rank = 1; rank < tiles_.ranks; ++rank) {
        const auto* next = incoming[rank].data();
        forRows(rank, [&](auto row) {
            std::copy_n(next, row.size(), row.data());
            next += row.size();
        });
    }
}

}  // namespace

void keepOwnPoints(FrameOrder& order, const Ranks& ranks) {
    for (auto& points : order.plan.points) {
        const std::size_t leaves = points.selection->drawn.size();
        const bool alone = !order.flatPoints && standAlone(order.plan, points);
        if (leaves == 0 || alone) continue;
        const LeafDistribution distribution(points.step->leaves().size(), ranks.size());
        points.leavesInView = distribution.own(points.leavesInView, leaves, ranks.rank());
    }
}

std::optional<Picture> drawTogether(Ranks& ranks, CpuParts& parts, const FrameOrder& order,
                                    Agreement& agreement, const std::stop_token& stop) {
    if (order.flatPoints) return drawFlat(ranks, parts, order, agreement, stop);
    return MixedFrame(ranks, parts, order, agreement, stop).draw();
}

bool Agreement::all(const std::stop_token& stop) {
    constexpr std::uint64_t well = 0, stopped = 1, failed = 2;
    const std::uint64_t worst = ranks_.greatest(error_ ? failed : stop.stop_requested() ? stopped : well);
    if (worst == failed) collectErrors();
    return worst == well;
}

void Agreement::collectErrors() {
    ByteWriter mine;
    if (error_) {
        mine.put(error_->code);
        mine.putList(error_->where);
        mine.putList(error_->message);
    }
    std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
    outgoing[0] = mine.take();
    const auto all = ranks_.exchange(outgoing);
    if (ranks_.rank() != 0) return;
    for (std::size_t rank = 0; rank < all.size(); ++rank) {
        if (all[rank].empty()) continue;
        ByteReader in(all[rank]);
        const auto code = in.get<ErrorCode>();
        auto where = in.getList<std::string>();
        error_ = Error{code, std::move(where), in.getList<std::string>()};
        if (rank != 0) error_->message = fmt::format("rank {}: {}", rank, error_->message);
        return;
    }
}

}  // namespace mote::render
