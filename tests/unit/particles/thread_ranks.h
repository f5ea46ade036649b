// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ranks that are threads of this process: what several ranks do together, without a launcher of MPI.
#pragma once

#include <barrier>
#include <cstddef>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "preprocess/parallel/communicator.h"

namespace mote::test {

class ThreadRanks {
  public:
    explicit ThreadRanks(std::size_t size)
        : size_(size), messages_(size), met_(static_cast<std::ptrdiff_t>(size)) {}

    /// Calls `work(communicator)` for each rank, all at once; returns when all are done.
    template <class Work>
    void run(const Work& work) {
        std::vector<std::jthread> threads;
        for (std::size_t rank = 0; rank < size_; ++rank) {
            threads.emplace_back([&, rank] {
                One one(*this, rank);
                work(static_cast<prep::Communicator&>(one));
            });
        }
    }

  private:
    class One final : public prep::Communicator {
      public:
        One(ThreadRanks& all, std::size_t rank) : all_(all), rank_(rank) {}
        int rank() const override { return static_cast<int>(rank_); }
        int size() const override { return static_cast<int>(all_.size_); }
        bool onOneMachine() const override { return true; }

        Result<std::vector<prep::Bytes>> exchange(std::vector<prep::Bytes> outgoing) override {
            all_.messages_[rank_] = std::move(outgoing);
            all_.met_.arrive_and_wait();
            std::vector<prep::Bytes> incoming;
            for (auto& of : all_.messages_) incoming.push_back(std::move(of[rank_]));
            all_.met_.arrive_and_wait();
            return incoming;
        }
        Result<std::vector<prep::Bytes>> share(std::span<const std::byte> mine) override {
            return exchange(std::vector<prep::Bytes>(all_.size_, prep::bytesOf(mine)));
        }

      private:
        ThreadRanks& all_;
        std::size_t rank_;
    };

    std::size_t size_;
    std::vector<std::vector<prep::Bytes>> messages_;  ///< by sender, by receiver
    std::barrier<> met_;
};

}  // namespace mote::test
