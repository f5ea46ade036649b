// SPDX-License-Identifier: GPL-3.0-or-later
//
// Drafts: the folders "OUTPUT.partial-JOB" in which mote-supervise has jobs make their outputs, and what
// killed ones leave of them. Others have drafts there too, by other names: another server's jobs, a mote-prep
// that someone runs by hand. Those stay. Functions without state, any thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mote::server {

/// The draft of the job with this id, whose output is to lie there (a real path).
std::filesystem::path draftOf(const std::filesystem::path& output, std::string_view job);

/// Gives the job's draft another name, under which no attempt looks for it: whoever writes there still does
/// no harm, and it may be removed later. That name; empty: there is no draft.
std::filesystem::path setDraftAside(const std::filesystem::path& output, std::string_view job);

/// Removes a draft, whatever became of its parents' names meanwhile.
void removeDraft(const std::filesystem::path& draft);

/// A job that there was, or is.
struct DraftOwner {
    std::filesystem::path output;
    std::string job;    ///< its id
    bool live = false;  ///< it may be at work
};

/// Removes the drafts of those that are not live, and what was set aside of all.
void sweepDrafts(const std::vector<DraftOwner>& owners);

}  // namespace mote::server
