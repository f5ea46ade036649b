// SPDX-License-Identifier: GPL-3.0-or-later
//
// LookRuns: looks at foreign files for clients: each is a run of mote-prep look under mote-supervise, with
// the rights of a job and less, so that nothing in a file can do the server harm. Few run at once, each has a
// time and a memory of its own, and what nobody waits for any more is ended. Owned by JobService and used on
// its thread.
#pragma once

#include <asio/io_context.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/runner.h"
#include "storage/roots.h"

namespace mote::server {

class LookRuns {
  public:
    static constexpr std::size_t mostAtOnce = 2;
    static constexpr std::size_t mostWaiting = 64;
    static constexpr std::uint32_t seconds = 60;                          ///< of a look
    static constexpr std::uint64_t mostMemory = std::uint64_t{4} << 30;   ///< bytes
    static constexpr std::uint64_t mostWritten = std::uint64_t{8} << 20;  ///< bytes of an answer

    using Ticket = std::uint64_t;
    using Answered = std::function<void(Result<proto::Look>)>;

    /// `settings`: the queue's, with the programs that it found. The context outlives it.
    LookRuns(asio::io_context& context, JobSettings settings, storage::Roots roots);
    /// Ends what runs; nobody is answered any more.
    ~LookRuns();
    LookRuns(const LookRuns&) = delete;
    LookRuns& operator=(const LookRuns&) = delete;

    /// Takes away what an earlier server's looks left, and makes a place for ours. Errors: permissionDenied,
    /// resourceExhausted, internal.
    Status start();

    /// `answered` is called once, unless it is cancelled or this ends: with what the file holds, or
    /// invalidArgument (its name, neither a file nor a folder), notFound, permissionDenied, corrupt (it ended
    /// its reader), resourceExhausted (too many wait, time, memory), unsupported (jobs cannot be confined),
    /// internal.
    void look(Ticket ticket, const proto::LookAtFile& wanted, Answered answered);
    /// Ends it, if it has not ended; nobody is answered.
    void cancel(Ticket ticket);
    std::size_t running() const;

  private:
    struct One {
        Ticket ticket;
        proto::LookAtFile wanted;
        Answered answered;  // none: cancelled
        std::filesystem::path path = {}, directory = {};
        std::unique_ptr<Run> run = {};
        bool begun = false;
    };
    using Place = std::list<One>::iterator;

    Status prepare(One& one) const;
    RunOrder orderOf(const One& one) const;
    void beginNext();
    void begin(Place place);
    void ended(Place place);
    void finish(Place place, Result<proto::Look> answer);
    Result<proto::Look> answerOf(const One& one) const;

    JobSettings settings_;
    storage::Roots roots_;
    std::filesystem::path folder_;  // of all looks
    std::unique_ptr<Runner> runner_;
    std::list<One> all_;
    std::uint64_t serial_ = 0;  // of a look's folder
};

}  // namespace mote::server
