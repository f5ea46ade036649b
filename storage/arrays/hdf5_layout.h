// SPDX-License-Identifier: GPL-3.0-or-later
//
// What HDF5 writes of a dataset's file of contiguous arrays: superblock, groups, arrays that are allocated
// and not filled, attributes. The arrays' bytes go to their places without it. One call at a time in a
// process: HDF5 is not thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "protocol/base/error.h"

namespace mote::storage {

struct ArrayLayout {
    std::string name;                  ///< the dataset's path in the HDF5 file: "/points/position"
    std::string type;                  ///< as in the digest: u8, u16, u32, u64 or f32
    std::vector<std::uint64_t> shape;  ///< slowest first
};

/// Where an array lies in its file.
struct ArrayPlace {
    std::uint64_t offset = 0;  ///< 0 for an array without bytes
    std::uint64_t bytes = 0;
};

/// An attribute of the root group: a number, numbers, or names of at most 16 bytes, padded with zeros.
struct ArrayAttribute {
    std::string name;
    std::variant<double, std::vector<double>, std::vector<std::string>> value;
};

struct FileLayout {
    std::vector<std::string> groups;  ///< in the order in which they are made
    std::vector<ArrayLayout> arrays;
    std::vector<ArrayAttribute> attributes;
};

/// The bytes of an element of a type; 0 for one that there is not.
inline std::uint64_t elementBytes(std::string_view type) {
    if (type == "u8") return 1;
    if (type == "u16") return 2;
    if (type == "u32" || type == "f32") return 4;
    return type == "u64" || type == "f64" ? 8 : 0;
}

/// The bytes of a whole array. The shape is a writer's own: no overflow is looked for.
inline std::uint64_t bytesOf(const ArrayLayout& array) {
    std::uint64_t bytes = elementBytes(array.type);
    for (const auto extent : array.shape) bytes *= extent;
    return bytes;
}

/// Makes `path`, which must be new, with room for everything before HDF5 sees it, and lays it out. Places in
/// the order of the arrays. The same layout gives the same bytes. Errors: resourceExhausted (disk full),
/// permissionDenied, alreadyExists, internal; a part of the file may be left.
Result<std::vector<ArrayPlace>> layOutFile(const std::filesystem::path& path, const FileLayout& layout);

/// To be called before anything else of HDF5: version 1.10 crashes at the end of a process on what is left of
/// a file whose close has failed, on a full disk say. We close all that we open, so nothing is left to tidy.
void leaveHdf5Untidied();

}  // namespace mote::storage
