// SPDX-License-Identifier: GPL-3.0-or-later
//
// VtiHeader: what the XML of a VTK image file (.vti) says of one of its arrays, checked. Parsed from bytes
// that nobody vouches for, by expat, which never sees the numbers behind the array's own tag. A value, free
// of threads.
//
// VTK image files (.vti; docs.vtk.org, "XML File Formats"): values as text, in base64 or appended,
// compressed by zlib or not. Called from one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "preprocess/job.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/volume_parts.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct VtiHeader {
    enum class Encoding : std::uint8_t { ascii, base64, raw };

    VolumeShape shape;
    Encoding encoding = Encoding::base64;
    bool bigEndian = false;    ///< the values, and the sizes before them
    bool wideSizes = false;    ///< sizes have 64 bits, not 32
    bool compressed = false;   ///< in blocks, by zlib
    std::uint64_t dataAt = 0;  ///< bytes before the array's sizes and values in the file
    VolumeParts parts;         ///< values of a point, and which is read
    bool magnitude = false;    ///< of the vector that they are is read, and none of them

    static bool begins(std::string_view bytes);
    /// Reads the header of the array `field`; "": the active scalars, else the first array with one value for
    /// each point, else for each cell. Of an array with several values a point, "NAME:1" is the second,
    /// "NAME:magnitude" the length of the vector that they are. Reads `file` as far as needed. Errors, at the
    /// file's name and element: corrupt, unsupported (several values, and none was asked for), notFound (no
    /// such array), cancelled, those of `file`.
    static Result<VtiHeader> parse(ByteStream& file, std::string_view field, const Progress& progress);
};

/// The arrays that may be asked for, that which is read without a name first; of one with several values each
/// of them and its length. Errors: those of VtiDocument::parse.
Result<std::vector<VolumeField>> vtiFields(const std::filesystem::path& path, const Progress& progress);

/// The array `field`, as VtiHeader::parse chooses it. The file may be gzipped. Errors: corrupt, unsupported
/// (several pieces, another compressor), notFound (no such array), cancelled, those of fileStream.
Result<std::unique_ptr<VolumeSource>> openVti(const std::filesystem::path& path, std::string_view field,
                                              const Progress& progress);

}  // namespace mote::prep
