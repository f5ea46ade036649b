// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/ranks.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>

namespace mote::render {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

// MPI counts bytes in an int: longer messages go in pieces, which both sides cut alike.
constexpr std::size_t pieceBytes = std::size_t{1} << 29;
constexpr int bytesTag = 1;
constexpr int stopTag = 2;

/// Open MPI and MPICH wait with all of a core. This does so for moments only, as what is on its way moves on
/// with each look at it; then it sleeps, the longer the longer it has waited, so that an idle rank costs next
/// to nothing and a busy one loses no more than a sixteenth.
class Patience {
  public:
    void wait() {
        const auto waited = Clock::now() - begun_;
        if (waited < 20ms) return std::this_thread::yield();
        std::this_thread::sleep_for(std::min<Clock::duration>(waited / 16, 5ms));
    }

  private:
    const Clock::time_point begun_ = Clock::now();
};

void finish(std::span<MPI_Request> requests) {
    Patience patience;
    for (;;) {
        int done = 0;
        MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
        if (done != 0) return;
        patience.wait();
    }
}

void finish(MPI_Request request) {
    finish(std::span(&request, 1));
}

class MpiRanks final : public Ranks {
  public:
    MpiRanks() {
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &size_);
    }
    ~MpiRanks() override { MPI_Finalize(); }

    int rank() const override { return rank_; }
    int size() const override { return size_; }

    void broadcast(Bytes& bytes) noexcept override {
        std::uint64_t size = bytes.size();
        MPI_Request request = MPI_REQUEST_NULL;
        MPI_Ibcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD, &request);
        finish(request);
        bytes.resize(size);
        for (std::size_t at = 0; at < size; at += pieceBytes) {
            const auto count = static_cast<int>(std::min(pieceBytes, bytes.size() - at));
            MPI_Ibcast(bytes.data() + at, count, MPI_BYTE, 0, MPI_COMM_WORLD, &request);
            finish(request);
        }
    }

    std::vector<Bytes> exchange(const std::vector<Bytes>& outgoing) noexcept override {
        std::vector<std::uint64_t> toSend, toReceive(outgoing.size());
        for (const auto& bytes : outgoing) toSend.push_back(bytes.size());
        MPI_Request sizes = MPI_REQUEST_NULL;
        MPI_Ialltoall(toSend.data(), 1, MPI_UINT64_T, toReceive.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD,
                      &sizes);
        finish(sizes);
        std::vector<Bytes> incoming;
        for (const auto size : toReceive) incoming.emplace_back(size);
        std::vector<MPI_Request> requests;
        forPieces(incoming, [&](std::byte* bytes, int count, int other) {
            MPI_Irecv(bytes, count, MPI_BYTE, other, bytesTag, MPI_COMM_WORLD, &requests.emplace_back());
        });
        forPieces(outgoing, [&](const std::byte* bytes, int count, int other) {
            MPI_Isend(bytes, count, MPI_BYTE, other, bytesTag, MPI_COMM_WORLD, &requests.emplace_back());
        });
        finish(requests);
        return incoming;
    }

    std::uint64_t greatest(std::uint64_t mine) noexcept override { return reduced(mine, MPI_MAX); }
    std::uint64_t sum(std::uint64_t mine) noexcept override { return reduced(mine, MPI_SUM); }

    void sendStop(std::uint64_t picture) noexcept override {
        std::vector<MPI_Request> requests;
        for (int other = 1; other < size_; ++other) {
            MPI_Isend(&picture, 1, MPI_UINT64_T, other, stopTag, MPI_COMM_WORLD, &requests.emplace_back());
        }
        finish(requests);
    }

    bool stopArrived(std::uint64_t picture) noexcept override {
        for (;;) {
            int any = 0;
            MPI_Iprobe(0, stopTag, MPI_COMM_WORLD, &any, MPI_STATUS_IGNORE);
            if (any == 0) return false;
            std::uint64_t stopped = 0;
            MPI_Recv(&stopped, 1, MPI_UINT64_T, 0, stopTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
            if (stopped == picture) return true;
        }
    }

  private:
    std::uint64_t reduced(std::uint64_t mine, MPI_Op operation) const {
        std::uint64_t all = 0;
        MPI_Request request = MPI_REQUEST_NULL;
        MPI_Iallreduce(&mine, &all, 1, MPI_UINT64_T, operation, MPI_COMM_WORLD, &request);
        finish(request);
        return all;
    }

    template <class Messages, class Visit>
    static void forPieces(Messages& messages, Visit visit) {
        for (std::size_t other = 0; other < messages.size(); ++other) {
            auto& bytes = messages[other];
            for (std::size_t at = 0; at < bytes.size(); at += pieceBytes) {
                visit(bytes.data() + at, static_cast<int>(std::min(pieceBytes, bytes.size() - at)),
                      static_cast<int>(other));
            }
        }
    }

    int rank_ = 0;
    int size_ = 1;
};

/// Open MPI; MPICH and its kin, also under Slurm (PMI-1, PMI-2, PMIx). A launcher that says it started one
/// process alone counts as none.
bool startedByLauncher() {
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
        if (const char* size = std::getenv(name)) return std::string(size) != "1";
    }
    constexpr const char* names[] = {"PMI_RANK", "PMIX_RANK"};
    return std::any_of(std::begin(names), std::end(names),
                       [](const char* name) { return std::getenv(name); });
}

}  // namespace

std::unique_ptr<Ranks> joinRanks() {
    if (!startedByLauncher()) return nullptr;
    // hwloc looks for GPUs at every X server of the machine, and Xlib ends the program whose server goes.
    ::setenv("HWLOC_COMPONENTS", "-gl", 0);
    // One thread at a time calls MPI, but not always the same.
    int provided = MPI_THREAD_SINGLE;
    if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_SERIALIZED) {
        throw std::runtime_error("MPI does not start, or not for programs with threads");
    }
    return std::make_unique<MpiRanks>();
}

}  // namespace mote::render
