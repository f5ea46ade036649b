// SPDX-License-Identifier: GPL-3.0-or-later
//
// The words of NRRD for types and encodings (teem.sourceforge.net/nrrd/format.html), in lower case.
// Constants.
#pragma once

#include <array>
#include <string_view>

#include "preprocess/volume/header_fields.h"
#include "preprocess/volume/nrrd.h"

namespace mote::prep {

inline constexpr std::array<ScalarTypeName, 42> nrrdTypes{{
    {"longlong", ScalarType::i64},
    {"long long", ScalarType::i64},
    {"long long int", ScalarType::i64},
    {"signed long long", ScalarType::i64},
    {"signed long long int", ScalarType::i64},
    {"int64", ScalarType::i64},
    {"int64_t", ScalarType::i64},
    {"ulonglong", ScalarType::u64},
    {"unsigned long long", ScalarType::u64},
    {"unsigned long long int", ScalarType::u64},
    {"uint64", ScalarType::u64},
    {"uint64_t", ScalarType::u64},
    {"signed char", ScalarType::i8},
    {"int8", ScalarType::i8},
    {"int8_t", ScalarType::i8},
    {"uchar", ScalarType::u8},
    {"unsigned char", ScalarType::u8},
    {"uint8", ScalarType::u8},
    {"uint8_t", ScalarType::u8},
    {"short", ScalarType::i16},
    {"short int", ScalarType::i16},
    {"signed short", ScalarType::i16},
    {"signed short int", ScalarType::i16},
    {"int16", ScalarType::i16},
    {"int16_t", ScalarType::i16},
    {"ushort", ScalarType::u16},
    {"unsigned short", ScalarType::u16},
    {"unsigned short int", ScalarType::u16},
    {"uint16", ScalarType::u16},
    {"uint16_t", ScalarType::u16},
    {"int", ScalarType::i32},
    {"signed int", ScalarType::i32},
    {"int32", ScalarType::i32},
    {"int32_t", ScalarType::i32},
    {"uint", ScalarType::u32},
    {"unsigned int", ScalarType::u32},
    {"uint32", ScalarType::u32},
    {"uint32_t", ScalarType::u32},
    {"float", ScalarType::f32},
    {"double", ScalarType::f64},
    {"float32", ScalarType::f32},
    {"float64", ScalarType::f64},
}};

struct NrrdEncodingName {
    std::string_view name;
    NrrdHeader::Encoding encoding;
};
inline constexpr std::array<NrrdEncodingName, 9> nrrdEncodings{{{"raw", NrrdHeader::Encoding::raw},
                                                                {"txt", NrrdHeader::Encoding::text},
                                                                {"text", NrrdHeader::Encoding::text},
                                                                {"ascii", NrrdHeader::Encoding::text},
                                                                {"hex", NrrdHeader::Encoding::hex},
                                                                {"gz", NrrdHeader::Encoding::gzip},
                                                                {"gzip", NrrdHeader::Encoding::gzip},
                                                                {"bz2", NrrdHeader::Encoding::bzip2},
                                                                {"bzip2", NrrdHeader::Encoding::bzip2}}};

}  // namespace mote::prep
