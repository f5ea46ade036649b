// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/ranked_device.h"

#include <fmt/format.h>

#include "protocol/scene/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/cpu/cpu_device.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/packet.h"
#include "server/render/cpu/value_sums.h"
#include "server/render/plan/selection_cache.h"
#include "server/render/ranks/rank_frame.h"

namespace mote::render {
namespace {

template <class Step>
Step held(Result<Step> step) {
    if (!step.ok()) throw storage::StorageError(step.error());
    return *std::move(step);
}

/// Gives an order's plan the rank's own data, and the same selections of them as rank 0 has.
void complete(FrameOrder& order, RankSteps& steps, SelectionCache& selections) {
    for (std::size_t i = 0; i < order.plan.points.size(); ++i) {
        PointsPlan& points = order.plan.points[i];
        points.step = held(steps.open(order.pointSteps[i]));
        if (points.selection == nullptr)
            points.selection = selections.of(points.step, points.fraction, points.share);
    }
    for (std::size_t i = 0; i < order.plan.fields.size(); ++i) {
        auto& samples = order.plan.fields[i].samples;
        if (auto* const cells = std::get_if<DensityField>(&samples)) {
            cells->step = held(steps.open(order.fieldSteps[i]));
        } else {
            std::get<CorrectedField>(samples).grid = held(steps.openGrid(order.fieldSteps[i]));
        }
    }
}

}  // namespace

struct RankedDevice::State {
    FrameOrder orderOf(const FramePlan& plan, PixelFormat format);
    template <class Step>
    RankSteps::Name nameOf(const Step& step) {
        auto name = steps.nameOf(step);
        if (!name.ok()) throw storage::StorageError(name.error());
        return *std::move(name);
    }

    Ranks& ranks;
    RankSteps& steps;
    CpuParts parts;
    std::uint64_t pictures = 0;
};

FrameOrder RankedDevice::State::orderOf(const FramePlan& plan, PixelFormat format) {
    FrameOrder order{.number = ++pictures,
                     .format = format,
                     .flatPoints = {},
                     .pointSteps = {},
                     .fieldSteps = {},
                     .plan = plan,
                     .colors = {}};
    for (const auto& points : plan.points) order.pointSteps.push_back(nameOf(*points.step));
    for (const auto& field : plan.fields) {
        if (const auto* const cells = field.density()) {
            order.fieldSteps.push_back(nameOf(*cells->step));
            continue;
        }
        const CorrectedField& samples = *field.grid();
        order.fieldSteps.push_back(nameOf(*samples.grid));
        // What the field has of what the plan asks for: the rest may be on its way.
        if (samples.corrected()) order.fieldSteps.back().parts = samples.grid->parts;
    }
    order.flatPoints = flatPoints(plan, parts.arena.execute([&] { return parts.fields.of(plan); }));
    return order;
}

RankedDevice::RankedDevice(Ranks& ranks, RankSteps& steps, unsigned threads)
    : state_(new State{ranks, steps, CpuParts(threads)}) {}

RankedDevice::~RankedDevice() = default;

std::string RankedDevice::name() const {
    return fmt::format("{} on {} ranks", cpuName(state_->parts.arena.max_concurrency()),
                       state_->ranks.size());
}

DeviceCosts RankedDevice::costs() {
    // Those of this rank alone, shared out: what the exchange adds, the pictures tell.
    auto costs = CpuDevice({static_cast<unsigned>(state_->parts.arena.max_concurrency())}).costs();
    costs.millionPoints /= state_->ranks.size();
    costs.millionPixels /= state_->ranks.size();
    return costs;
}

DeviceAbilities RankedDevice::abilities() const {
    return {.allPoints = false};
}

std::optional<Picture> RankedDevice::render(const FramePlan& plan, PixelFormat format, std::stop_token stop) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && plan.fields.size() <= Packet::mostFields);
    MOTE_CHECK(plan.slabs <= mostSlabs);
    if (stop.stop_requested()) return std::nullopt;
    if (plan.blank()) return blankPicture(plan, format);
    FrameOrder order = state_->orderOf(plan, format);
    // Rank 0 alone has the values: it reads the points that they colour.
    auto colors = state_->parts.arena.execute([&] { return frameColors(plan, state_->parts.leaves, stop); });
    if (!colors) return std::nullopt;
    order.colors = *std::move(colors);
    auto bytes = packOrder(order);
    state_->ranks.broadcast(bytes);
    Agreement agreement(state_->ranks);
    agreement.attempt([&] { keepOwnPoints(order, state_->ranks); });
    auto picture = drawTogether(state_->ranks, state_->parts, order, agreement, stop);
    if (agreement.failure()) throw storage::StorageError(*agreement.failure());
    return picture;
}

void RankedDevice::trim() {
    state_->parts.dropExpired();
}

void dismissRanks(Ranks& ranks) {
    Bytes nothing;
    ranks.broadcast(nothing);
}

void serveRanks(Ranks& ranks, RankSteps& steps, unsigned threads) {
    CpuParts parts(threads);
    SelectionCache selections;
    std::uint64_t latest = 0;
    for (Bytes bytes;;) {
        ranks.broadcast(bytes);
        if (bytes.empty()) break;
        FrameOrder order = unpackOrder(bytes);
        latest = order.number;
        parts.dropExpired();
        steps.beginPicture();
        Agreement agreement(ranks);
        agreement.attempt([&] {
            parts.arena.execute([&] { complete(order, steps, selections); });
            keepOwnPoints(order, ranks);
        });
        drawTogether(ranks, parts, order, agreement, {});
    }
    // A stop that came too late is not left behind.
    ranks.stopArrived(latest);
}

}  // namespace mote::render
