// SPDX-License-Identifier: GPL-3.0-or-later
//
// RankedDevice: the cpu device of several ranks, on rank 0, which serves the clients; the others run
// serveRanks(). As Device: made, used and destroyed on the thread that renders; made anew, it goes on with
// the same ranks.
#pragma once

#include <memory>

#include "server/render/device.h"
#include "server/render/ranks/rank_steps.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

class RankedDevice final : public Device {
  public:
    /// `threads`: of this rank; 0: as many as the process may use. The others must outlive it.
    RankedDevice(Ranks& ranks, RankSteps& steps, unsigned threads = 0);
    ~RankedDevice() override;

    std::string name() const override;
    DeviceAbilities abilities() const override;
    DeviceCosts costs() override;
    /// What fails on another rank is a StorageError that names it.
    std::optional<Picture> render(const FramePlan& plan, PixelFormat format, std::stop_token stop) override;
    /// Other ranks keep their parts of a picture that gives way, until they hear that it is gone.
    std::unique_ptr<UnfinishedPicture> begin(const FramePlan& plan, PixelFormat format,
                                             std::stop_token stop) override;
    void countTo(const std::shared_ptr<storage::BlockBudget>& budget) override;
    void trim() override;

  private:
    struct State;
    class Unfinished;
    std::unique_ptr<State> state_;
};

/// Called on rank 0 when no device is left: the others leave serveRanks().
void dismissRanks(Ranks& ranks);

/// Called on the others: draws what rank 0 asks for until it dismisses them. What keeps a rank from its part
/// of a picture fails the picture; what keeps it from taking part at all ends it, and so all of them.
void serveRanks(Ranks& ranks, RankSteps& steps, unsigned threads = 0) noexcept;

}  // namespace mote::render
