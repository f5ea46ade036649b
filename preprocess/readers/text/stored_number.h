// SPDX-License-Identifier: GPL-3.0-or-later
//
// StoredNumber: how a binary file stores one number, whatever the format. Functions without state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "preprocess/readers/half_float.h"
#include "preprocess/readers/text/number.h"

namespace mote::prep {

enum class StoredNumber : std::uint8_t {
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float16,
    float32,
    float64,
};

constexpr bool isFraction(StoredNumber type) {
    return type >= StoredNumber::float16;
}

constexpr std::size_t bytesOf(StoredNumber type) {
    constexpr std::size_t bytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
    return bytes[static_cast<std::size_t>(type)];
}

/// A number as a double, or as what an id can be: whole 64 bits of integers, 0 for a fraction that is
/// negative, too great or none.
template <class Value, class Number>
Value storedValue(Number number) {
    if constexpr (std::is_same_v<Value, std::uint64_t> && !std::is_integral_v<Number>) {
        const auto value = static_cast<double>(number);
        return value >= 0.0 && value < 18446744073709551616.0 ? static_cast<std::uint64_t>(value) : 0;
    } else {
        return static_cast<Value>(number);
    }
}

/// Reads bytesOf(type) bytes.
template <class Value>
Value loadStored(const char* from, StoredNumber type, bool bigEndian) {
    switch (type) {
        case StoredNumber::int8:
            return storedValue<Value>(loadNumber<std::int8_t>(from, bigEndian));
        case StoredNumber::uint8:
            return storedValue<Value>(loadNumber<std::uint8_t>(from, bigEndian));
        case StoredNumber::int16:
            return storedValue<Value>(loadNumber<std::int16_t>(from, bigEndian));
        case StoredNumber::uint16:
            return storedValue<Value>(loadNumber<std::uint16_t>(from, bigEndian));
        case StoredNumber::int32:
            return storedValue<Value>(loadNumber<std::int32_t>(from, bigEndian));
        case StoredNumber::uint32:
            return storedValue<Value>(loadNumber<std::uint32_t>(from, bigEndian));
        case StoredNumber::int64:
            return storedValue<Value>(loadNumber<std::int64_t>(from, bigEndian));
        case StoredNumber::uint64:
            return storedValue<Value>(loadNumber<std::uint64_t>(from, bigEndian));
        case StoredNumber::float16:
            return storedValue<Value>(loadNumber<HalfFloat>(from, bigEndian));
        case StoredNumber::float32:
            return storedValue<Value>(loadNumber<float>(from, bigEndian));
        case StoredNumber::float64:
            return storedValue<Value>(loadNumber<double>(from, bigEndian));
    }
    return Value{};
}

}  // namespace mote::prep
