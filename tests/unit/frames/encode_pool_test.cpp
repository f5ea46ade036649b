// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/encode_pool.h"

#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <vector>

namespace mote::server {
namespace {

using Pace = EncodePool::Pace;

/// Work that waits until the test lets it go.
struct Held {
    std::promise<void> begun, go;

    std::function<void()> work() {
        return [this, allowed = go.get_future().share()] {
            begun.set_value();
            allowed.wait();
        };
    }
};

TEST(EncodePool, SmallPicturesDoNotWaitForLargeOnes) {
    std::vector<Held> large(3);
    std::vector<std::promise<void>> small(4);
    EncodePool pool(1);
    for (std::size_t i = 0; i < large.size(); ++i) pool.post(10 + i, large[i].work(), Pace::slow);
    large[0].begun.get_future().wait();
    for (std::size_t i = 0; i < small.size(); ++i) pool.post(i, [&small, i] { small[i].set_value(); });
    for (auto& one : small) one.get_future().wait();
    for (auto& one : large) one.go.set_value();
    for (std::size_t i = 1; i < large.size(); ++i) large[i].begun.get_future().wait();
}

TEST(EncodePool, ASessionsPicturesStayInTheirOrderWhateverTheirSizes) {
    constexpr int count = 100;
    std::mutex mutex;
    std::vector<int> order;
    std::promise<void> done;
    EncodePool pool(4);
    for (int i = 0; i < count; ++i) {
        const auto work = [&, i] {
            const std::lock_guard lock(mutex);
            order.push_back(i);
            if (i + 1 == count) done.set_value();
        };
        pool.post(1, work, i % 3 == 0 ? Pace::slow : Pace::quick);
    }
    done.get_future().wait();
    const std::lock_guard lock(mutex);
    ASSERT_EQ(order.size(), std::size_t{count});
    for (int i = 0; i < count; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace mote::server
