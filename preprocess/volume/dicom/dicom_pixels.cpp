// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <type_traits>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/archive_stream.h"
#include "preprocess/volume/dicom/dicom_codec.h"
#include "preprocess/volume/dicom/dicom_stream.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t blockBytes = 1u << 20;
// A compressed frame of so little may say any size; one of more must hold what it says, at this ratio.
constexpr std::uint64_t freely = 16u << 20, greatestRatio = 4096;
constexpr std::size_t mostFragments = 1u << 20;

std::uint64_t bitsOfFrame(const DicomHeader& header) {
    return std::uint64_t{header.rows} * header.columns * header.samples * header.allocated;
}

/// In colour, the numbers of a pixel must be known: red, green, blue, or the luminance first.
Status checkColours(const DicomHeader& header, const std::string& where) {
    const bool coded = codingOf(header.syntax) == DicomCoding::coded;
    const std::string_view name = header.photometric;
    const bool red = name == "RGB" || name == "YBR_FULL" ||
                     (coded && (name == "YBR_RCT" || name == "YBR_ICT" || name == "YBR_FULL_422"));
    const bool known = header.samples == 3 && header.allocated == 8 && red;
    if (known || header.samples == 1) return success();
    return unsupported(
        where, fmt::format("is in colour ({}, {} values of {} bits), of which RGB is read: dcmdjpeg or "
                           "gdcmconv --raw may make that of it",
                           name, header.samples, header.allocated));
}

Status checkFloats(const DicomHeader& header, const std::string& where) {
    const std::uint32_t bits = header.pixels == DicomHeader::Pixels::floats ? 32 : 64;
    if (header.allocated == bits && header.samples == 1 && !header.encapsulated) return success();
    return unsupported(where, "has floating numbers in a form that is not read");
}

Status checkBits(const DicomHeader& header, const std::string& where) {
    const std::uint32_t bits = header.allocated;
    if (bits == 1 && (header.encapsulated || header.bigEndian)) {
        return unsupported(
            where,
            "has one bit for each pixel, compressed or in words of the other byte order, which is not read: "
            "gdcmconv --raw makes others");
    }
    if (bits != 1 && bits != 8 && bits != 16 && bits != 32) {
        return unsupported(where, fmt::format("has {} bits for each pixel; 1, 8, 16 and 32 are read", bits));
    }
    if (header.bigEndian && bits == 8) {
        return unsupported(where,
                           "has 8-bit pixels in words of the other byte order: gdcmconv --raw makes others");
    }
    if (header.stored >= 1 && header.stored <= header.highBit + 1 && header.highBit < bits) return success();
    return Error{
        ErrorCode::corrupt, where,
        fmt::format("says {} bits of a pixel up to bit {}, within {}", header.stored, header.highBit, bits)};
}

/// What a frame of `bytes` compressed ones may become.
Status checkRatio(const DicomHeader& header, std::uint64_t bytes, const std::string& where) {
    const std::uint64_t frame = bitsOfFrame(header) / 8;
    if (frame <= freely || frame / greatestRatio <= bytes) return success();
    return corrupt(where, fmt::format("says {} x {} pixels, more than its {} bytes can hold", header.columns,
                                      header.rows, bytes));
}

}  // namespace

Status checkPixels(const DicomHeader& header, const std::string& where) {
    const auto coding = codingOf(header.syntax);
    if (coding == DicomCoding::other || header.encapsulated != (coding == DicomCoding::coded)) {
        return unsupported(where,
                           fmt::format("its pixels are in {}, which is not read: gdcmconv --raw or dcm2niix "
                                       "may make of it what is",
                                       syntaxName(header.syntax)));
    }
    if (header.mosaic && header.tiles.tiles == 0) {
        return unsupported(
            where,
            "is a mosaic, all slices in one picture, and does not say in a known form where they lie: "
            "dcm2niix may make NIfTI of it");
    }
    MOTE_RETURN_IF_ERROR(header.pixels == DicomHeader::Pixels::integers ? checkBits(header, where)
                                                                        : checkFloats(header, where));
    MOTE_RETURN_IF_ERROR(checkColours(header, where));
    if (header.otherFrames && header.frames.empty() && header.frameCount > 1) {
        return unsupported(where, fmt::format("has {} frames that are times or views (a film), no slices",
                                              header.frameCount));
    }
    VolumeShape slice;
    MOTE_RETURN_IF_ERROR(setDimensions(slice, header.columns, header.rows, 1, where));
    // Frames of bits follow one another within bytes.
    const auto needed = bitsOfFrame(header), held = 8 * header.pixelBytes / std::max(header.frameCount, 1u);
    if (header.encapsulated || held >= needed) return success();
    return corrupt(
        where, fmt::format("its {} frames of {} x {} need {} bytes each, and {} are there", header.frameCount,
                           header.columns, header.rows, (needed + 7) / 8, header.pixelBytes));
}

ScalarType typeOf(const DicomHeader& header) {
    if (header.pixels == DicomHeader::Pixels::floats) return ScalarType::f32;
    if (header.pixels == DicomHeader::Pixels::doubles) return ScalarType::f64;
    if (header.samples > 1) return ScalarType::f32;
    if (header.allocated <= 8) return header.isSigned ? ScalarType::i8 : ScalarType::u8;
    if (header.allocated == 16) return header.isSigned ? ScalarType::i16 : ScalarType::u16;
    return header.isSigned ? ScalarType::i32 : ScalarType::u32;
}

bool isInverted(const DicomHeader& header) {
    return header.photometric == "MONOCHROME1" && header.pixels == DicomHeader::Pixels::integers;
}

Result<DicomPixels> DicomPixels::open(const DicomFile& file, const DicomHeader& header) {
    MOTE_ASSIGN_OR_RETURN(auto stream, file.open());
    if (file.entry) MOTE_RETURN_IF_ERROR(checkWhole(*stream));
    MOTE_ASSIGN_OR_RETURN(auto data, dicomData(header, std::move(stream)));
    DicomPixels pixels(header, std::move(data), file.name());
    if (header.encapsulated) MOTE_RETURN_IF_ERROR(pixels.findFrames());
    return pixels;
}

/// The first item is a table of offsets, perhaps empty; each other one is a fragment.
Status DicomPixels::findFrames() {
    DicomStream stream(*data_);
    stream.seek(header_->pixelsAt);
    std::vector<Piece> pieces;
    std::string table;
    for (bool first = true;; first = false) {
        MOTE_ASSIGN_OR_RETURN(const auto item, stream.next());
        // Writers that were interrupted leave the last mark out; what is missing is seen by the count.
        if (!item || item->tag == DicomElement::sequenceEnd) break;
        if (item->tag != DicomElement::item || item->length == DicomElement::undefined) {
            return stream.corrupt("has no fragment where one should be");
        }
        if (first) {
            MOTE_ASSIGN_OR_RETURN(const auto value, stream.value(*item, "UL"));
            table = value.bytes;
            continue;
        }
        pieces.push_back({stream.position(), item->length});
        MOTE_RETURN_IF_ERROR(stream.skip(*item));
        if (pieces.size() > mostFragments) return stream.corrupt("has more fragments than are counted");
    }
    MOTE_ASSIGN_OR_RETURN(frames_, framesOf(std::move(pieces), table));
    for (const auto& frame : frames_) {
        std::uint64_t stored = 0;
        for (const auto& piece : frame) stored += piece.bytes;
        MOTE_RETURN_IF_ERROR(checkRatio(*header_, stored, name_));
    }
    return success();
}

/// Which fragments are one frame: all of a single one, one each, or as the table says.
Result<std::vector<std::vector<DicomPixels::Piece>>> DicomPixels::framesOf(std::vector<Piece> pieces,
                                                                           const std::string& table) {
    const std::size_t count = header_->frameCount, fragments = pieces.size();
    std::vector<std::vector<Piece>> frames;
    if (count == 1 && !pieces.empty()) {
        frames.push_back(std::move(pieces));
    } else if (pieces.size() == count) {
        for (const auto& piece : pieces) frames.push_back({piece});
    } else if (pieces.size() > count && table.size() == count * 4) {
        for (std::size_t i = 0, next = 0; i < pieces.size(); ++i) {
            // From the first fragment's item on.
            const bool begins = next < count && pieces[i].at - pieces[0].at ==
                                                    loadNumber<std::uint32_t>(&table[4 * next], false);
            if (begins) frames.emplace_back(), ++next;
            if (frames.empty()) break;
            frames.back().push_back(pieces[i]);
        }
    }
    if (frames.size() == count) return frames;
    return Error{
        ErrorCode::corrupt, name_,
        fmt::format("has {} fragments of compressed pixels for {} frames, and no table that says which are "
                    "whose",
                    fragments, count)};
}

Status DicomPixels::take(std::uint64_t at, std::span<char> bytes) {
    MOTE_RETURN_IF_ERROR(data_->seek(at));
    MOTE_ASSIGN_OR_RETURN(const auto got, data_->read(bytes));
    if (got == bytes.size()) return success();
    return corrupt(name_, "ends before its last pixel");
}

Status DicomPixels::readCoded(std::uint32_t frame, std::size_t bytes) {
    std::uint64_t stored = 0;
    for (const auto& piece : frames_[frame]) stored += piece.bytes;
    if (stored > data_->mostBytes()) return corrupt(name_, "ends before its last pixel");
    coded_.resize(static_cast<std::size_t>(stored));
    std::size_t done = 0;
    for (const auto& piece : frames_[frame]) {
        MOTE_RETURN_IF_ERROR(take(piece.at, std::span(coded_).subspan(done, piece.bytes)));
        done += piece.bytes;
    }
    block_.resize(bytes);
    return decodeDicom(*header_, coded_, block_,
                       header_->frameCount > 1 ? fmt::format("{}: frame {}", name_, frame + 1) : name_);
}

/// The first pixel is the least bit (PS3.5, 8.1.1).
Status DicomPixels::readBits(std::uint32_t frame, const DicomScale& scale, std::span<float> values) {
    const std::uint64_t first = std::uint64_t{frame} * values.size(), shift = first % 8;
    block_.resize(static_cast<std::size_t>((shift + values.size() + 7) / 8));
    MOTE_RETURN_IF_ERROR(take(header_->pixelsAt + first / 8, block_));
    const bool inverted = isInverted(*header_);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::uint64_t at = shift + i;
        const bool set = ((static_cast<unsigned char>(block_[at / 8]) >> (at % 8)) & 1U) != 0;
        values[i] = static_cast<float>((set != inverted ? scale.slope : 0.0) + scale.intercept);
    }
    return success();
}

Status DicomPixels::read(std::uint32_t frame, const DicomScale& scale, std::span<float> values) {
    const std::uint32_t across = header_->tilesAcross();
    if (across == 1) return readFrame(frame, scale, values);
    const std::size_t columns = header_->columns, width = header_->sliceColumns(),
                      height = header_->sliceRows();
    if (mosaic_.empty()) {
        std::vector<float> whole(columns * header_->rows);
        MOTE_RETURN_IF_ERROR(readFrame(0, scale, whole));
        mosaic_ = std::move(whole);
    }
    const std::size_t first = frame / across * height * columns + frame % across * width;
    for (std::size_t row = 0; row < height; ++row)
        std::copy_n(&mosaic_[first + row * columns], width, &values[row * width]);
    return success();
}

Status DicomPixels::readFrame(std::uint32_t frame, const DicomScale& scale, std::span<float> values) {
    if (header_->allocated == 1) return readBits(frame, scale, values);
    const std::uint64_t width = bytesOfPixel(), whole = values.size() * width;
    if (header_->encapsulated) {
        MOTE_RETURN_IF_ERROR(readCoded(frame, static_cast<std::size_t>(whole)));
        convert(block_, scale, values);
        return success();
    }
    const std::uint64_t begin = header_->pixelsAt + whole * frame;
    // Of planes, one a colour, all are needed at once.
    const std::uint64_t most = header_->samples > 1 ? whole : std::max(blockBytes / width * width, width);
    for (std::uint64_t done = 0; done < whole;) {
        block_.resize(static_cast<std::size_t>(std::min(most, whole - done)));
        MOTE_RETURN_IF_ERROR(take(begin + done, block_));
        const auto count = static_cast<std::size_t>(block_.size() / width);
        convert(block_, scale, values.subspan(static_cast<std::size_t>(done / width), count));
        done += block_.size();
    }
    return success();
}

void DicomPixels::convert(std::span<const char> bytes, const DicomScale& scale, std::span<float> values) {
    if (header_->pixels != DicomHeader::Pixels::integers) {
        return decodeSamples(bytes, {typeOf(*header_), header_->bigEndian, scale.slope, scale.intercept},
                             values);
    }
    if (header_->samples == 3) {
        const bool planes = header_->planar && !header_->encapsulated;
        const std::size_t step = planes ? 1 : 3, plane = planes ? values.size() : 1;
        // What was compressed is red, green and blue by now.
        const bool ybr = !header_->encapsulated && header_->photometric == "YBR_FULL";
        const auto number = [&](std::size_t at) {
            return static_cast<float>(static_cast<unsigned char>(bytes[at]));
        };
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::size_t at = i * step;
            const glm::vec3 stored(number(at), number(at + plane), number(at + 2 * plane));
            values[i] = glm::dot(glm::vec3(0.2126F, 0.7152F, 0.0722F), ybr ? redOf(stored) : stored);
        }
        return;
    }
    if (header_->allocated == 8) return convertAs<std::uint8_t>(bytes, scale, values);
    if (header_->allocated == 16) return convertAs<std::uint16_t>(bytes, scale, values);
    return convertAs<std::uint32_t>(bytes, scale, values);
}

/// The stored bits of each word, with their sign; turned round where white is the least.
template <class Number>
void DicomPixels::convertAs(std::span<const char> bytes, const DicomScale& scale, std::span<float> values) {
    const std::uint32_t bits = header_->stored, shift = header_->highBit + 1 - bits;
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1, sign = std::uint64_t{1} << (bits - 1);
    const bool big = header_->bigEndian, inverted = isInverted(*header_), isSigned = header_->isSigned;
    const std::uint64_t full = (std::uint64_t{1} << (8 * sizeof(Number))) - 1,
                        above = full & ~(mask << shift);
    const double top = isSigned ? -1.0 : static_cast<double>(mask);
    bool other = false;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::uint64_t word = loadNumber<Number>(bytes.data() + i * sizeof(Number), big);
        const std::uint64_t kept = (word >> shift) & mask, rest = word & above;
        const bool negative = isSigned && (kept & sign) != 0;
        other |= rest != 0 && !(negative && shift == 0 && rest == above);
        double number = static_cast<double>(kept) - (negative ? static_cast<double>(mask) + 1.0 : 0.0);
        if (inverted) number = top - number;
        values[i] = static_cast<float>(scale.slope * number + scale.intercept);
    }
    otherBits_ |= other;
}

}  // namespace mote::prep
