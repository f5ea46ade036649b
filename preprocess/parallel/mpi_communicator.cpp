// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/parallel/communicator.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <string_view>
#include <thread>

#include "preprocess/job.h"

namespace mote::prep {
namespace {

// A message is at most so long: MPI counts bytes in an int, and both sides cut alike.
constexpr std::size_t pieceBytes = std::size_t{1} << 29;

class MpiCommunicator final : public Communicator {
  public:
    explicit MpiCommunicator(std::function<bool()> cancelled) : cancelled_(std::move(cancelled)) {
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &size_);
        MPI_Comm here = MPI_COMM_NULL;
        MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
        MPI_Comm_size(here, &sizeHere_);
        MPI_Comm_free(&here);
    }
    /// If the job was given up, others may be gone: nothing waits for them.
    ~MpiCommunicator() override {
        if (whole_ && std::uncaught_exceptions() == 0) {
            MPI_Finalize();
        } else {
            MPI_Abort(MPI_COMM_WORLD, 1);
        }
    }

    int rank() const override { return rank_; }
    int size() const override { return size_; }
    bool onOneMachine() const override { return sizeHere_ == size_; }

    Result<std::vector<Bytes>> exchange(std::vector<Bytes> outgoing) override {
        Messages messages(*this, std::move(outgoing));
        auto incoming = messages.finish();
        if (incoming.ok()) MOTE_RETURN_IF_ERROR(messages.settle());
        return incoming;
    }

    std::unique_ptr<Exchange> begin(std::vector<Bytes> outgoing) override {
        return std::make_unique<Messages>(*this, std::move(outgoing));
    }

    Result<std::vector<Bytes>> share(std::span<const std::byte> mine) override {
        Transfer transfer(*this,
                          std::vector<std::span<const std::byte>>(static_cast<std::size_t>(size_), mine));
        auto incoming = transfer.finish();
        if (incoming.ok()) MOTE_RETURN_IF_ERROR(transfer.settle());
        if (incoming.ok()) (*incoming)[own()] = bytesOf(mine);
        return incoming;
    }

  private:
    /// Bytes from all ranks to all others; nothing goes from this rank to itself. What is sent outlives it.
    class Transfer {
      public:
        Transfer(MpiCommunicator& ranks, std::vector<std::span<const std::byte>> outgoing)
            : ranks_(ranks), tag_(ranks.nextTag()), toReceive_(outgoing.size()), sizes_(1) {
            outgoing[ranks.own()] = {};
            for (const auto& bytes : outgoing) toSend_.push_back(bytes.size());
            MPI_Ialltoall(toSend_.data(), 1, MPI_UINT64_T, toReceive_.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD,
                          sizes_.data());
            for (std::size_t other = 0; other < outgoing.size(); ++other) send(other, outgoing[other]);
        }

        Result<std::vector<Bytes>> finish() {
            MOTE_RETURN_IF_ERROR(ranks_.waitFor(sizes_));
            std::vector<Bytes> incoming(toReceive_.size());
            for (std::size_t other = 0; other < incoming.size(); ++other) {
                incoming[other].resize(toReceive_[other]);
                receive(other, incoming[other]);
            }
            MOTE_RETURN_IF_ERROR(ranks_.waitFor(received_));
            return incoming;
        }

        Status settle() { return ranks_.waitFor(sent_); }

      private:
        void receive(std::size_t from, std::span<std::byte> bytes) {
            for (std::size_t at = 0; at < bytes.size(); at += pieceBytes) {
                const auto piece = bytes.subspan(at, std::min(pieceBytes, bytes.size() - at));
                MPI_Irecv(piece.data(), static_cast<int>(piece.size()), MPI_BYTE, static_cast<int>(from),
                          tag_, MPI_COMM_WORLD, &received_.emplace_back());
            }
        }

        void send(std::size_t to, std::span<const std::byte> bytes) {
            for (std::size_t at = 0; at < bytes.size(); at += pieceBytes) {
                const auto piece = bytes.subspan(at, std::min(pieceBytes, bytes.size() - at));
                MPI_Isend(piece.data(), static_cast<int>(piece.size()), MPI_BYTE, static_cast<int>(to), tag_,
                          MPI_COMM_WORLD, &sent_.emplace_back());
            }
        }

        MpiCommunicator& ranks_;
        int tag_;
        std::vector<std::uint64_t> toSend_, toReceive_;
        std::vector<MPI_Request> sizes_, received_, sent_;
    };

    /// A transfer that holds what it sends.
    class Messages final : public Exchange {
      public:
        Messages(MpiCommunicator& ranks, std::vector<Bytes> outgoing)
            : own_(ranks.own()),
              outgoing_(std::move(outgoing)),
              transfer_(ranks, {outgoing_.begin(), outgoing_.end()}) {}

        Result<std::vector<Bytes>> finish() override {
            auto incoming = transfer_.finish();
            if (incoming.ok()) (*incoming)[own_] = std::move(outgoing_[own_]);
            return incoming;
        }
        Status settle() override { return transfer_.settle(); }

      private:
        std::size_t own_;
        std::vector<Bytes> outgoing_;
        Transfer transfer_;
    };

    std::size_t own() const { return static_cast<std::size_t>(rank_); }

    /// Messages of a transfer are not taken for those of another that was begun before it. MPI has at least
    /// 32768 tags.
    int nextTag() { return tag_ = (tag_ + 1) % 32768; }

    /// Not MPI_Waitall, which never returns where another rank is gone, and never lets go of its core. Bytes
    /// come forward only while MPI is asked, so that it sleeps only once they should have arrived.
    Status waitFor(std::vector<MPI_Request>& requests) {
        using Clock = std::chrono::steady_clock;
        constexpr std::chrono::milliseconds awake(20);
        const auto asleep = Clock::now() + awake;
        std::chrono::microseconds pause(20);
        while (true) {
            int done = 0;
            MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
            if (done != 0) return success();
            if (Clock::now() < asleep) {
                std::this_thread::yield();
                continue;
            }
            if (cancelled_()) break;
            std::this_thread::sleep_for(pause);
            pause = std::min(pause + pause / 4, std::chrono::microseconds(500));
        }
        whole_ = false;
        return wasCancelled();
    }

    std::function<bool()> cancelled_;
    int rank_ = 0;
    int size_ = 1, sizeHere_ = 1;
    int tag_ = 0;        ///< of the latest transfer
    bool whole_ = true;  ///< no transfer was given up
};

}  // namespace

bool startedByMpi() {
    const auto number = [](const char* name) {
        const char* text = std::getenv(name);
        return text ? std::atoi(text) : 0;
    };
    // Open MPI, and MPICH with its kin; under Slurm only where it also speaks for a process manager. A single
    // task needs no MPI, and may just have inherited what its parent was told.
    const bool managed = std::getenv("PMIX_RANK") || std::getenv("PMI_RANK");
    return number("OMPI_COMM_WORLD_SIZE") > 1 || number("PMI_SIZE") > 1 ||
           (managed && number("SLURM_STEP_NUM_TASKS") > 1);
}

Result<std::unique_ptr<Communicator>> joinMpi(std::function<bool()> cancelled) {
    // hwloc looks for GPUs at every X server of the machine, and Xlib ends the program whose server goes.
    ::setenv("HWLOC_COMPONENTS", "-gl", 0);
    // Where all ranks are on one machine they talk through its memory. Open MPI looks for networks first,
    // which takes it a quarter of a second.
    const auto* const all = std::getenv("OMPI_COMM_WORLD_SIZE");
    const auto* const here = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
    if (all && here && std::string_view(all) == here) ::setenv("OMPI_MCA_pml", "^ucx,cm", 0);
    // One thread at a time calls MPI, but not always the same.
    int provided = MPI_THREAD_SINGLE;
    if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_SERIALIZED) {
        return Error{ErrorCode::internal, "", "MPI does not start"};
    }
    return std::unique_ptr<Communicator>(std::make_unique<MpiCommunicator>(std::move(cancelled)));
}

}  // namespace mote::prep
