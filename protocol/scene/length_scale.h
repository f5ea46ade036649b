// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lengths on the screen (docs/PICTURE.md, "Lengths"). One that a view says is pixels times the view's
// `scale`; one that it leaves out is that of a picture of 720 lines and grows with the picture's height.
// Styles keep which of both each of theirs is; view_message.h makes a view of it whose lengths are all
// told in its own pixels, and who draws is given that. Pure functions and values.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace mote {

/// An inch, in millimetres and in points of type.
inline constexpr double inchInMillimeters = 25.4;
inline constexpr double inchInPoints = 72.0;

/// Lines of the picture whose pixels usual lengths are told in.
inline constexpr double usualLines = 720.0;

/// What a length on the screen is multiplied with in a picture of `height` lines. `scale`: of its view.
constexpr double lengthScale(std::uint32_t height, double scale, bool said) {
    return said ? scale : height / usualLines;
}

/// A length on the screen: said by a view, or usual.
class ScreenLength {
  public:
    /// Said. Not explicit: what has a value has been said.
    constexpr ScreenLength(double value) : value_(value) {}  // NOLINT(google-explicit-constructor)
    static constexpr ScreenLength usual(double value) {
        ScreenLength length(value);
        length.said_ = false;
        return length;
    }

    /// As it was said, or in pixels of a picture of 720 lines.
    constexpr double value() const { return value_; }
    constexpr bool said() const { return said_; }
    constexpr operator double() const { return value_; }  // NOLINT(google-explicit-constructor)

    constexpr bool operator==(const ScreenLength&) const = default;
    friend constexpr bool operator==(const ScreenLength& length, double value) {
        return length.value_ == value;
    }

  private:
    double value_;
    bool said_ = true;
};

/// A field that is a length on the screen: its path within its layer's message, and what it may be, in
/// pixels.
struct LengthField {
    std::string_view path;
    double least, greatest;

    /// The last part of the path.
    constexpr std::string_view name() const { return path.substr(path.rfind('.') + 1); }

    /// In pixels of a picture; what is shorter or longer than may be is as short or long as may be.
    constexpr double inPixels(const ScreenLength& length, std::uint32_t height, double scale) const {
        return std::clamp(length.value() * lengthScale(height, scale, length.said()), least, greatest);
    }
};

}  // namespace mote
