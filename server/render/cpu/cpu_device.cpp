// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/cpu_device.h"

#include <stop_token>
#include <utility>

#include "protocol/scene/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/calibration.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/cpu/cpu_picture.h"
#include "server/render/cpu/packet.h"
#include "server/render/cpu/value_sums.h"
#include "server/render/cpu/vectors.h"

namespace mote::render {

struct CpuDevice::State : CpuParts {
    using CpuParts::CpuParts;

    std::unique_ptr<UnfinishedPicture> begin(const FramePlan& plan, PixelFormat format,
                                             const std::stop_token& stop);
    std::optional<Picture> drawFlat(const FramePlan& plan, const PointsPlan& only, const PixelColors* colors,
                                    PixelFormat format, const std::stop_token& stop);
};

/// Null where it was stopped.
std::unique_ptr<UnfinishedPicture> CpuDevice::State::begin(const FramePlan& plan, PixelFormat format,
                                                           const std::stop_token& stop) {
    const auto visible = fields.of(plan);
    auto colors = frameColors(plan, leaves, stop);
    if (!colors) return nullptr;
    if (const auto only = flatPoints(plan, visible)) {
        auto picture = drawFlat(plan, plan.points[*only], (*colors)[*only].get(), format, stop);
        return picture ? finishedPicture(*std::move(picture)) : nullptr;
    }
    if (!points.sort(plan, leaves, *colors, stop)) return nullptr;
    dots.sort(plan, stop);
    if (stop.stop_requested()) return nullptr;
    return std::make_unique<CpuPicture>(*this, plan, format, *std::move(colors));
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
    const auto picture = begin(plan, format, stop);
    if (picture == nullptr || !picture->advance(stop)) return std::nullopt;
    return picture->take();
}

std::unique_ptr<UnfinishedPicture> CpuDevice::begin(const FramePlan& plan, PixelFormat format,
                                                    std::stop_token stop) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && plan.fields.size() <= Packet::mostFields);
    MOTE_CHECK(plan.slabs <= mostSlabs);
    if (stop.stop_requested()) return nullptr;
    if (plan.blank()) return finishedPicture(blankPicture(plan, format));
    return state_->arena.execute([&] { return state_->begin(plan, format, stop); });
}

void CpuDevice::trim() {
    state_->dropExpired();
}

}  // namespace mote::render
