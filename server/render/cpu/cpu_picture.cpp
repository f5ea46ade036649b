// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/cpu_picture.h"

#include <oneapi/tbb/parallel_for.h>

#include <atomic>
#include <utility>

namespace mote::render {
namespace {

/// Tiles that a thread draws before it gives way: some milliseconds of a volume that is not easy.
constexpr std::size_t tilesOfATurn = 8;

}  // namespace

CpuPicture::CpuPicture(CpuParts& parts, const FramePlan& plan, PixelFormat format, FrameColors colors)
    : parts_(parts),
      plan_(plan),
      colors_(std::move(colors)),
      points_(std::exchange(parts.points, {})),
      dots_(std::exchange(parts.dots, {})),
      picture_{.width = plan.width, .height = plan.height, .format = format, .pixels = {}},
      left_(std::size_t{tilesAcross(plan.width)} * tilesAcross(plan.height)) {
    picture_.pixels.resize(std::size_t{plan.width} * plan.height * bytesPerPixel(format));
    picture_.pointsDrawn = points_.pointsDrawn();
    done_.resize(left_);
}

bool CpuPicture::advance(const std::stop_token& pause) {
    return parts_.arena.execute([&] { return drawTiles(pause); });
}

bool CpuPicture::drawTiles(const std::stop_token& pause) {
    // What others drew meanwhile may have driven blocks out of memory.
    if (std::exchange(waited_, true)) points_.verify(plan_);
    const CompositeFrame frame(plan_, picture_.format, parts_.fields.of(plan_), colors_);
    const std::uint32_t columns = tilesAcross(plan_.width);
    const std::size_t least = tilesOfATurn * static_cast<std::size_t>(parts_.arena.max_concurrency());
    std::atomic<std::size_t> drawn{0};
    oneapi::tbb::parallel_for(0U, columns * tilesAcross(plan_.height), [&](std::uint32_t number) {
        if (done_[number] != 0 || (pause.stop_requested() && drawn >= least)) return;
        drawTile(frame, {number % columns, number / columns});
        done_[number] = 1;
        ++drawn;
    });
    left_ -= drawn;
    return left_ == 0;
}

void CpuPicture::drawTile(const CompositeFrame& frame, Tile tile) {
    const bool any = points_.any(tile);
    compositeTile(frame, tile, any ? points_.gather(tile) : std::span<TileCells>(), dots_.of(tile, points_),
                  picture_.pixels.data());
}

Picture CpuPicture::take() {
    parts_.points = std::move(points_);
    parts_.dots = std::move(dots_);
    return std::move(picture_);
}

std::uint64_t CpuPicture::bytes() const {
    return picture_.pixels.capacity() + points_.bytes() + dots_.bytes() + done_.capacity();
}

}  // namespace mote::render
