// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/uploads.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "protocol/base/system_error.h"
#include "server/jobs/state_directory.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longestName = 128;

Status checkName(const std::string& name) {
    const auto fits = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
               c == '_' || c == '.';
    };
    if (!name.empty() && name.size() <= longestName && name.front() != '.' && std::ranges::all_of(name, fits))
        return success();
    return invalid("upload.name",
                   fmt::format("must be 1 to {} letters, digits, \"-\", \"_\" and \".\", not a \".\" first",
                               longestName));
}

std::string randomName() {
    std::uint64_t bits = 0;
    MOTE_CHECK(::getrandom(&bits, sizeof bits, 0) == static_cast<ssize_t>(sizeof bits));
    return fmt::format("{:016x}", bits);
}

/// Calls `change(name, field)` for each input that may be an upload; the first error ends it.
template <class Change>
Status changeInputs(proto::JobRequest& request, Change change) {
    const auto all = [&](auto& names, const char* field) -> Status {
        for (int i = 0; i < names.size(); ++i)
            MOTE_RETURN_IF_ERROR(change(names[i], fmt::format("{}[{}]", field, i)));
        return success();
    };
    if (request.has_particles())
        MOTE_RETURN_IF_ERROR(all(*request.mutable_particles()->mutable_inputs(), "particles.inputs"));
    if (request.has_volume())
        MOTE_RETURN_IF_ERROR(all(*request.mutable_volume()->mutable_inputs(), "volume.inputs"));
    if (request.has_mesh())
        MOTE_RETURN_IF_ERROR(change(*request.mutable_mesh()->mutable_input(), "mesh.input"));
    if (request.has_image())
        MOTE_RETURN_IF_ERROR(change(*request.mutable_image()->mutable_input(), "image.input"));
    if (request.has_stipple())
        MOTE_RETURN_IF_ERROR(change(*request.mutable_stipple()->mutable_mesh(), "stipple.mesh"));
    return success();
}

bool isUpload(const std::string& name) {
    return name.starts_with(std::string(Uploads::root) + "/");
}

/// Sent again, as nobody knew whether it had arrived. The first part begins a file anew in any case.
bool isThere(const proto::Upload& part, std::uint64_t written) {
    const auto size = part.data().size();
    return part.begin() > 0 && size > 0 && size <= written && part.begin() <= written - size;
}

/// A second name of the same file, which a new upload of the first name does not touch; a place that knows no
/// second names gives the file away. A file that is named twice is there already.
Status takeFile(const fs::path& from, const fs::path& to) {
    if (::mkdir(to.parent_path().c_str(), 0700) != 0 && errno != EEXIST)
        return systemError(errno, to.parent_path().string(), "cannot be made");
    if (::link(from.c_str(), to.c_str()) == 0 || errno == EEXIST) return success();
    if ((errno == EPERM || errno == EOPNOTSUPP || errno == EMLINK) && ::rename(from.c_str(), to.c_str()) == 0)
        return success();
    return systemError(errno, from.filename().string(), "the upload cannot be given to the job");
}

}  // namespace

Result<fs::path> Uploads::makeFolder(const fs::path& state) {
    const auto folder = state / root;
    MOTE_RETURN_IF_ERROR(makeOwnFolder(folder));
    return folder;
}

Result<proto::JobRequest> Uploads::adopt(const proto::JobRequest& request, const fs::path& folder,
                                         const std::string& job) {
    auto own = request;
    const auto taken = changeInputs(own, [&](std::string& name, const std::string& field) -> Status {
        if (!isUpload(name)) return success();
        const fs::path file = name.substr(name.find('/') + 1);
        MOTE_RETURN_IF_ERROR(takeFile(folder / file, folder / job / file.filename()), field);
        name = fmt::format("{}/{}/{}", root, job, file.filename().string());
        return success();
    });
    if (taken.ok()) return own;
    std::error_code ignored;
    fs::remove_all(folder / job, ignored);
    return taken.error();
}

Uploads::Uploads(fs::path folder, Remove remove)
    : folder_(std::move(folder)), own_(folder_ / randomName()), remove_(std::move(remove)) {}

Uploads::~Uploads() {
    if (files_.empty()) return;
    std::error_code ignored;
    if (remove_) {
        remove_(own_);
    } else {
        fs::remove_all(own_, ignored);
    }
}

Status Uploads::begin(const proto::Upload& part) {
    const bool known = files_.contains(part.name());
    const auto before = known ? files_.at(part.name()).size : 0;
    if (!known && files_.size() >= mostFiles) {
        return Error{ErrorCode::resourceExhausted, "upload.name",
                     fmt::format("a client has at most {} uploaded files", mostFiles)};
    }
    if (part.size() > mostBytes - (bytes_ - before)) {
        return Error{ErrorCode::resourceExhausted, "upload.size",
                     fmt::format("a client's uploads have at most {} GiB together", mostBytes >> 30)};
    }
    if (::mkdir(own_.c_str(), 0700) != 0 && errno != EEXIST)
        return systemError(errno, own_.string(), "cannot be made");
    bytes_ += part.size() - before;
    if (known) written_ -= files_[part.name()].written;
    files_[part.name()] = {part.size(), 0};
    return success();
}

Status Uploads::write(const proto::Upload& part) const {
    const auto path = own_ / part.name();
    // Begun anew it is another file: the one that was there may be a job's by now.
    if (part.begin() == 0) ::unlink(path.c_str());
    const int flags = O_WRONLY | O_CLOEXEC | O_NOFOLLOW | (part.begin() == 0 ? O_CREAT | O_EXCL : 0);
    const storage::FileDescriptor file(::open(path.c_str(), flags, 0600));
    const auto failed = [&] {
        const bool full = errno == ENOSPC || errno == EDQUOT;
        return Error{full ? ErrorCode::resourceExhausted : ErrorCode::internal, "uploads/" + part.name(),
                     "cannot be written: " + systemMessage(errno)};
    };
    if (file.get() < 0) return failed();
    for (std::size_t done = 0; done < part.data().size();) {
        const auto wrote = ::pwrite(file.get(), part.data().data() + done, part.data().size() - done,
                                    static_cast<off_t>(part.begin() + done));
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) return failed();
        done += static_cast<std::size_t>(wrote);
    }
    return success();
}

Result<std::uint64_t> Uploads::add(const proto::Upload& part) {
    if (folder_.empty()) return Error{ErrorCode::unsupported, "upload", "this server takes no uploads"};
    MOTE_RETURN_IF_ERROR(checkName(part.name()));
    if (part.begin() == 0) MOTE_RETURN_IF_ERROR(begin(part));
    const auto found = files_.find(part.name());
    const auto size = part.data().size();
    if (found != files_.end() && isThere(part, found->second.written)) return found->second.written;
    if (found == files_.end() || found->second.written != part.begin()) {
        return invalid("upload.begin", fmt::format("the file has {} bytes so far",
                                                   found == files_.end() ? 0 : found->second.written));
    }
    if (size > found->second.size - part.begin())
        return invalid("upload.data", fmt::format("the file was said to have {} bytes", found->second.size));
    MOTE_RETURN_IF_ERROR(write(part));
    written_ += size;
    return found->second.written += size;
}

Status Uploads::resolveName(std::string& name, const std::string& field) const {
    if (!isUpload(name) || folder_.empty()) return success();
    const auto found = files_.find(name.substr(name.find('/') + 1));
    if (found == files_.end())
        return Error{ErrorCode::notFound, field, "no file of this name was uploaded in this session"};
    if (found->second.written != found->second.size) {
        return invalid(field, fmt::format("{} of {} bytes were uploaded so far", found->second.written,
                                          found->second.size));
    }
    name = fmt::format("{}/{}/{}", root, own_.filename().string(), found->first);
    return success();
}

Result<proto::JobRequest> Uploads::resolve(const proto::JobRequest& request) const {
    auto resolved = request;
    if (!folder_.empty() && isUpload(request.output()))
        return invalid("output", "lies among the uploads, which are removed when the client leaves");
    MOTE_RETURN_IF_ERROR(changeInputs(
        resolved, [this](std::string& name, const std::string& field) { return resolveName(name, field); }));
    return resolved;
}

}  // namespace mote::server
