// SPDX-License-Identifier: GPL-3.0-or-later
//
// MetaImage volumes (itk.org/Wiki/ITK/MetaIO/Documentation): .mha, or .mhd with data beside it, zlib or not,
// or text. MetaImageHeader: what the text at the beginning says, checked. Parsed from bytes that nobody
// vouches for. Called from one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/volume_parts.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct MetaImageHeader {
    VolumeShape shape;
    VolumeParts parts;     ///< how many there are; the first one is chosen
    SampleFormat samples;  ///< f64 where the values are written as text
    bool text = false, compressed = false;
    std::vector<std::string> dataFiles;  ///< as they stand there; none: the data follow the header
    /// Bytes before the numbers in a data file; none: they end with the file.
    std::optional<std::uint64_t> headerSize = 0;
    std::size_t bytes = 0;  ///< of the header

    /// How many bytes of a file's beginning parse() may need.
    static constexpr std::size_t maxBytes = 1u << 20;

    static bool begins(std::string_view bytes);
    /// `text` is the beginning of the file. Errors, at the file's name and the field: corrupt, unsupported.
    static Result<MetaImageHeader> parse(std::string_view text, const std::string& file);
};

/// `path` is the file with the header; it may be gzipped. `field`: as of chooseParts. Errors: corrupt,
/// unsupported (other than three axes, and one of time), permissionDenied (data in another folder), those of
/// chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openMetaImage(const std::filesystem::path& path,
                                                    const std::string& field);

}  // namespace mote::prep
