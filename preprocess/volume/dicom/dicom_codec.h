// SPDX-License-Identifier: GPL-3.0-or-later
//
// Compressed pictures of DICOM files: RLE by our own code, the family of JPEG by GDCM, which nothing else
// knows of. Pure functions; called from one thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/volume/dicom/dicom_header.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// What is to be done with the pictures of a transfer syntax: nothing, to be decoded, or something that only
/// others can do.
enum class DicomCoding : std::uint8_t { plain, coded, other };
DicomCoding codingOf(std::string_view syntax);

/// "JPEG 2000, lossless"; the UID itself where it is not known.
std::string syntaxName(std::string_view syntax);

/// Red, green and blue, 0 to 255, of luminance and differences of blue and red (PS3.3, C.7.6.3.1.2).
glm::vec3 redOf(const glm::vec3& ybr);

/// Decodes one frame into `pixels`, whose bytes are those of the header's rows, columns, samples and bits, in
/// the machine's byte order and pixel by pixel; colours are red, green and blue, whatever they were. `where`
/// is for messages. Errors: corrupt (damaged, or of another size than the header says), resourceExhausted.
Status decodeDicom(const DicomHeader& header, std::span<const char> coded, std::span<char> pixels,
                   const std::string& where);

}  // namespace mote::prep
