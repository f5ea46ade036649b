// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_inputs.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <span>
#include <utility>

#include "protocol/base/system_error.h"
#include "protocol/scene/job_request.h"
#include "server/log.h"
#include "storage/hash.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t mostEntries = 10'000;  // of a folder of inputs

/// The bytes that equal messages share.
std::string canonical(const google::protobuf::Message& message) {
    std::string bytes;
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    message.SerializeToCodedStream(&coded);
    coded.Trim();
    return bytes;
}

void addDatasets(const proto::View& view, std::set<std::string>& names) {
    for (const auto& layer : view.layers()) {
        names.insert(layer.dataset());
        if (!layer.stipple().image().empty()) names.insert(layer.stipple().image());
    }
}

/// Files and datasets that the job reads, by itself or, of a film, through the server.
std::set<std::string> readBy(const proto::JobRequest& request) {
    std::set<std::string> names;
    for (const auto& input : jobInputs(request)) names.insert(input.name);
    const auto& script = request.film().script();
    for (const auto& view : script.views()) addDatasets(view, names);
    for (const auto& keyframe : script.keyframes()) addDatasets(keyframe.view(), names);
    addDatasets(script.view(), names);
    return names;
}

/// Of a folder also of what lies in it, in the order of its names. Empty: not known.
std::string identityOfInput(const fs::path& path) {
    auto identity = identityOf(path);
    std::error_code code;
    if (identity.empty() || !fs::is_directory(path, code)) return identity;
    std::vector<std::string> inside;
    fs::directory_iterator entry(path, code);
    for (; !code && entry != fs::directory_iterator(); entry.increment(code)) {
        if (inside.size() == mostEntries) return {};
        inside.push_back(entry->path().filename().string() + " " + identityOf(entry->path()));
    }
    if (code) return {};
    std::sort(inside.begin(), inside.end());
    for (const auto& line : inside) identity += "\n" + line;
    return identity;
}

std::string textOf(const struct stat& status) {
    return fmt::format("{} {} {} {}.{:09}", status.st_dev, status.st_ino, status.st_size,
                       status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
}

/// A second name, as each job gets of it, changes its ctime.
std::string identityOfUpload(const fs::path& path) {
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 ? textOf(status) : std::string();
}

/// An error about a path, told of the field that holds it.
Error ofField(const std::string& field, const Error& error) {
    return {error.code, field, error.toString()};
}

}  // namespace

Result<JobOutput> findOutput(const proto::JobRequest& request, const storage::Roots& roots) {
    const auto& name = request.output();
    JobOutput output;
    auto path = roots.resolveNew(name);
    if (!path.ok() && path.error().code == ErrorCode::alreadyExists) {
        output.exists = true;
        path = roots.resolveExisting(name);
    }
    if (!path.ok()) return path.error();
    output.path = *std::move(path);
    for (const auto& entry : roots.entries()) {
        if (name.starts_with(entry.name + "/")) output.root = entry.folder;
    }
    return output;
}

Result<JobOutput> checkJobRequest(const proto::JobRequest& message, const storage::Roots& roots) {
    MOTE_ASSIGN_OR_RETURN(const auto request, parseJobRequest(message));
    for (const auto& input : request.inputs) {
        const auto path = roots.resolveExisting(input.name);
        if (!path.ok()) return ofField(input.field, path.error());
    }
    if (staysWithJob(message)) return JobOutput{};
    auto output = findOutput(message, roots);
    if (!output.ok()) return ofField("output", output.error());
    if (output->exists && !appendsSteps(message)) {
        return Error{ErrorCode::alreadyExists, "output", fmt::format("{} exists already", message.output())};
    }
    return output;
}

std::string identityOf(const fs::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    return fmt::format("{} {}.{:09}", textOf(status), status.st_ctim.tv_sec, status.st_ctim.tv_nsec);
}

std::string requestDigest(const proto::JobRequest& request, const storage::Roots& roots,
                          std::string_view uploads) {
    std::string text = canonical(request);
    for (const auto& name : readBy(request)) {
        const auto path = roots.resolveExisting(name);
        const bool uploaded = !uploads.empty() && name.starts_with(std::string(uploads) + "/");
        std::string identity;
        if (path.ok()) identity = uploaded ? identityOfUpload(*path) : identityOfInput(*path);
        if (identity.empty()) return {};
        text += fmt::format("\n{} {} {}", name.size(), name, identity);
    }
    return storage::hash128(std::as_bytes(std::span(text)));
}

std::string identityOfOutput(const proto::JobRequest& request, const storage::Roots& roots) {
    const auto output = findOutput(request, roots);
    return output.ok() && output->exists ? identityOf(output->path) : std::string();
}

RootWatch::RootWatch(const storage::Roots& roots) {
    for (const auto& entry : roots.entries()) {
        struct stat status {};
        if (::stat(entry.folder.c_str(), &status) == 0)
            places_.push_back({entry.name, entry.folder, status.st_dev});
    }
}

/// The folder alone may still be there, empty, when what was mounted on it is gone.
void RootWatch::look() {
    const auto before = std::exchange(away_, {});
    for (const auto& root : places_) {
        struct stat status {};
        if (::stat(root.folder.c_str(), &status) != 0) {
            away_.emplace(root.name, systemError(errno, root.folder.string(), "a folder of data is away"));
        } else if (status.st_dev != root.device) {
            away_.emplace(root.name, notFound(root.folder.string(),
                                              "another file system lies there than when the server began"));
        }
    }
    for (const auto& [name, error] : away_) {
        if (!before.contains(name)) log::warn("jobs of root \"{}\" wait: {}", name, error.toString());
    }
}

const Error* RootWatch::missing(const proto::JobRequest& request) const {
    if (away_.empty()) return nullptr;
    auto names = jobInputs(request);
    names.push_back({"output", request.output()});
    for (const auto& [field, name] : names) {
        const auto root = away_.find(name.substr(0, name.find('/')));
        if (root != away_.end()) return &root->second;
    }
    return nullptr;
}

}  // namespace mote::server
