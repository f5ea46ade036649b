// SPDX-License-Identifier: GPL-3.0-or-later
//
// ScalarType: how a file stores one value of a volume, and how its bytes become floats. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace mote::prep {

enum class ScalarType : std::uint8_t { u8, i8, u16, i16, u32, i32, f32, f64 };

/// "u8", "i8", ...: in options, manifests and messages.
std::string_view name(ScalarType type);
std::optional<ScalarType> scalarType(std::string_view name);
std::size_t bytesOf(ScalarType type);  ///< 1, 2, 4 or 8

/// The stored numbers of a file: value = slope * number + intercept.
struct SampleFormat {
    ScalarType type = ScalarType::u8;
    bool bigEndian = false;
    double slope = 1.0, intercept = 0.0;  ///< finite
};

/// `bytes` holds values.size() numbers. Where slope and intercept are 1 and 0, each value is the number
/// rounded to the nearest float; else it is computed in double and rounded once.
void decodeSamples(std::span<const char> bytes, const SampleFormat& format, std::span<float> values);

}  // namespace mote::prep
