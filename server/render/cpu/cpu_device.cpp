// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/cpu_device.h"

#include <stop_token>
#include <utility>

#include "protocol/base/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/calibration.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/cpu/cpu_picture.h"
#include "server/render/cpu/vectors.h"

namespace mote::render {
namespace {

void check(const FramePlan& plan) {
    MOTE_CHECK(plan.width > 0 && plan.height > 0 && plan.fields.size() <= Packet::mostFields);
    MOTE_CHECK(plan.slabs <= mostSlabs);
}

}  // namespace

struct CpuDevice::State : CpuParts {
    explicit State(const CpuOptions& options) : CpuParts(options.threads), leastTurn(options.leastTurn) {}

    const WorkInTurns::Duration leastTurn;
};

std::string cpuName(int threads) {
    return "cpu (" + vectorName() + ", " + std::to_string(threads) +
           (threads == 1 ? " thread)" : " threads)");
}

CpuDevice::CpuDevice(CpuOptions options) : state_(std::make_unique<State>(options)) {
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
    check(plan);
    if (stop.stop_requested()) return std::nullopt;
    if (plan.blank()) return blankPicture(plan, format);
    CpuPicture picture(*state_, plan, format, state_->leastTurn);
    if (!picture.draw(stop)) return std::nullopt;
    return picture.take();
}

std::unique_ptr<UnfinishedPicture> CpuDevice::begin(const FramePlan& plan, PixelFormat format,
                                                    std::stop_token stop) {
    check(plan);
    if (stop.stop_requested()) return nullptr;
    if (plan.blank()) return finishedPicture(blankPicture(plan, format));
    return std::make_unique<CpuPicture>(*state_, plan, format, state_->leastTurn);
}

void CpuDevice::countTo(const std::shared_ptr<storage::BlockBudget>& budget) {
    state_->fields.countTo(budget);
}

void CpuDevice::trim() {
    state_->dropExpired();
}

}  // namespace mote::render
