// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/rank_frame.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "protocol/base/mote_check.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/ranks/byte_stream.h"
#include "server/render/ranks/cell_bytes.h"
#include "server/render/ranks/distribution.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/ranks.h"
#include "server/render/ranks/stop_relay.h"

namespace mote::render {
namespace {

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

/// What a rank sends for the sums of counts: made before all agree to add them up.
struct CountMessages {
    CountMessages(const Ranks& ranks, Counts counts) : parts(static_cast<std::size_t>(ranks.size())) {
        const auto mine = static_cast<std::size_t>(ranks.rank());
        for (std::size_t rank = 0; rank < parts.size(); ++rank)
            if (rank != mine) parts[rank] = bytesOf(partOf(counts, rank, parts.size()));
        if (mine != 0) sums.resize(partOf(counts, mine, parts.size()).size_bytes());
    }

    std::vector<Bytes> parts;  ///< of the rank's counts, one a rank
    Bytes sums;                ///< room for those of its own part
};

/// The sums of all ranks' counts of the points in each pixel, on rank 0; they stay at the greatest number
/// rather than wrap. Each rank adds up a part of them, so none receives more than twice what there is.
void addUpCounts(Ranks& ranks, Counts counts, CountMessages messages) noexcept {
    auto& outgoing = messages.parts;
    const auto size = outgoing.size(), mine = static_cast<std::size_t>(ranks.rank());
    const auto parts = ranks.exchange(outgoing);
    const Counts own = partOf(counts, mine, size);
    for (std::size_t rank = 0; rank < size; ++rank)
        if (rank != mine) add(parts[rank], own);
    for (auto& bytes : outgoing) bytes.clear();
    if (mine != 0) {
        const auto bytes = std::as_bytes(own);
        std::copy(bytes.begin(), bytes.end(), messages.sums.begin());
        outgoing[0] = std::move(messages.sums);
    }
    const auto sums = ranks.exchange(outgoing);
    if (mine != 0) return;
    for (std::size_t rank = 1; rank < size; ++rank) {
        MOTE_CHECK(sums[rank].size() == partOf(counts, rank, size).size_bytes());
        if (!sums[rank].empty())
            std::memcpy(partOf(counts, rank, size).data(), sums[rank].data(), sums[rank].size());
    }
}

/// A picture of points if depth does not matter is the sum of everyone's counts.
std::optional<Picture> drawFlat(Ranks& ranks, CpuParts& parts, const FrameOrder& order, Agreement& agreement,
                                const std::stop_token& stop) {
    std::optional<CountMessages> messages;
    agreement.attempt([&] {
        const PointsPlan& only = order.plan.points[*order.flatPoints];
        const StopRelay relay(ranks, order.number, stop);
        parts.arena.execute([&] {
            const auto cells = parts.leaves.of(only.step).upTo(*only.step, only.selection->drawn.size());
            parts.flat.draw(order.plan, only, cells, order.colors[*order.flatPoints].get(), order.format,
                            relay.token());
        });
        only.step->check();
        messages.emplace(ranks, parts.flat.counts());
    });
    if (!agreement.all(stop)) return std::nullopt;
    addUpCounts(ranks, parts.flat.counts(), *std::move(messages));
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

/// Leaves in the order's plan what this rank draws of it; of points that stand alone, all.
void keepOwnPoints(FrameOrder& order, const Ranks& ranks) {
    for (auto& points : order.plan.points) {
        const std::size_t leaves = points.selection->drawn.size();
        const bool alone = !order.flatPoints && standAlone(order.plan, points);
        if (leaves == 0 || alone) continue;
        const LeafDistribution distribution(points.step->leaves().size(), ranks.size());
        points.leavesInView = distribution.own(points.leavesInView, leaves, ranks.rank());
    }
}

}  // namespace

SharedPicture::SharedPicture(Ranks& ranks, CpuParts& parts, FrameOrder order)
    : ranks_(ranks),
      parts_(parts),
      order_(std::move(order)),
      plan_(order_.plan),
      tiles_(plan_.width, plan_.height, tileBytes(plan_), ranks.size()),
      rank_(static_cast<std::uint32_t>(ranks.rank())),
      agreement_(ranks) {}

bool SharedPicture::begin(const std::stop_token& stop) {
    agreement_.attempt([this] { keepOwnPoints(order_, ranks_); });
    if (order_.flatPoints) {
        auto flat = drawFlat(ranks_, parts_, order_, agreement_, stop);
        if (flat) picture_ = *std::move(flat);
        next_ = tiles_.tiles;
        return agreement_.wentOn();
    }
    agreement_.attempt([&] { sort(stop); });
    // A rank may have been stopped in the middle of its sort: its lists are not to be touched.
    if (!agreement_.all(stop)) return false;
    points_ = std::exchange(parts_.points, {});
    dots_ = std::exchange(parts_.dots, {});
    return true;
}

bool SharedPicture::advance(const std::stop_token& pause) {
    agreement_.attempt([this] { parts_.arena.execute([this] { goOn(); }); });
    for (bool first = true; next_ < tiles_.tiles; first = false) {
        if (!first && agreement_.paused(pause)) return false;
        if (!drawBatch()) return true;
    }
    std::vector<Bytes> rows;
    agreement_.attempt([&] {
        for (const auto& points : plan_.points) points.step->check();
        rows = ownRows();
    });
    if (agreement_.all({})) collect(rows);
    return true;
}

Picture SharedPicture::take() {
    giveBack();
    return std::move(picture_);
}

void SharedPicture::giveBack() {
    if (order_.flatPoints) return;
    parts_.points = std::move(points_);
    dots_.forget();
    parts_.dots = std::move(dots_);
}

std::uint64_t SharedPicture::bytes() const {
    return picture_.pixels.capacity() + points_.bytes() + dots_.bytes();
}

void SharedPicture::sort(const std::stop_token& stop) {
    const StopRelay relay(ranks_, order_.number, stop);
    parts_.arena.execute([&] {
        parts_.points.sort(plan_, parts_.leaves, nullptr, order_.colors, relay.token());
        parts_.dots.sort(plan_, relay.token());
    });
    picture_ = {.width = plan_.width, .height = plan_.height, .format = order_.format, .pixels = {}};
    picture_.pixels.resize(std::size_t{plan_.width} * plan_.height * bytesPerPixel(order_.format));
}

/// What others drew meanwhile may have driven blocks and fields out of memory.
void SharedPicture::goOn() {
    if (std::exchange(waited_, true)) points_.verify(plan_);
    frame_.emplace(plan_, order_.format, parts_.fields.of(plan_), order_.colors);
}

bool SharedPicture::drawBatch() {
    const Batch batch{next_, std::min(tiles_.tiles, next_ + tiles_.batch)};
    std::vector<Bytes> outgoing;
    agreement_.attempt([&] { parts_.arena.execute([&] { outgoing = gather(batch); }); });
    if (!agreement_.all({})) return false;
    const auto incoming = ranks_.exchange(outgoing);
    agreement_.attempt([&] { parts_.arena.execute([&] { composite(batch, incoming); }); });
    next_ = batch.end;
    return true;
}

std::vector<Bytes> SharedPicture::gather(Batch batch) {
    std::vector<std::vector<Bytes>> tiles(tiles_.ranks);
    for (std::uint32_t rank = 0; rank < tiles_.ranks; ++rank) {
        if (rank != rank_) tiles[rank].resize(tiles_.countOf(rank, batch.begin, batch.end));
    }
    oneapi::tbb::parallel_for(batch.begin, batch.end, [&](std::uint32_t tile) {
        const std::uint32_t owner = tiles_.owner(tile);
        if (owner == rank_ || !points_.any(tiles_.at(tile))) return;
        const std::size_t place = (tile - tiles_.firstOf(owner, batch.begin)) / tiles_.ranks;
        tiles[owner][place] = packCells(points_.gather(tiles_.at(tile)));
    });
    std::vector<Bytes> outgoing;
    for (const auto& ofRank : tiles) outgoing.push_back(join(ofRank));
    return outgoing;
}

void SharedPicture::composite(Batch batch, const std::vector<Bytes>& incoming) {
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

void SharedPicture::compositeTile(std::uint32_t tile, const std::vector<std::span<const std::byte>>& packed) {
    const Tile at = tiles_.at(tile);
    const TileDots* const dots = dots_.of(at, points_);
    const bool more = std::any_of(packed.begin(), packed.end(), [](auto bytes) { return !bytes.empty(); });
    if (!more && !points_.any(at)) {
        return render::compositeTile(*frame_, at, {}, dots, picture_.pixels.data());
    }
    const auto cells = points_.gather(at);
    for (const auto bytes : packed) {
        if (!bytes.empty()) addCells(bytes, cells);
    }
    for (auto& layer : cells) layer.settle();
    render::compositeTile(*frame_, at, cells, dots, picture_.pixels.data());
}

template <class Visit>
void SharedPicture::forRows(std::uint32_t rank, Visit visit) {
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

std::vector<Bytes> SharedPicture::ownRows() {
    std::vector<Bytes> outgoing(tiles_.ranks);
    if (rank_ != 0) {
        forRows(rank_, [&](auto row) { outgoing[0].insert(outgoing[0].end(), row.begin(), row.end()); });
    }
    return outgoing;
}

void SharedPicture::collect(const std::vector<Bytes>& outgoing) noexcept {
    const auto incoming = ranks_.exchange(outgoing);
    // Every rank has all points that stand alone: rank 0 counts them.
    picture_.pointsDrawn = ranks_.sum(points_.pointsDrawn(rank_ == 0));
    if (rank_ != 0) return;
    for (std::uint32_t rank = 1; rank < tiles_.ranks; ++rank) {
        const auto* next = incoming[rank].data();
        forRows(rank, [&](auto row) {
            std::copy_n(next, row.size(), row.data());
            next += row.size();
        });
    }
}

}  // namespace mote::render
