// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/unfinished_picture.h"

#include <utility>

namespace mote::render {
namespace {

class FinishedPicture final : public UnfinishedPicture {
  public:
    explicit FinishedPicture(Picture picture) : picture_(std::move(picture)) {}
    bool advance(const std::stop_token&) override { return true; }
    Picture take() override { return std::move(picture_); }
    std::uint64_t bytes() const override { return picture_.pixels.capacity(); }

  private:
    Picture picture_;
};

}  // namespace

std::unique_ptr<UnfinishedPicture> finishedPicture(Picture picture) {
    return std::make_unique<FinishedPicture>(std::move(picture));
}

}  // namespace mote::render
