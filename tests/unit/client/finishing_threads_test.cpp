// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/finishing_threads.h"

#include <gtest/gtest.h>

#include <future>

namespace mote::client {
namespace {

/// A sink on a full disk, whose first frame fails only after the second one has.
class LateFirst : public FrameSink {
  public:
    Status open(bool) override { return success(); }
    bool has(std::size_t, std::string_view, std::uint32_t, std::uint32_t) const override { return false; }
    Status put(DrawnFrame frame) override {
        if (frame.index == 0) second_.get_future().wait();
        if (frame.index == 1) second_.set_value();
        if (frame.index <= 1) return Error{ErrorCode::internal, std::to_string(frame.index), "no space left"};
        return success();
    }
    std::size_t backlog() const override { return 0; }
    Status finish(const std::function<bool(std::size_t)>&) override { return success(); }
    std::filesystem::path fileOf(std::size_t) const override { return {}; }

  private:
    std::promise<void> second_;
};

DrawnFrame frame(std::size_t index) {
    DrawnFrame drawn;
    drawn.index = index;
    return drawn;
}

/// Waits until a frame was finished or failed.
Result<std::vector<std::size_t>> takeSome(FinishingThreads& threads, std::promise<void>& woken) {
    woken.get_future().wait();
    return threads.take();
}

TEST(FinishingThreads, TellTheFirstFrameThatFailedWhicheverFailedFirst) {
    LateFirst sink;
    std::promise<void> woken;
    std::once_flag once;
    FinishingThreads threads(sink, 2, [&] { std::call_once(once, [&] { woken.set_value(); }); });
    threads.post(frame(0));
    threads.post(frame(1));
    const auto taken = takeSome(threads, woken);
    ASSERT_FALSE(taken.ok());
    EXPECT_EQ(taken.error().where, "0");
}

TEST(FinishingThreads, GiveEachFrameOnce) {
    LateFirst sink;
    std::promise<void> woken;
    FinishingThreads threads(sink, 1, [&] { woken.set_value(); });
    threads.post(frame(7));
    const auto taken = takeSome(threads, woken);
    ASSERT_TRUE(taken.ok());
    EXPECT_EQ(*taken, std::vector<std::size_t>{7});
    EXPECT_EQ(threads.open(), 0U);
    EXPECT_TRUE(threads.take()->empty());
}

}  // namespace
}  // namespace mote::client
