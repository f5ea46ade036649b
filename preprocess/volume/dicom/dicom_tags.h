// SPDX-License-Identifier: GPL-3.0-or-later
//
// The data elements that are looked at (PS3.6), all others being nobody's business: which they are, and where
// a header keeps what they hold. Free of threads.
#pragma once

#include <cstdint>
#include <string_view>

#include "preprocess/volume/dicom/dicom_header.h"
#include "preprocess/volume/dicom/dicom_stream.h"

namespace mote::prep {

struct DicomTag {
    std::uint32_t tag;
    std::string_view vr;  ///< where the file does not say it
    void (*ofFile)(const DicomValue& value, DicomHeader& header);
    /// Of one that every frame may have for itself; else null.
    void (*ofFrame)(const DicomValue& value, DicomHeader& header, DicomFrame& frame);
};

/// Null: an element that is stepped over.
const DicomTag* knownTag(std::uint32_t tag);

/// A word of the standard, or a UID; "" where the value is none.
std::string wordOf(const DicomValue& value);
std::string uidOf(const DicomValue& value);

}  // namespace mote::prep
