// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a job reads and where its output lies, beneath the roots: whether a request may be queued, what tells
// it and its files from others, whether its roots are there. The kind of job does not matter. Looks at files,
// and never into them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::server {

/// JobOutput: where the output of a job request lies beneath the roots. A value; looking it up touches no
/// file.
struct JobOutput {
    std::filesystem::path path;  ///< real, but for its last part
    std::filesystem::path root;  ///< the folder of its root
    bool exists = false;
};

/// Errors: invalidArgument, notFound (its root or its folder), permissionDenied.
Result<JobOutput> findOutput(const proto::JobRequest& request, const storage::Roots& roots);

/// Where the output is to appear; of a film or an export nowhere. Errors: invalidArgument, notFound (a root,
/// an input), alreadyExists (the output, but that of further steps), permissionDenied; each with the path of
/// its field, as in JSON.
Result<JobOutput> checkJobRequest(const proto::JobRequest& message, const storage::Roots& roots);

/// Of the whole request, and of the identity of each file and dataset that it reads: 32 hexadecimal digits,
/// the same for the same request as long as nothing that it reads is changed or replaced. Empty where that
/// cannot be known (an input is away, or a folder of very many files): then it is like no other. `uploads`:
/// the root of files that this server alone writes to, and gives other names to; empty: none.
std::string requestDigest(const proto::JobRequest& request, const storage::Roots& roots,
                          std::string_view uploads = {});

/// Tells what is there from whatever may once take its place; empty: nothing is there.
std::string identityOf(const std::filesystem::path& path);

/// Of a job's dataset, which is there; empty: it is not.
std::string identityOfOutput(const proto::JobRequest& request, const storage::Roots& roots);

/// RootWatch: whether the roots' folders are there, on the file systems that they lay on when the server
/// began. Owned by the queue and used on its thread.
class RootWatch {
  public:
    RootWatch() = default;  ///< of no roots
    explicit RootWatch(const storage::Roots& roots);

    /// What was not away before is said in the log.
    void look();
    /// Why a root that the job names is away, as of the latest look; null: all are there. What a film shows,
    /// the server finds for it.
    const Error* missing(const proto::JobRequest& request) const;

  private:
    struct Place {
        std::string name;
        std::filesystem::path folder;
        std::uint64_t device;
    };
    std::vector<Place> places_;
    std::map<std::string, Error> away_;  // by the root's name
};

}  // namespace mote::server
