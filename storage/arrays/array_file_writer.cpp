// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/arrays/array_file_writer.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>

#include "protocol/mote.pb.h"
#include "protocol/scene/json.h"
#include "protocol/scene/system_error.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/files/write_file.h"
#include "storage/hash.h"

namespace mote::storage {

namespace fs = std::filesystem;

Result<ArrayFileWriter> ArrayFileWriter::create(const fs::path& directory, const std::string& name,
                                                FileLayout layout) {
    auto path = directory / (name + ".h5");
    MOTE_ASSIGN_OR_RETURN(auto places, layOutFile(path, layout));
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return ArrayFileWriter(std::move(path), std::move(layout), std::move(places), std::move(file));
}

Status ArrayFileWriter::write(std::size_t array, std::uint64_t at, std::span<const std::byte> bytes) const {
    const auto& place = places_[array];
    MOTE_CHECK(at <= place.bytes && bytes.size() <= place.bytes - at);
    return writeAt(file_.get(), place.offset + at, bytes, path_);
}

Status ArrayFileWriter::finish() const {
    proto::Digest digest;
    std::vector<std::byte> block(blockBytes);
    for (std::size_t i = 0; i < places_.size(); ++i) {
        auto& array = *digest.add_arrays();
        array.set_name(layout_.arrays[i].name);
        array.set_type(layout_.arrays[i].type);
        for (const auto extent : layout_.arrays[i].shape) array.add_shape(extent);
        array.set_offset(places_[i].offset);
        for (std::uint64_t at = 0; at < places_[i].bytes; at += blockBytes) {
            const auto bytes = std::span(block).first(std::min(blockBytes, places_[i].bytes - at));
            MOTE_RETURN_IF_ERROR(readAt(file_.get(), places_[i].offset + at, bytes, path_));
            array.add_blocks(hashBlock(bytes));
        }
    }
    MOTE_RETURN_IF_ERROR(syncPath(path_));
    return writeNewFile(fs::path(path_).replace_extension(".digest"), toJson(digest));
}

}  // namespace mote::storage
