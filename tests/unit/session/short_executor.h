// SPDX-License-Identifier: GPL-3.0-or-later
//
// ShortExecutor: an io_context's executor that finds no memory when a test says so. A value; any thread.
#pragma once

#include <asio/execution.hpp>
#include <asio/io_context.hpp>
#include <asio/require.hpp>
#include <atomic>
#include <new>
#include <utility>

namespace mote::test {

/// For whom there is no memory.
struct Shortage {
    std::atomic<bool> forAll{false};
    std::atomic<bool> forOthers{false};  ///< than the context's own thread
};

class ShortExecutor {
  public:
    ShortExecutor(asio::io_context& io, const Shortage& shortage) : io_(&io), shortage_(&shortage) {}

    asio::execution_context& query(asio::execution::context_t) const noexcept { return *io_; }
    /// It never runs what it is given from within.
    ShortExecutor require(asio::execution::blocking_t::never_t) const noexcept { return *this; }
    template <class Function>
    void execute(Function&& function) const {
        const auto plain = io_->get_executor();
        if (shortage_->forAll || (shortage_->forOthers && !plain.running_in_this_thread()))
            throw std::bad_alloc();
        asio::execution::execute(asio::require(plain, asio::execution::blocking.never),
                                 std::forward<Function>(function));
    }
    bool operator==(const ShortExecutor&) const noexcept = default;

  private:
    asio::io_context* io_;
    const Shortage* shortage_;
};

}  // namespace mote::test
