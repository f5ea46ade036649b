// SPDX-License-Identifier: GPL-3.0-or-later
//
// Device: executes a frame plan. One owner, one thread: it is made, used and destroyed on the thread that
// renders (an EGL context is bound to it). What a picture is: docs/PICTURE.md; how a device may approximate:
// Quality.
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "protocol/base/error.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"
#include "server/render/plan/quality.h"
#include "server/render/plan/unfinished_picture.h"
#include "storage/blocks/block_budget.h"

namespace mote::render {

/// Thrown where the device itself fails: no context, out of memory, a shader that does not compile.
class DeviceError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// What pictures with points and volume cost, in milliseconds.
struct DeviceCosts {
    double millionPoints = 25.0;  ///< drawn, in slabs
    double millionPixels = 40.0;  ///< at Quality::exact(), apart from points
};

class Device {
  public:
    virtual ~Device() = default;
    /// "egl (llvmpipe (LLVM 15.0.6, 256 bits))", "cpu (AVX-512, 2 threads)".
    virtual std::string name() const = 0;
    /// What plans for it may ask for.
    virtual DeviceAbilities abilities() const { return {}; }
    /// May draw to find out (calibration.h). Throws DeviceError.
    virtual DeviceCosts costs() { return {}; }
    /// Empty where `stop` was requested before the picture was done: it is asked often enough that a newer
    /// view need not wait for an older one. Throws DeviceError, storage::StorageError.
    virtual std::optional<Picture> render(const FramePlan& plan, PixelFormat format,
                                          std::stop_token stop) = 0;
    /// The same picture, to the byte, as one that may wait while others are drawn. Null where `stop` was
    /// requested before it could. This one draws all of it at once, for devices that keep nothing of a
    /// picture that is stopped. Throws as render().
    virtual std::unique_ptr<UnfinishedPicture> begin(const FramePlan& plan, PixelFormat format,
                                                     std::stop_token stop);
    /// What it makes of steps in main memory, as large as a part of them, counts to `budget` from now on, and
    /// may go for others; null, as at first: to none.
    virtual void countTo(const std::shared_ptr<storage::BlockBudget>& /*budget*/) {}
    /// Frees what it keeps of steps that nobody else holds any more.
    virtual void trim() = 0;
};

enum class DeviceKind { automatic, egl, cpu };

/// Errors: anything but "auto", "egl" and "cpu".
Result<DeviceKind> parseDeviceKind(std::string_view name);

/// `automatic`: egl on a GPU; the processor where EGL fails or would only lead to a software rasteriser.
/// `threads`: of the processor's own device; 0: as many as the process may use. Throws DeviceError.
std::unique_ptr<Device> createDevice(DeviceKind kind, unsigned threads = 0);

}  // namespace mote::render
