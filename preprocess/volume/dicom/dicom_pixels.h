// SPDX-License-Identifier: GPL-3.0-or-later
//
// DicomPixels: the values of the frames of one DICOM file. Keeps the file open and knows where its frames
// lie. One owner, one thread at a time.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "preprocess/volume/dicom/dicom_files.h"
#include "preprocess/volume/dicom/dicom_header.h"
#include "preprocess/volume/volume_shape.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// What a value is made of a stored number.
struct DicomScale {
    double slope = 1.0, intercept = 0.0;
};

/// Which of a picture's numbers stand for it. Errors, at `where`: unsupported (bits, colours or a transfer
/// syntax that are not read, with what to do), corrupt (fewer bytes than its frames need).
Status checkPixels(const DicomHeader& header, const std::string& where);
/// The type of values; of integers that which stored numbers, their bits and sign, fit into.
ScalarType typeOf(const DicomHeader& header);
/// Whether a picture is the darker the greater its numbers are.
bool isInverted(const DicomHeader& header);

class DicomPixels {
  public:
    /// `header`, for which checkPixels() holds, must outlive it. Errors: those of DicomFile::open; corrupt
    /// (fragments that are not those of its frames).
    static Result<DicomPixels> open(const DicomFile& file, const DicomHeader& header);

    /// The values of a frame, or of a slice of a mosaic, row by row; colours as their luminance. Errors:
    /// corrupt, resourceExhausted.
    Status read(std::uint32_t frame, const DicomScale& scale, std::span<float> values);
    /// Whether bits outside of those that are stored were other than 0, and left out.
    bool hadOtherBits() const { return otherBits_; }

  private:
    struct Piece {
        std::uint64_t at = 0;
        std::uint32_t bytes = 0;
    };

    DicomPixels(const DicomHeader& header, ByteStreamPtr data, std::string name)
        : header_(&header), data_(std::move(data)), name_(std::move(name)) {}
    std::uint64_t bytesOfPixel() const { return std::uint64_t{header_->samples} * header_->allocated / 8; }
    Status findFrames();
    Result<std::vector<std::vector<Piece>>> framesOf(std::vector<Piece> pieces, const std::string& table);
    Status take(std::uint64_t at, std::span<char> bytes);
    Status readCoded(std::uint32_t frame, std::size_t bytes);
    Status readFrame(std::uint32_t frame, const DicomScale& scale, std::span<float> values);
    Status readBits(std::uint32_t frame, const DicomScale& scale, std::span<float> values);
    void convert(std::span<const char> bytes, const DicomScale& scale, std::span<float> values);
    template <class Number>
    void convertAs(std::span<const char> bytes, const DicomScale& scale, std::span<float> values);

    const DicomHeader* header_;
    ByteStreamPtr data_;
    std::string name_;
    std::vector<std::vector<Piece>> frames_;  // of each frame its fragments; none if they lie in a row
    std::vector<char> block_, coded_;
    std::vector<float> mosaic_;  // once one of its slices was read
    bool otherBits_ = false;
};

}  // namespace mote::prep
