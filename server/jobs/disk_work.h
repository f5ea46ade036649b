// SPDX-License-Identifier: GPL-3.0-or-later
//
// DiskWork: what takes longer on the disk than others should wait, on a thread of its own: above all what
// jobs and clients leave behind is taken away. Owned by the queue; what it does not come to, the next
// server's start does.
//
// Among it are drafts: the folders "OUTPUT.partial-JOB" in which mote-supervise has jobs make their outputs,
// and what killed ones leave of them. Others have drafts there too, by other names: another server's jobs, a
// mote-prep that someone runs by hand. Those stay.
#pragma once

#include <asio/thread_pool.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::server {

/// A job that there was, or is, and makes a dataset.
struct DraftOwner {
    std::string output;  ///< as its request names it
    std::string job;     ///< its id
    bool live = false;   ///< it may be at work
};

class DiskWork {
  public:
    DiskWork() = default;
    /// Waits for what is under way.
    ~DiskWork();
    DiskWork(const DiskWork&) = delete;
    DiskWork& operator=(const DiskWork&) = delete;

    /// Nothing more is begun.
    void stop() { thread_.stop(); }

    void post(std::function<void()> work);
    void remove(const std::filesystem::path& folder);
    /// The draft of a job of which nothing runs any more, whose output was to lie there (a real path): at
    /// once under a name where no attempt looks for it, so that whoever writes there still does no harm.
    void removeDraft(const std::filesystem::path& output, const std::string& job);
    /// Drafts of those that are not live, and what was set aside of all.
    void sweepDrafts(const storage::Roots& roots, std::vector<DraftOwner> owners);

  private:
    asio::thread_pool thread_{1};
};

}  // namespace mote::server
