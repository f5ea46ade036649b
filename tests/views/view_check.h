// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewCheck: holds one view after another to something. Each keeps its devices and data; one owner, one
// thread.
//
// "difference": a device's exact picture against the reference. "survival": a device draws the view at
// several qualities and gives a picture of the right size each time, or says in a sentence why it cannot.
// "bytes": the cpu device draws the same with every kind of vectors and with one, two and three threads.
// "dissolve": of two layers in place of each of matter, which share its opacity, a device draws the same.
#pragma once

#include <memory>
#include <string>

#include "protocol/mote.pb.h"
#include "tests/views/verdict.h"

namespace mote::test {

class ViewCheck {
  public:
    virtual ~ViewCheck() = default;
    /// Throws nothing that the view can cause: that makes it broken.
    Verdict check(const proto::View& view);

  private:
    virtual Verdict examine(const proto::View& view) = 0;
};

/// `device`: see drawerKinds(); of "bytes" it is the cpu's own. Throws DeviceError, std::invalid_argument.
std::unique_ptr<ViewCheck> viewCheckOf(const std::string& check, const std::string& device);

}  // namespace mote::test
