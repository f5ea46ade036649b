// SPDX-License-Identifier: GPL-3.0-or-later
//
// UnfinishedPicture: a picture that its device has begun, and that may wait while the device draws others.
// Used on the device's thread; the plan outlives it and stays where it is. It may outlive the device, but
// then it can only go.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "server/render/plan/picture.h"

namespace mote::render {

class UnfinishedPicture {
  public:
    virtual ~UnfinishedPicture() = default;
    /// Draws on until the picture is done or `pause` is requested, but a little in any case: one that is
    /// paused again and again comes to its end, too. Whether it is done. Throws what Device::render throws;
    /// then it is good for nothing more.
    virtual bool advance(const std::stop_token& pause) = 0;
    /// The picture that is done. Once.
    virtual Picture take() = 0;
    /// What it keeps in memory, about, apart from its plan.
    virtual std::uint64_t bytes() const = 0;
    /// It is not gone on with, and its device, which is still there, may have back what it used of it.
    virtual void giveUp() {}
};

/// One that is done already.
std::unique_ptr<UnfinishedPicture> finishedPicture(Picture picture);

}  // namespace mote::render
