// SPDX-License-Identifier: GPL-3.0-or-later
//
// MRC2014 and CCP4 maps (ccpem.ac.uk/mrc_format). MrcHeader: what the first 1024 bytes say, checked. Parsed
// from bytes that nobody vouches for. Called from one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "preprocess/volume/volume_parts.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct MrcHeader {
    VolumeShape shape;
    VolumeParts parts;  ///< how many there are; the first one is chosen
    SampleFormat samples;
    std::uint64_t offset = 0;  ///< bytes before the numbers

    /// How many bytes of a file's beginning parse() needs.
    static constexpr std::size_t bytes = 1024;

    static bool begins(std::string_view bytes);
    /// Errors, at the file's name and the field: corrupt, unsupported.
    static Result<MrcHeader> parse(std::string_view bytes, const std::string& file);
};

/// The file may be gzipped. The file's columns are the volume's first axis; which one they are in space, the
/// map to the world says. `field`: the number of a volume of a stack. Errors: corrupt, unsupported, those of
/// chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openMrc(const std::filesystem::path& path, const std::string& field);

}  // namespace mote::prep
