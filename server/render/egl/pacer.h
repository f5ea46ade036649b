// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pacer: lets the device work a little ahead of the host and no more, so that a stop request is answered
// within two pieces of work. A value of one frame.
#pragma once

#include <epoxy/gl.h>

#include <stop_token>

namespace mote::render {

class Pacer {
  public:
    explicit Pacer(std::stop_token stop) : stop_(std::move(stop)) {}
    ~Pacer() { glDeleteSync(before_); }
    Pacer(const Pacer&) = delete;
    Pacer& operator=(const Pacer&) = delete;

    /// Called after each piece of work, a few milliseconds long: false where the frame is to be given up.
    bool next() {
        if (stop_.stop_requested()) return false;
        const GLsync now = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        if (before_ != nullptr) glClientWaitSync(before_, GL_SYNC_FLUSH_COMMANDS_BIT, 10'000'000'000);
        glDeleteSync(before_);
        before_ = now;
        return !stop_.stop_requested();
    }
    bool stopped() const { return stop_.stop_requested(); }

  private:
    std::stop_token stop_;
    GLsync before_ = nullptr;
};

}  // namespace mote::render
