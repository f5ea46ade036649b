// SPDX-License-Identifier: GPL-3.0-or-later
//
// Uploads: the files that one client has sent for its jobs, which it names "uploads/NAME" until it leaves,
// and when it is back after its line broke (server/session/parked_sessions.h). They lie in a folder of the
// client's own beneath STATE/uploads, which jobs know as a root of that name; its name is drawn anew for each
// client, so that no job ever finds another's files there. A job that is submitted takes those that it reads
// into a folder of its own beside that, named by its id: they live and die with it. Shared by those who know
// the client's session; used on the jobs' thread, let go on any.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::server {

class Uploads {
  public:
    static constexpr const char* root = "uploads";
    static constexpr std::size_t mostFiles = 4096;
    static constexpr std::uint64_t mostBytes = std::uint64_t{1} << 36;  ///< of all files together

    /// Makes STATE/uploads, or takes it as it is. Errors: permissionDenied.
    static Result<std::filesystem::path> makeFolder(const std::filesystem::path& state);

    /// Gives the job with this id the uploads that `request`, as resolve() made it, reads: the request that
    /// names them. The client's own stay. `folder`: what makeFolder() gave. Errors: notFound,
    /// permissionDenied, resourceExhausted, internal; nothing is left then.
    static Result<proto::JobRequest> adopt(const proto::JobRequest& request,
                                           const std::filesystem::path& folder, const std::string& job);

    /// Removes a folder, at once or later.
    using Remove = std::function<void(const std::filesystem::path& folder)>;

    /// `folder`: what makeFolder() gave; `remove`: who takes the client's files away in the end, for
    /// gigabytes take a while; none: the destructor. Touches nothing yet.
    explicit Uploads(std::filesystem::path folder, Remove remove = {});
    /// All files go.
    ~Uploads();
    Uploads(const Uploads&) = delete;
    Uploads& operator=(const Uploads&) = delete;

    /// Bytes that were sent of all files. Any thread.
    std::uint64_t bytes() const { return written_; }

    /// How long the file is now; a part that is there already, as after a line broke, changes nothing.
    /// Errors: invalidArgument (a name, a place that is not its end), at the field; resourceExhausted (a
    /// limit, the disk).
    Result<std::uint64_t> add(const proto::Upload& part);

    /// The request with inputs of this client's in place of "uploads/NAME". Errors: notFound, invalidArgument
    /// (a file that is not whole, an output there), at the field.
    Result<proto::JobRequest> resolve(const proto::JobRequest& request) const;

  private:
    struct File {
        std::uint64_t size = 0, written = 0;  ///< bytes
    };
    Status begin(const proto::Upload& part);
    Status write(const proto::Upload& part) const;
    Status resolveName(std::string& name, const std::string& field) const;

    const std::filesystem::path folder_;  // of all clients
    const std::filesystem::path own_;
    const Remove remove_;
    std::map<std::string, File> files_;
    std::uint64_t bytes_ = 0;  // said of all files
    std::atomic<std::uint64_t> written_{0};
};

}  // namespace mote::server
