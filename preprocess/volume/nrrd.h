// SPDX-License-Identifier: GPL-3.0-or-later
//
// NRRD volumes, versions 1 to 5 (teem.sourceforge.net/nrrd/format.html): raw, gzip, bzip2, hex and text
// encoding, data in the same file or beside it. NrrdHeader: what the text at the beginning says, checked.
// Parsed from bytes that nobody vouches for. Called from one thread.
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

struct NrrdHeader {
    enum class Encoding : std::uint8_t { raw, text, hex, gzip, bzip2 };

    VolumeShape shape;
    VolumeParts parts;  ///< how many there are; the first one is chosen
    bool bigEndian = false;
    Encoding encoding = Encoding::raw;
    std::vector<std::string> dataFiles;  ///< as they stand there; none: the data follow the header
    std::uint64_t lineSkip = 0;          ///< lines before the data, compressed or not
    /// Bytes before the numbers, after decompression; none: they end with the file.
    std::optional<std::uint64_t> byteSkip = 0;
    std::size_t bytes = 0;  ///< of the header with the empty line behind it

    /// How many bytes of a file's beginning parse() may need.
    static constexpr std::size_t maxBytes = 1u << 20;

    static bool begins(std::string_view bytes) { return bytes.starts_with("NRRD00"); }
    /// `text` is the beginning of the file. Errors, at the file's name and the field: corrupt, unsupported.
    static Result<NrrdHeader> parse(std::string_view text, const std::string& file);
};

/// `path` is the file with the header; it may be gzipped. `field`: as of chooseParts. Errors: corrupt,
/// unsupported (another encoding, not three axes of space), those of chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path, const std::string& field);

}  // namespace mote::prep
