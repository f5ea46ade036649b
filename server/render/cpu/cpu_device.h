// SPDX-License-Identifier: GPL-3.0-or-later
//
// CpuDevice: draws frame plans on the processor, tile by tile on a given number of threads, by the widest
// vectors there are; docs/RENDERING.md says how. The same plan gives the same bytes for any number of
// threads. Several may live in one process.
#pragma once

#include <memory>

#include "server/render/device.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {

/// "cpu (AVX-512, 2 threads)".
std::string cpuName(int threads);

struct CpuOptions {
    unsigned threads = 0;  ///< 0: as many as the process may use
    /// Of what comes before a picture's first tile, as WorkInTurns.
    WorkInTurns::Duration leastTurn = WorkInTurns::shortTurn;
};

class CpuDevice final : public Device {
  public:
    explicit CpuDevice(CpuOptions options = {});
    ~CpuDevice() override;

    std::string name() const override;
    DeviceAbilities abilities() const override { return {.preview = true}; }
    DeviceCosts costs() override;
    std::optional<Picture> render(const FramePlan& plan, PixelFormat format, std::stop_token stop) override;
    std::unique_ptr<UnfinishedPicture> begin(const FramePlan& plan, PixelFormat format,
                                             std::stop_token stop) override;
    void countTo(const std::shared_ptr<storage::BlockBudget>& budget) override;
    void trim() override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mote::render
