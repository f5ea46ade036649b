// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/dataset_writer.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <utility>

#include "protocol/base/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/hash.h"
#include "storage/manifest.h"

namespace mote::storage {

namespace fs = std::filesystem;

Result<fs::path> DatasetWriter::choose(const fs::path& output) {
    if (output.extension() != datasetSuffix || output.stem().empty()) {
        return Error{ErrorCode::invalidArgument, output.string(), "a dataset's name ends with .mote"};
    }
    std::error_code code;
    if (fs::exists(fs::symlink_status(output, code))) {
        return Error{ErrorCode::alreadyExists, output.string(), "exists already and is never replaced"};
    }
    // A process that was killed may have left a folder under our number: take the next name, touch nothing.
    for (int attempt = 0; attempt < 100; ++attempt) {
        fs::path partial = output;
        partial += fmt::format(".partial-{}", ::getpid());
        if (attempt > 0) partial += fmt::format("-{}", attempt);
        if (!fs::exists(fs::symlink_status(partial, code))) return partial;
    }
    return Error{ErrorCode::alreadyExists, output.string(), "too many unfinished copies lie beside it"};
}

Result<DatasetWriter> DatasetWriter::create(const fs::path& output, const fs::path& chosen) {
    if (::mkdir(chosen.c_str(), 0777) == 0) return DatasetWriter(output, chosen);
    return systemError(errno, output.string(), "cannot be made");
}

Result<DatasetWriter> DatasetWriter::create(const fs::path& output) {
    MOTE_ASSIGN_OR_RETURN(const auto chosen, choose(output));
    return create(output, chosen);
}

DatasetWriter::DatasetWriter(DatasetWriter&& other) noexcept
    : output_(std::move(other.output_)),
      partial_(std::exchange(other.partial_, {})),
      files_(std::move(other.files_)) {}

DatasetWriter::~DatasetWriter() {
    if (partial_.empty()) return;
    try {
        std::error_code ignored;
        fs::remove_all(partial_, ignored);
    } catch (const std::bad_alloc&) {
        // It stays, is nobody's dataset, and goes with other drafts.
    }
}

Status DatasetWriter::add(const std::string& name, const std::function<bool()>& cancelled) {
    MOTE_ASSIGN_OR_RETURN(auto hash, hashFile(partial_ / name, cancelled));
    add(name, std::move(hash));
    return success();
}

void DatasetWriter::add(const std::string& name, FileHash hash) {
    auto& entry = files_.emplace_back();
    entry.set_name(name);
    entry.set_size(hash.size);
    entry.set_xxh3_128(std::move(hash.xxh3_128));
}

/// Each byte of a file was read back once, after it was closed, for the hash that add() took of it. What can
/// be wrong since then is a file that was written on, and the manifest: so the one is looked for by its size,
/// and the other read as its readers will, against its digest. A second pass over all bytes would find no
/// more: until they are evicted it reads the same pages, and costs a job of gigabytes as long as the first.
Status DatasetWriter::verify() const {
    for (const auto& file : files_) {
        const auto path = partial_ / file.name();
        MOTE_ASSIGN_OR_RETURN(const auto opened, openRegular(path));
        struct stat status {};
        if (::fstat(opened.get(), &status) != 0) return systemError(errno, path.string(), "cannot be read");
        if (static_cast<std::uint64_t>(status.st_size) != file.size())
            return Error{ErrorCode::corrupt, path.string(), "was written to after it was complete"};
    }
    MOTE_RETURN_IF_ERROR(readManifest(partial_));
    return success();
}

Status DatasetWriter::publish(proto::Manifest manifest) {
    for (const auto& file : files_) *manifest.add_files() = file;
    MOTE_RETURN_IF_ERROR(writeManifest(partial_, manifest));
    // On the disk first: what cannot be written there the kernel says now.
    for (const auto& file : files_) MOTE_RETURN_IF_ERROR(syncPath(partial_ / file.name()));
    MOTE_RETURN_IF_ERROR(verify());
    MOTE_RETURN_IF_ERROR(syncPath(partial_));
    MOTE_RETURN_IF_ERROR(publishByRename(partial_, output_));
    partial_.clear();
    return success();
}

}  // namespace mote::storage
