// SPDX-License-Identifier: GPL-3.0-or-later
//
// ThreadRanks: ranks that are threads of the test, without MPI. Whoever makes the group owns it; each rank
// belongs to one thread at a time.
#pragma once

#include <atomic>
#include <barrier>
#include <memory>
#include <vector>

#include "server/render/ranks/ranks.h"

namespace mote::test {

class ThreadRanks {
  public:
    explicit ThreadRanks(int size);
    ~ThreadRanks();
    ThreadRanks(const ThreadRanks&) = delete;
    ThreadRanks& operator=(const ThreadRanks&) = delete;

    int size() const { return static_cast<int>(ranks_.size()); }
    render::Ranks& operator[](int rank) { return *ranks_[static_cast<std::size_t>(rank)]; }

  private:
    class Rank;

    std::barrier<> meeting_;
    std::vector<std::vector<render::Bytes>> messages_;  // by sender and receiver
    std::atomic<std::uint64_t> stopped_{0};
    std::vector<std::unique_ptr<render::Ranks>> ranks_;
};

}  // namespace mote::test
