// SPDX-License-Identifier: GPL-3.0-or-later
//
// A number of a binary SDDS page as a double or as an id. A function without state.
#pragma once

#include <cstdint>
#include <type_traits>

#include "preprocess/readers/sdds/sdds_header.h"
#include "preprocess/readers/text/number.h"

namespace mote::prep {

/// A number that an id can be: whole 64 bits of integers; 0 for a float that is negative, too great or none.
template <class Value, class Number>
Value sddsValue(Number number) {
    if constexpr (std::is_same_v<Value, std::uint64_t> && std::is_floating_point_v<Number>) {
        return number >= 0 && number < Number(18446744073709551616.0) ? static_cast<std::uint64_t>(number)
                                                                      : 0;
    } else {
        return static_cast<Value>(number);
    }
}

/// Reads as many bytes as the type has; `type` is that of a number, but not longdouble.
template <class Value>
Value loadSddsNumber(const char* from, SddsType type, bool big) {
    switch (type) {
        case SddsType::int16:
            return sddsValue<Value>(loadNumber<std::int16_t>(from, big));
        case SddsType::uint16:
            return sddsValue<Value>(loadNumber<std::uint16_t>(from, big));
        case SddsType::int32:
            return sddsValue<Value>(loadNumber<std::int32_t>(from, big));
        case SddsType::uint32:
            return sddsValue<Value>(loadNumber<std::uint32_t>(from, big));
        case SddsType::int64:
            return sddsValue<Value>(loadNumber<std::int64_t>(from, big));
        case SddsType::uint64:
            return sddsValue<Value>(loadNumber<std::uint64_t>(from, big));
        case SddsType::float32:
            return sddsValue<Value>(loadNumber<float>(from, big));
        case SddsType::float64:
            return sddsValue<Value>(loadNumber<double>(from, big));
        case SddsType::longDouble:
        case SddsType::character:
        case SddsType::string:
            break;
    }
    return Value{};
}

}  // namespace mote::prep
