// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/new_dataset.h"

#include <system_error>

#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// Where what is made will lie in the end: a server's jobs make FOLDER/NAME as FOLDER/NAME.partial-ID/NAME.
fs::path finalFolder(const fs::path& output) {
    const auto folder = output.parent_path();
    const auto draft = output.filename().string() + ".partial-";
    return folder.filename().string().starts_with(draft) ? folder.parent_path() : folder;
}

}  // namespace

fs::path finalPlace(const fs::path& output) {
    return finalFolder(output) / output.filename();
}

proto::Manifest beginManifest(const char* kind, const proto::JobRequest& request, const std::string& title) {
    proto::Manifest manifest;
    manifest.set_kind(kind);
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    manifest.set_title(request.title().empty() ? title : request.title());
    manifest.set_up(request.up());
    manifest.set_front(request.front());
    *manifest.mutable_request() = request;
    manifest.mutable_request()->clear_output();
    return manifest;
}

std::string portableInput(const fs::path& input, const fs::path& output) {
    std::error_code code;
    const auto folder = fs::weakly_canonical(finalFolder(fs::absolute(output, code)), code);
    return fs::weakly_canonical(fs::absolute(input, code), code).lexically_relative(folder).string();
}

Status publishDataset(storage::DatasetWriter& writer, proto::Manifest& manifest, const Progress& progress) {
    if (progress.cancelled()) return wasCancelled();
    MOTE_RETURN_IF_ERROR(writer.publish(manifest));
    for (const auto& file : writer.files()) *manifest.add_files() = file;
    return success();
}

Result<proto::Manifest> finishDataset(storage::DatasetWriter& writer,
                                      std::initializer_list<std::string_view> names, proto::Manifest manifest,
                                      Progress& progress) {
    for (const auto name : names) {
        for (const char* suffix : {".h5", ".digest"})
            MOTE_RETURN_IF_ERROR(
                writer.add(std::string(name) + suffix, [&] { return progress.cancelled(); }));
    }
    MOTE_RETURN_IF_ERROR(publishDataset(writer, manifest, progress));
    progress.report(1.0, "done");
    return manifest;
}

}  // namespace mote::prep
