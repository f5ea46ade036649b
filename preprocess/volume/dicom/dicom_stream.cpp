// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr std::size_t deepest = 64;

bool isLetter(char c) {
    return c >= 'A' && c <= 'Z';
}

/// Kinds with a length of 32 bits (PS3.5, 7.1.2).
bool isLong(std::string_view vr) {
    static constexpr std::array<std::string_view, 13> kinds{"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                            "SV", "UC", "UN", "UR", "UT", "UV"};
    return std::find(kinds.begin(), kinds.end(), vr) != kinds.end();
}

template <class Number>
std::vector<double> binary(const std::string& bytes, bool bigEndian) {
    std::vector<double> numbers;
    for (std::size_t at = 0; at + sizeof(Number) <= bytes.size(); at += sizeof(Number)) {
        numbers.push_back(static_cast<double>(loadNumber<Number>(bytes.data() + at, bigEndian)));
    }
    return numbers;
}

}  // namespace

std::vector<double> DicomValue::numbers() const {
    if (vr == "US") return binary<std::uint16_t>(bytes, bigEndian);
    if (vr == "SS") return binary<std::int16_t>(bytes, bigEndian);
    if (vr == "UL") return binary<std::uint32_t>(bytes, bigEndian);
    if (vr == "SL") return binary<std::int32_t>(bytes, bigEndian);
    if (vr == "FL") return binary<float>(bytes, bigEndian);
    if (vr == "FD") return binary<double>(bytes, bigEndian);
    std::vector<double> numbers;
    const std::string all = text();
    for (std::size_t begin = 0; !all.empty() && begin <= all.size();) {
        const std::size_t end = std::min(all.find('\\', begin), all.size());
        const auto number = parseNumber(trim(std::string_view(all).substr(begin, end - begin)));
        numbers.push_back(number.value_or(std::numeric_limits<double>::quiet_NaN()));
        begin = end + 1;
    }
    return numbers;
}

std::string DicomValue::text() const {
    std::string_view rest = bytes;
    while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\0')) rest.remove_suffix(1);
    while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    return std::string(rest);
}

Error DicomStream::corrupt(std::string message) const {
    return {ErrorCode::corrupt, fmt::format("{}: byte {}", bytes_.name(), position_), std::move(message)};
}

std::uint64_t DicomStream::left() const {
    const std::uint64_t most = bytes_.mostBytes();
    return most - std::min(most, position_);
}

Result<std::string> DicomStream::take(std::size_t count) {
    std::string taken(count, '\0');
    for (std::size_t done = 0; done < count;) {
        if (position_ < bufferAt_ || position_ >= bufferAt_ + buffered_) {
            MOTE_RETURN_IF_ERROR(bytes_.seek(position_));
            bufferAt_ = position_;
            MOTE_ASSIGN_OR_RETURN(buffered_, bytes_.read(buffer_));
            if (buffered_ == 0) return std::string();
        }
        const auto from = static_cast<std::size_t>(position_ - bufferAt_);
        const std::size_t some = std::min(count - done, buffered_ - from);
        std::memcpy(taken.data() + done, buffer_.data() + from, some);
        done += some;
        position_ += some;
    }
    return taken;
}

Result<std::optional<DicomElement>> DicomStream::next() {
    const std::uint64_t begin = position_;
    MOTE_ASSIGN_OR_RETURN(const auto head, take(8));
    if (head.empty()) {
        // A few bytes of padding may stand behind the last element.
        position_ = begin;
        return std::optional<DicomElement>();
    }
    DicomElement element;
    element.tag = (std::uint32_t{loadNumber<std::uint16_t>(head.data(), bigEndian_)} << 16U) |
                  loadNumber<std::uint16_t>(head.data() + 2, bigEndian_);
    constexpr std::uint32_t itemGroup = DicomElement::item >> 16U;
    if (!kinds_ || element.group() == itemGroup || !isLetter(head[4]) || !isLetter(head[5])) {
        element.length = loadNumber<std::uint32_t>(head.data() + 4, bigEndian_);
        return std::optional(element);
    }
    element.vr = head.substr(4, 2);
    if (!isLong(element.vr)) {
        element.length = loadNumber<std::uint16_t>(head.data() + 6, bigEndian_);
        return std::optional(element);
    }
    MOTE_ASSIGN_OR_RETURN(const auto length, take(4));
    if (length.empty()) return corrupt("ends within an element");
    element.length = loadNumber<std::uint32_t>(length.data(), bigEndian_);
    return std::optional(element);
}

Result<DicomValue> DicomStream::value(const DicomElement& element, std::string_view vr) {
    if (element.length > longestValue || element.length > left()) {
        return corrupt(fmt::format("says {} bytes in an element that has few", element.length));
    }
    DicomValue value;
    value.vr = element.vr.empty() || element.vr == "UN" ? std::string(vr) : element.vr;
    value.bigEndian = bigEndian_;
    if (element.length == 0) return value;
    MOTE_ASSIGN_OR_RETURN(value.bytes, take(element.length));
    if (value.bytes.empty()) return corrupt("ends within an element");
    return value;
}

Status DicomStream::skip(const DicomElement& element) {
    if (element.length == DicomElement::undefined) return skipUndefined(kinds_ && element.vr != "UN");
    if (element.length > left()) return corrupt("ends within an element");
    position_ += element.length;
    return success();
}

/// What is inside an unknown kind without a length is written without kinds.
Status DicomStream::skipUndefined(bool kinds) {
    const bool outside = kinds_;
    std::vector<bool> open{kinds};
    while (!open.empty()) {
        kinds_ = open.back();
        const auto element = next();
        kinds_ = outside;
        if (!element) return element.error();
        if (!*element) return corrupt("ends within a sequence");
        const DicomElement& each = **element;
        if (each.tag == DicomElement::itemEnd || each.tag == DicomElement::sequenceEnd) {
            open.pop_back();
        } else if (each.length == DicomElement::undefined) {
            if (open.size() == deepest) return corrupt("has sequences that are nested too deep");
            open.push_back(open.back() && each.vr != "UN");
        } else {
            if (each.length > left()) return corrupt("ends within an element");
            position_ += each.length;
        }
    }
    return success();
}

}  // namespace mote::prep
