// SPDX-License-Identifier: GPL-3.0-or-later
//
// NIfTI-1 and NIfTI-2 volumes (nifti.nimh.nih.gov): .nii, or .hdr with the numbers in the .img file beside
// it. NiftiHeader: what the first 348 or 540 bytes say, checked. Parsed from bytes that nobody vouches for.
// Called from one thread.
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

struct NiftiHeader {
    VolumeShape shape;
    VolumeParts parts;  ///< how many there are; the first one is chosen
    SampleFormat samples;
    bool beside = false;                     ///< the numbers lie in the .img file beside the .hdr
    std::uint64_t offset = 0;                ///< bytes before the numbers, in the file that has them
    double timeStep = 0.0, firstTime = 0.0;  ///< s, of the volumes of a series; 0: not known

    /// How many bytes of a file's beginning parse() needs.
    static constexpr std::size_t maxBytes = 540;

    static bool begins(std::string_view bytes);
    /// `bytes` is the beginning of a file that begins() holds for. Errors, at the file's name and the field:
    /// corrupt, unsupported.
    static Result<NiftiHeader> parse(std::string_view bytes, const std::string& file);
};

/// Each file may be gzipped. `field`: as of chooseParts, of the times and other volumes. Errors: corrupt,
/// unsupported, notFound (no .img file), those of chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openNifti(const std::filesystem::path& path, const std::string& field);

}  // namespace mote::prep
