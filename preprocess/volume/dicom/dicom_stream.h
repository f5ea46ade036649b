// SPDX-License-Identifier: GPL-3.0-or-later
//
// DicomStream: the data elements of a DICOM data set (PS3.5, chapter 7), one after the other, as they lie in
// bytes that nobody vouches for. DicomValue: what an element holds. Called from one thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/volume/byte_stream.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct DicomElement {
    static constexpr std::uint32_t undefined = 0xffffffff;
    static constexpr std::uint32_t item = 0xfffee000, itemEnd = 0xfffee00d, sequenceEnd = 0xfffee0dd;

    std::uint32_t tag = 0;  ///< the group's number in the upper half
    std::string vr;         ///< what kind of value it is, "DS"; "" if the file does not say
    std::uint32_t length = 0;

    std::uint32_t group() const { return tag >> 16U; }
};

struct DicomValue {
    std::string bytes, vr;
    bool bigEndian = false;

    std::vector<double> numbers() const;  ///< not a number if a text is none
    std::string text() const;             ///< without the padding at its ends
};

class DicomStream {
  public:
    static constexpr std::uint64_t longestValue = 1u << 20;  ///< that is read, bytes

    /// `bytes` must outlive it.
    explicit DicomStream(ByteStream& bytes) : bytes_(bytes), buffer_(bufferBytes) {}

    /// How elements are written: with their kinds or without, and in which byte order. A kind that is none is
    /// taken for a file that leaves kinds out.
    void setForm(bool kinds, bool bigEndian) { kinds_ = kinds, bigEndian_ = bigEndian; }
    bool bigEndian() const { return bigEndian_; }

    /// The tag and length of the next element, or nothing at the end. Errors: corrupt (cut short), those of
    /// ByteStream.
    Result<std::optional<DicomElement>> next();
    /// What the element that next() gave holds; `vr` counts if the file says none. Errors: corrupt.
    Result<DicomValue> value(const DicomElement& element, std::string_view vr);
    /// Steps over what it holds, be it a sequence without a length. Errors: corrupt.
    Status skip(const DicomElement& element);

    std::uint64_t position() const { return position_; }
    void seek(std::uint64_t position) { position_ = position; }
    /// How many bytes there may be behind the position.
    std::uint64_t left() const;
    Error corrupt(std::string message) const;

  private:
    static constexpr std::size_t bufferBytes = std::size_t{16} * 1024;

    /// Takes exactly `count` bytes; none if the end comes first.
    Result<std::string> take(std::size_t count);
    Status skipUndefined(bool kinds);

    ByteStream& bytes_;
    std::vector<char> buffer_;
    std::uint64_t bufferAt_ = 0;  // of the buffer's first byte
    std::size_t buffered_ = 0;
    std::uint64_t position_ = 0;
    bool kinds_ = true, bigEndian_ = false;
};

}  // namespace mote::prep
