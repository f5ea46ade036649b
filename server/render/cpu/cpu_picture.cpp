// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/cpu_picture.h"

#include <oneapi/tbb/parallel_for.h>

#include <atomic>
#include <utility>

#include "server/render/cpu/value_sums.h"
#include "server/render/plan/long_list.h"

namespace mote::render {
namespace {

/// Tiles that a thread draws before it gives way: some milliseconds of a volume that is not easy, or of a
/// surface.
constexpr std::size_t tilesOfATurn = 8, tilesOfSurfaces = 1;

}  // namespace

CpuPicture::CpuPicture(CpuParts& parts, const FramePlan& plan, PixelFormat format,
                       WorkInTurns::Duration leastTurn)
    : parts_(parts),
      plan_(plan),
      leastTurn_(leastTurn),
      picture_{.width = plan.width, .height = plan.height, .format = format, .pixels = {}},
      turns_(parts.arena.max_concurrency()) {}

void CpuPicture::borrowLists() {
    points_ = std::exchange(parts_.points, {});
    dots_ = std::exchange(parts_.dots, {});
    flat_ = std::exchange(parts_.flat, {});
}

/// What a large picture took is nobody's memory when it is done.
void CpuPicture::giveListsBack() {
    constexpr std::uint64_t most = std::uint64_t{16} << 20;
    dots_.forget();
    const auto giveBack = [](auto& to, auto& list) {
        if (list.bytes() <= most) to = std::move(list);
        list = {};
    };
    giveBack(parts_.points, points_);
    giveBack(parts_.dots, dots_);
    giveBack(parts_.flat, flat_);
}

bool CpuPicture::draw(const std::stop_token& stop) {
    borrowLists();
    const bool done = parts_.arena.execute([&] { return prepare(stop) && drawTiles(stop); });
    if (!done) giveListsBack();
    return done;
}

bool CpuPicture::advance(const std::stop_token& pause) {
    if (!prepared_ && !prepareInTurns(pause)) return false;
    return parts_.arena.execute([&] { return drawTiles(pause); });
}

bool CpuPicture::prepareInTurns(const std::stop_token& pause) {
    if (!work_) {
        borrowLists();
        work_.emplace([this] { turns_.execute([this] { prepare({}); }); }, leastTurn_);
    }
    prepared_ = work_->advance(pause);
    if (prepared_)
        work_.reset();
    else
        waited_ = true;
    return prepared_;
}

/// False where it was stopped.
bool CpuPicture::prepare(const std::stop_token& stop) {
    const auto only = flatPoints(plan_, parts_.fields.of(plan_));
    auto colors =
        frameColors(plan_, parts_.leaves, stop, {.count = only.has_value(), .cellsAreShaded = !only});
    if (!colors) return false;
    colors_ = *std::move(colors);
    if (only) return drawFlat(plan_.points[*only], colors_[*only].get(), stop);
    if (!points_.sort(plan_, parts_.leaves, &parts_.groups, colors_, stop)) return false;
    dots_.sort(plan_, stop);
    if (stop.stop_requested()) return false;
    beginTiles();
    return true;
}

bool CpuPicture::drawFlat(const PointsPlan& only, const PixelColors* colors, const std::stop_token& stop) {
    if (colors != nullptr && !colors->counts().empty()) {
        flat_.take(colors->counts(), colors->pointsCounted());
    } else {
        const auto cells = parts_.leaves.of(only.step).upTo(*only.step, only.selection->drawn.size());
        if (!flat_.draw(plan_, only, cells, colors, picture_.format, stop)) return false;
    }
    picture_ = flatPicture(plan_, only, flat_, colors, picture_.format);
    return true;
}

void CpuPicture::beginTiles() {
    resizeInTurns(picture_.pixels, std::size_t{plan_.width} * plan_.height * bytesPerPixel(picture_.format));
    picture_.pointsDrawn = points_.pointsDrawn();
    left_ = std::size_t{tilesAcross(plan_.width)} * tilesAcross(plan_.height);
    done_.resize(left_);
}

bool CpuPicture::drawTiles(const std::stop_token& pause) {
    if (left_ == 0) return true;
    // What others drew meanwhile may have driven blocks out of memory.
    if (std::exchange(waited_, true)) points_.verify(plan_);
    const CompositeFrame frame(plan_, picture_.format, parts_.fields.of(plan_), colors_);
    const std::uint32_t columns = tilesAcross(plan_.width);
    const std::size_t least = (plan_.surfaces.empty() ? tilesOfATurn : tilesOfSurfaces) *
                              static_cast<std::size_t>(parts_.arena.max_concurrency());
    std::atomic<std::size_t> drawn{0};
    // Tile by tile: one may take a hundred times as long as another, and no thread shall wait for the last.
    oneapi::tbb::parallel_for(
        0U, columns * tilesAcross(plan_.height),
        [&](std::uint32_t number) {
            if (done_[number] != 0 || (pause.stop_requested() && drawn >= least)) return;
            drawTile(frame, {number % columns, number / columns});
            done_[number] = 1;
            ++drawn;
        },
        oneapi::tbb::simple_partitioner());
    left_ -= drawn;
    return left_ == 0;
}

void CpuPicture::drawTile(const CompositeFrame& frame, Tile tile) {
    const bool any = points_.any(tile);
    compositeTile(frame, tile, any ? points_.gather(tile) : std::span<TileCells>(), dots_.of(tile, points_),
                  picture_.pixels.data());
}

Picture CpuPicture::take() {
    giveListsBack();
    return std::move(picture_);
}

/// Lists that are sorted in part are sorted anew by who has them next.
void CpuPicture::giveUp() {
    work_.reset();
    giveListsBack();
}

std::uint64_t CpuPicture::bytes() const {
    return picture_.pixels.capacity() + points_.bytes() + dots_.bytes() + flat_.bytes() + done_.capacity();
}

}  // namespace mote::render
