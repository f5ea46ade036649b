// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/request_digest.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <sys/stat.h>

#include <algorithm>
#include <set>
#include <span>
#include <vector>

#include "protocol/scene/job_request.h"
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

}  // namespace

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

}  // namespace mote::server
