// SPDX-License-Identifier: GPL-3.0-or-later
//
// FakeDevice: a device that draws nothing but counts, waits and fails as a test tells it. The test keeps the
// FakeControl, from any thread; the device lives on the thread that renders.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <random>
#include <vector>

#include "server/render/device.h"

namespace mote::test {

class FakeControl {
  public:
    struct Render {
        std::uint32_t width, height;
        render::PixelFormat format;
        render::Quality quality;  // as far as the plan tells: slabs (192 of an exact one), samplesPerCell
        bool stopped = false;
    };

    /// Renders wait until the gate is open; stopped ones do not.
    void closeGate() { setGate(false); }
    void openGate() { setGate(true); }
    /// The next render throws what this makes.
    void failNext(std::function<void()> thrower) {
        const std::lock_guard lock(mutex_);
        failures_.push_back(std::move(thrower));
    }
    /// Waits until that many renders have begun.
    void awaitBegun(std::size_t count) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return renders_.size() >= count; });
    }
    std::vector<Render> renders() const {
        const std::lock_guard lock(mutex_);
        return renders_;
    }
    std::size_t devices() const {
        const std::lock_guard lock(mutex_);
        return devices_;
    }
    void deviceMade() {
        const std::lock_guard lock(mutex_);
        ++devices_;
    }

    /// Of the device: false where it was stopped.
    bool render(const render::FramePlan& plan, render::PixelFormat format, std::stop_token stop) {
        std::unique_lock lock(mutex_);
        const std::size_t index = renders_.size();
        renders_.push_back({plan.width,
                            plan.height,
                            format,
                            {.slabs = plan.exact ? render::Quality::exact().slabs : plan.slabs,
                             .samplesPerCell = plan.samplesPerCell}});
        changed_.notify_all();
        if (!failures_.empty()) {
            const auto thrower = std::move(failures_.front());
            failures_.pop_front();
            thrower();
        }
        if (changed_.wait(lock, stop, [this] { return open_; })) return true;
        renders_[index].stopped = true;
        changed_.notify_all();
        return false;
    }

  private:
    void setGate(bool open) {
        const std::lock_guard lock(mutex_);
        open_ = open;
        changed_.notify_all();
    }

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    bool open_ = true;
    std::vector<Render> renders_;
    std::deque<std::function<void()>> failures_;
    std::size_t devices_ = 0;
};

class FakeDevice final : public render::Device {
  public:
    explicit FakeDevice(std::shared_ptr<FakeControl> control) : control_(std::move(control)) {
        control_->deviceMade();
    }

    std::string name() const override { return "fake"; }
    void trim() override {}
    std::optional<render::Picture> render(const render::FramePlan& plan, render::PixelFormat format,
                                          std::stop_token stop) override {
        if (!control_->render(plan, format, stop)) return std::nullopt;
        render::Picture picture{plan.width, plan.height, format, {}, 0};
        picture.pixels.resize(std::size_t{plan.width} * plan.height * render::bytesPerPixel(format));
        // Noise: its frames are large, so that a client that does not read fills its socket.
        std::minstd_rand random(plan.width);
        for (auto& byte : picture.pixels) byte = static_cast<std::uint8_t>(random() >> 8);
        return picture;
    }

  private:
    std::shared_ptr<FakeControl> control_;
};

}  // namespace mote::test
