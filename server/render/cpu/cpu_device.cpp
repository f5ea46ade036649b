// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/cpu_device.h"

#include <oneapi/tbb/parallel_for.h>

#include <stop_token>

#include "protocol/scene/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/calibration.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/cpu/packet.h"
#include "server/render/cpu/value_sums.h"
#include "server/render/cpu/vectors.h"

namespace mote::render {

struct CpuDevice::State : CpuParts {
    using CpuParts::CpuParts;

    std::optional<Picture> draw(const FramePlan& plan, PixelFormat format, const std::stop_token& stop);
    std::optional<Picture> drawFlat(const FramePlan& plan, const PointsPlan& only, const PixelColors* colors,
                                    PixelFormat format, const std::stop_token& stop);
};

std::optional<Picture> CpuDevice::State::draw(const FramePlan& plan, PixelFormat format,
                                              const std::stop_token& stop) {
    const auto visible = fields.of(plan);
    const auto colors = frameColors(plan, leaves, stop);
    if (!colors) return std::nullopt;
    if (const auto only = flatPoints(plan, visible))
        return drawFlat(plan, plan.points[*only], (*colors)[*only].get(), format, stop);
    if (!points.sort(plan, leaves, *colors, stop)) return std::nullopt;
    dots.sort(plan, stop);
    if (stop.stop_requested()) return std::nullopt;
    const CompositeFrame frame(plan, format, visible, *colors);
    Picture picture{.width = plan.width, .height = plan.height, .format = format, .pixels = {}};
    picture.pixels.resize(std::size_t{plan.width} * plan.height * bytesPerPixel(format));
    picture.pointsDrawn = points.pointsDrawn();
    const std::uint32_t columns = tilesAcross(plan.width);
    oneapi::tbb::parallel_for(0U, columns * tilesAcross(plan.height), [&](std::uint32_t number) {
        if (stop.stop_requested()) return;
        const Tile tile{number % columns, number / columns};
        const bool any = points.any(tile);
        compositeTile(frame, tile, any ? points.gather(tile) : std::span<TileCells>(), dots.of(tile, points),
                      picture.pixels.data());
    });
    if (stop.stop_requested()) return std::nullopt;
    return picture;
}

std::optional<Picture> CpuDevice::State::drawFlat(const FramePlan& plan, const PointsPlan& only,
                                                  const PixelColors* colors, PixelFormat format,
                                                  const std::stop_token& stop) {
    if (colors != nullptr && !colors->counts().empty()) {
        flat.take(colors->counts());
        return flatPicture(plan, only, flat, colors, format);
    }
    const auto cells = leaves.of(only.step).upTo(*only.step, only.selection->drawn.size());
    if (!flat.draw(plan, only, cells, stop)) return std::nullopt;
    return flatPicture(plan, only, flat, colors, format);
}

std::string cpuName(int threads) {
    return "cpu (" + vectorName() + ", " + std::to_string(threads) +
           (threads == 1 ? " thread)" : " threads)");
}

CpuDevice::CpuDevice(CpuOptions options) : state_(std::make_unique<State>(options.threads)) {
    chooseVectors();
}

CpuDevice::~CpuDevice() = default;

std::string CpuDevice::name() const {
    return cpuName(state_->arena.max_concurrency());
}

DeviceCosts CpuDevice::costs() {
    return calibrate(*this);
}

std::optional<Picture> CpuDevice::render(const FramePlan& plan, PixelFormat format, std::stop_token stop) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && plan.fields.size() <= Packet::mostFields);
    MOTE_CHECK(plan.slabs <= mostSlabs);
    if (stop.stop_requested()) return std::nullopt;
    if (plan.blank()) return blankPicture(plan, format);
    return state_->arena.execute([&] { return state_->draw(plan, format, stop); });
}

void CpuDevice::trim() {
    state_->dropExpired();
}

}  // namespace mote::render
