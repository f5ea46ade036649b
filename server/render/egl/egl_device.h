// SPDX-License-Identifier: GPL-3.0-or-later
//
// EglDevice: draws frame plans with OpenGL compute shaders on EGL without a display; docs/RENDERING.md says
// how. Several may live in one process, each on its own thread; it takes the thread's current context only
// while it works.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/render/device.h"
#include "server/render/egl/egl_context.h"

namespace mote::render {

struct EglOptions {
    std::filesystem::path shaderDirectory;  ///< in place of the embedded shaders; changes are taken up
    std::uint64_t residentBytes = std::uint64_t{4} << 30;  ///< of points kept in the device's memory, about
    std::uint64_t cellBytes = std::uint64_t{128}
                              << 20;  ///< of one pass's cells (pixel and slab with points in it)
    std::uint64_t maskBytes = std::uint64_t{128} << 20;  ///< of the slab masks of a band of the picture
    bool measure = false;  ///< waits for the device after each stage, and notes its time
};

/// How long the stages of the last picture took. Only if EglOptions::measure is set.
struct StageTimes {
    using Duration = std::chrono::duration<double, std::milli>;
    Duration prepare{};  ///< uploads, tables
    Duration volumeMark{};
    Duration pointsMark{};
    Duration allocate{};
    Duration pointsAdd{};
    Duration composite{};
    Duration readBack{};
    std::uint64_t cells = 0;
    std::uint32_t bands = 0;
    std::uint32_t passes = 0;
};

class EglDevice final : public Device {
  public:
    /// Throws DeviceError if there is no OpenGL 4.5.
    explicit EglDevice(EglOptions options = {});
    ~EglDevice() override;

    std::string name() const override;
    DeviceCosts costs() override;
    std::optional<Picture> render(const FramePlan& plan, PixelFormat format, std::stop_token stop) override;
    /// One that is paused keeps its finished bands.
    std::unique_ptr<UnfinishedPicture> begin(const FramePlan& plan, PixelFormat format,
                                             std::stop_token stop) override;
    void countTo(const std::shared_ptr<storage::BlockBudget>& budget) override;
    void trim() override;

    const StageTimes& lastTimes() const;

  private:
    struct State;
    class Unfinished;
    EglContext context_;
    std::unique_ptr<State> state_;
};

}  // namespace mote::render
