// SPDX-License-Identifier: GPL-3.0-or-later
//
// test-deadly-server: mote-server, whose device dies of certain pictures: 13 pixels wide end the process, 17
// pixels wide break an invariant.
#include <cstdlib>

#include "server/app/server_program.h"

namespace mote::test {
namespace {

class DeadlyDevice final : public render::Device {
  public:
    explicit DeadlyDevice(std::unique_ptr<render::Device> device) : device_(std::move(device)) {}

    std::string name() const override { return device_->name(); }
    render::DeviceAbilities abilities() const override { return device_->abilities(); }
    render::DeviceCosts costs() override { return device_->costs(); }
    void trim() override { device_->trim(); }
    std::optional<render::Picture> render(const render::FramePlan& plan, render::PixelFormat format,
                                          std::stop_token stop) override {
        if (plan.width == 13) std::abort();
        MOTE_CHECK(plan.width != 17);
        return device_->render(plan, format, std::move(stop));
    }

  private:
    std::unique_ptr<render::Device> device_;
};

}  // namespace
}  // namespace mote::test

int main(int argc, char** argv) {
    return mote::server::serverProgram(argc, argv, [](auto kind, unsigned threads) {
        return std::make_unique<mote::test::DeadlyDevice>(mote::render::createDevice(kind, threads));
    });
}
