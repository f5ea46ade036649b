// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/uploads.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "protocol/scene/system_error.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longestName = 128;

Error invalid(std::string where, std::string message) {
    return {ErrorCode::invalidArgument, std::move(where), std::move(message)};
}

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

}  // namespace

Result<fs::path> Uploads::makeFolder(const fs::path& state) {
    std::error_code code;
    const auto folder = fs::absolute(state / root, code);
    // What a server that was killed left behind.
    if (!code) fs::remove_all(folder, code);
    if (!code) fs::create_directories(folder, code);
    if (!code) fs::permissions(folder, fs::perms::owner_all, code);
    if (code) return Error{ErrorCode::internal, folder.string(), "cannot be made: " + code.message()};
    return folder;
}

Uploads::Uploads(fs::path folder, const std::string& client)
    : folder_(std::move(folder)), client_(client), own_(folder_ / client) {}

Uploads::~Uploads() {
    if (files_.empty()) return;
    std::error_code ignored;
    fs::remove_all(own_, ignored);
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
    std::error_code code;
    fs::create_directories(own_, code);
    if (code) return Error{ErrorCode::internal, own_.string(), "cannot be made: " + code.message()};
    bytes_ += part.size() - before;
    files_[part.name()] = {part.size(), 0};
    return success();
}

Status Uploads::write(const proto::Upload& part) const {
    const auto path = own_ / part.name();
    const int flags = O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | (part.begin() == 0 ? O_TRUNC : 0);
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
    if (found == files_.end() || found->second.written != part.begin()) {
        return invalid("upload.begin", fmt::format("the file has {} bytes so far",
                                                   found == files_.end() ? 0 : found->second.written));
    }
    if (part.data().size() > found->second.size - part.begin())
        return invalid("upload.data", fmt::format("the file was said to have {} bytes", found->second.size));
    MOTE_RETURN_IF_ERROR(write(part));
    return found->second.written += part.data().size();
}

Status Uploads::resolveName(std::string& name, const std::string& field) const {
    const auto prefix = std::string(root) + "/";
    if (!name.starts_with(prefix) || folder_.empty()) return success();
    const auto found = files_.find(name.substr(prefix.size()));
    if (found == files_.end())
        return Error{ErrorCode::notFound, field, "no file of this name was uploaded on this connection"};
    if (found->second.written != found->second.size) {
        return invalid(field, fmt::format("{} of {} bytes were uploaded so far", found->second.written,
                                          found->second.size));
    }
    name = prefix + client_ + "/" + found->first;
    return success();
}

Result<proto::JobRequest> Uploads::resolve(const proto::JobRequest& request) const {
    auto resolved = request;
    if (!folder_.empty() && request.output().starts_with(std::string(root) + "/"))
        return invalid("output", "lies among the uploads, which are removed when the client leaves");
    const auto all = [&](auto& names, const char* field) -> Status {
        for (int i = 0; i < names.size(); ++i)
            MOTE_RETURN_IF_ERROR(resolveName(names[i], fmt::format("{}[{}]", field, i)));
        return success();
    };
    if (resolved.has_particles())
        MOTE_RETURN_IF_ERROR(all(*resolved.mutable_particles()->mutable_inputs(), "particles.inputs"));
    if (resolved.has_volume())
        MOTE_RETURN_IF_ERROR(all(*resolved.mutable_volume()->mutable_inputs(), "volume.inputs"));
    if (resolved.has_mesh())
        MOTE_RETURN_IF_ERROR(resolveName(*resolved.mutable_mesh()->mutable_input(), "mesh.input"));
    if (resolved.has_image())
        MOTE_RETURN_IF_ERROR(resolveName(*resolved.mutable_image()->mutable_input(), "image.input"));
    if (resolved.has_stipple())
        MOTE_RETURN_IF_ERROR(resolveName(*resolved.mutable_stipple()->mutable_mesh(), "stipple.mesh"));
    return resolved;
}

}  // namespace mote::server
