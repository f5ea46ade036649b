// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/mixed_frame.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "server/render/ranks/byte_stream.h"
#include "server/render/ranks/cell_bytes.h"
#include "server/render/ranks/stop_relay.h"

namespace mote::render {
namespace {

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

}  // namespace

MixedFrame::MixedFrame(Ranks& ranks, RankParts& parts, const FrameOrder& order, Agreement& agreement,
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
        frame_.emplace(plan_, order_.format, parts_.fields.of(plan_));
        parts_.points.sort(plan_, parts_.leaves, relay.token());
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

}  // namespace mote::render
