// SPDX-License-Identifier: GPL-3.0-or-later
//
// DatasetWriter: a dataset while it is made: a folder beside its final place, published by one rename and
// removed in every other case. Move-only; one owner, one thread.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/hash.h"

namespace mote::storage {

class DatasetWriter {
  public:
    /// `output` is "FOLDER/NAME.mote", which must not exist; FOLDER must. Errors: invalidArgument (the name),
    /// alreadyExists, notFound, permissionDenied, resourceExhausted.
    static Result<DatasetWriter> create(const std::filesystem::path& output);
    /// The same in two steps, for who must tell others of the folder before it is there. Errors:
    /// invalidArgument, alreadyExists.
    static Result<std::filesystem::path> choose(const std::filesystem::path& output);
    static Result<DatasetWriter> create(const std::filesystem::path& output,
                                        const std::filesystem::path& chosen);

    DatasetWriter(DatasetWriter&& other) noexcept;
    DatasetWriter& operator=(DatasetWriter&&) = delete;
    /// Removes what was not published.
    ~DatasetWriter();

    /// Where the dataset's files are to be made: "FOLDER/NAME.mote.partial-PID".
    const std::filesystem::path& directory() const { return partial_; }

    /// Takes a complete file of directory(), which nobody has open any more to write, into the dataset: its
    /// size and hash, of what is read back through a descriptor of its own. Errors: as hashFile.
    Status add(const std::string& name, const std::function<bool()>& cancelled = {});
    /// The same of a file whose hash is known of what was read back.
    void add(const std::string& name, FileHash hash);
    /// Those added so far, in their order.
    const std::vector<proto::FileEntry>& files() const { return files_; }

    /// Writes the manifest with files() behind those that it names already, of the live dataset that it
    /// continues (grow_dataset.h), puts everything on the disk, reads back what tells of it, and gives
    /// the dataset its name. Errors: as writeManifest and publishByRename, corrupt (what was read back is not
    /// what was written).
    Status publish(proto::Manifest manifest);

  private:
    Status verify() const;

    DatasetWriter(std::filesystem::path output, std::filesystem::path partial)
        : output_(std::move(output)), partial_(std::move(partial)) {}

    std::filesystem::path output_;
    std::filesystem::path partial_;  ///< empty once published or moved from
    std::vector<proto::FileEntry> files_;
};

}  // namespace mote::storage
