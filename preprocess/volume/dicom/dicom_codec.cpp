// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_codec.h"

#include <fmt/format.h>
#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <exception>
#include <glm/common.hpp>
#include <new>
#include <optional>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

struct Syntax {
    std::string_view uid;
    DicomCoding coding;
    std::string_view name;
};
constexpr std::string_view rle = "1.2.840.10008.1.2.5";
constexpr std::array<Syntax, 14> syntaxes{{
    {"1.2.840.10008.1.2", DicomCoding::plain, "implicit, little endian"},
    {"1.2.840.10008.1.2.1", DicomCoding::plain, "explicit, little endian"},
    {"1.2.840.10008.1.2.1.99", DicomCoding::plain, "deflated"},
    {"1.2.840.10008.1.2.2", DicomCoding::plain, "explicit, big endian"},
    {"1.2.840.10008.1.2.4.50", DicomCoding::coded, "JPEG, 8 bits"},
    {"1.2.840.10008.1.2.4.51", DicomCoding::coded, "JPEG, 12 bits"},
    {"1.2.840.10008.1.2.4.57", DicomCoding::coded, "JPEG, lossless"},
    {"1.2.840.10008.1.2.4.70", DicomCoding::coded, "JPEG, lossless, first order"},
    {"1.2.840.10008.1.2.4.80", DicomCoding::coded, "JPEG-LS, lossless"},
    {"1.2.840.10008.1.2.4.81", DicomCoding::coded, "JPEG-LS, near lossless"},
    {"1.2.840.10008.1.2.4.90", DicomCoding::coded, "JPEG 2000, lossless"},
    {"1.2.840.10008.1.2.4.91", DicomCoding::coded, "JPEG 2000"},
    {"1.2.840.10008.1.2.4.100", DicomCoding::other, "MPEG-2"},
    {rle, DicomCoding::coded, "RLE"},
}};

const Syntax* find(std::string_view uid) {
    const auto* const found =
        std::find_if(syntaxes.begin(), syntaxes.end(), [&](const Syntax& each) { return each.uid == uid; });
    return found == syntaxes.end() ? nullptr : found;
}

/// The bytes of one segment: runs, and bytes as they are (PS3.5, G.3.1).
bool unpack(std::span<const char> from, std::span<char> pixels, std::size_t at, std::size_t step) {
    constexpr unsigned nothing = 128;
    std::size_t i = 0;
    while (at < pixels.size() && i < from.size()) {
        const auto head = static_cast<unsigned char>(from[i++]);
        if (head == nothing) continue;
        const bool run = head > nothing;
        const std::size_t count = run ? 2U * nothing + 1U - head : head + 1U;
        const std::size_t needed = run ? 1 : count;
        if (from.size() - i < needed) return false;
        for (std::size_t j = 0; j < count && at < pixels.size(); ++j, at += step) {
            pixels[at] = from[i + (run ? 0 : j)];
        }
        i += needed;
    }
    return at >= pixels.size();
}

/// A segment for each byte of a pixel, those of a sample from the most significant on.
Status decodeRle(const DicomHeader& header, std::span<const char> coded, std::span<char> pixels,
                 const std::string& where) {
    constexpr std::size_t headBytes = 64;
    const std::size_t width = header.allocated / 8, wanted = width * header.samples;
    const auto word = [&](std::size_t i) { return loadNumber<std::uint32_t>(coded.data() + 4 * i, false); };
    if (coded.size() < headBytes || word(0) != wanted || wanted >= headBytes / 4) {
        return corrupt(where, "its RLE data have another number of segments than a pixel has bytes");
    }
    for (std::size_t i = 0; i < wanted; ++i) {
        const std::size_t begin = word(i + 1), end = i + 1 < wanted ? word(i + 2) : coded.size();
        if (begin < headBytes || begin > end || end > coded.size()) {
            return corrupt(where, "its RLE data have a segment outside of themselves");
        }
        const std::size_t at = i / width * width + (width - 1 - i % width);
        if (!unpack(coded.subspan(begin, end - begin), pixels, at, wanted)) {
            return corrupt(where, "its RLE data end before its last pixel");
        }
    }
    return success();
}

/// What coded data say of themselves.
struct CodedSize {
    std::uint32_t rows = 0, columns = 0, samples = 0, bits = 0;
};

std::uint32_t big(std::span<const char> bytes, std::size_t at, std::size_t count) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < count; ++i)
        number = (number << 8U) | static_cast<unsigned char>(bytes[at + i]);
    return number;
}

bool beginsFrame(std::uint32_t marker) {
    constexpr std::uint32_t first = 0xc0, last = 0xcf, tables = 0xc4, reserved = 0xc8, arithmetic = 0xcc,
                            ls = 0xf7;
    const bool frame = marker >= first && marker <= last;
    return (frame && marker != tables && marker != reserved && marker != arithmetic) || marker == ls;
}

/// What other programs wrote of themselves is of a kind that there is: GDCM ends the process where it is
/// none.
bool isSane(std::uint32_t marker, std::span<const char> segment) {
    constexpr std::uint32_t jfif = 0xe0, adobe = 0xee;
    const std::string_view text(segment.data(), segment.size());
    if (marker == jfif && text.starts_with("JFIF")) return segment.size() > 5 && segment[5] == 1;
    if (marker == adobe && text.starts_with("Adobe")) return segment.size() > 11 && big(segment, 11, 1) <= 2;
    return true;
}

/// Of JPEG and JPEG-LS: in the one segment that begins a frame. All before the first scan must be segments.
std::optional<CodedSize> sizeOfJpeg(std::span<const char> coded) {
    constexpr std::uint32_t scan = 0xda, filling = 0xff, shortest = 8;
    std::optional<CodedSize> size;
    for (std::size_t at = 2; at + 4 <= coded.size();) {
        if (big(coded, at, 1) != filling) return std::nullopt;
        const std::uint32_t marker = big(coded, at + 1, 1), length = big(coded, at + 2, 2);
        if (marker == filling) {
            ++at;
            continue;
        }
        if (marker == scan) return size;
        if (length < 2 || length > coded.size() - at - 2) return std::nullopt;
        if (!isSane(marker, coded.subspan(at + 4, length - 2))) return std::nullopt;
        if (beginsFrame(marker)) {
            if (size || length < shortest) return std::nullopt;
            size = CodedSize{big(coded, at + 5, 2), big(coded, at + 7, 2), big(coded, at + 9, 1),
                             big(coded, at + 4, 1)};
        }
        at += 2 + length;
    }
    return std::nullopt;
}

/// Whether decoded pixels of three samples are luminance and differences of colours. JPEG with losses says it
/// itself, whatever the header has; JPEG 2000 undoes its own (YBR_RCT, YBR_ICT).
bool isYbr(const DicomHeader& header, std::span<const char> coded) {
    constexpr std::uint32_t filling = 0xff, scan = 0xda, jfif = 0xe0, adobe = 0xee, lossless = 0xc3,
                            ls = 0xf7;
    const bool said = header.photometric.starts_with("YBR_FULL");
    if (coded.size() < 2 || big(coded, 0, 2) != 0xffd8) return said;
    std::optional<bool> marked;
    for (std::size_t at = 2; at + 4 <= coded.size();) {
        const std::uint32_t marker = big(coded, at + 1, 1), length = big(coded, at + 2, 2);
        if (marker == filling) {
            ++at;
            continue;
        }
        if (marker == lossless || marker == ls) return said;
        if (marker == scan || length < 2 || length > coded.size() - at - 2) break;
        const std::string_view text(coded.data() + at + 4, length - 2);
        if (marker == jfif && text.starts_with("JFIF") && !marked) marked = true;
        if (marker == adobe && text.starts_with("Adobe") && text.size() > 11) marked = text[11] == 1;
        at += 2 + length;
    }
    return marked.value_or(said);
}

void makeRed(std::span<char> pixels) {
    for (std::size_t at = 0; at + 3 <= pixels.size(); at += 3) {
        glm::vec3 ybr;
        for (int i = 0; i < 3; ++i)
            ybr[i] = static_cast<unsigned char>(pixels[at + static_cast<std::size_t>(i)]);
        const glm::vec3 red = glm::round(redOf(ybr));
        for (int i = 0; i < 3; ++i)
            pixels[at + static_cast<std::size_t>(i)] = static_cast<char>(static_cast<unsigned char>(red[i]));
    }
}

/// Of JPEG 2000: in the segment SIZ, perhaps behind the boxes of a JP2 file.
std::optional<CodedSize> sizeOfJpeg2000(std::span<const char> coded) {
    static constexpr std::string_view begin = "\xff\x4f\xff\x51";
    constexpr std::size_t mostBoxes = 512, sizBytes = 43;
    const std::string_view head(coded.data(), std::min(coded.size(), mostBoxes));
    const std::size_t at = head.find(begin);
    if (at == std::string_view::npos || coded.size() - at < sizBytes) return std::nullopt;
    CodedSize size;
    size.columns = big(coded, at + 8, 4) - big(coded, at + 16, 4);
    size.rows = big(coded, at + 12, 4) - big(coded, at + 20, 4);
    size.samples = big(coded, at + 40, 2);
    size.bits = (big(coded, at + 42, 1) & 0x7fU) + 1;
    return size;
}

/// Libraries take memory for what the data say: that must be what the header says.
Status checkSize(const DicomHeader& header, std::span<const char> coded, const std::string& where) {
    const bool jpeg = coded.size() > 2 && big(coded, 0, 2) == 0xffd8;
    const auto size = jpeg ? sizeOfJpeg(coded) : sizeOfJpeg2000(coded);
    if (!size)
        return corrupt(where, fmt::format("its pixels do not begin as {} does", syntaxName(header.syntax)));
    const std::uint32_t wide = size->bits <= 8 ? 8 : size->bits <= 16 ? 16 : 32;
    if (size->rows == header.rows && size->columns == header.columns && size->samples == header.samples &&
        wide == header.allocated) {
        return success();
    }
    return corrupt(
        where, fmt::format("its compressed pixels are {} x {} of {} values of {} bits, and it says {} x {} "
                           "of {} of {}",
                           size->columns, size->rows, size->samples, size->bits, header.columns, header.rows,
                           header.samples, header.allocated));
}

bool decodeByGdcm(const DicomHeader& header, std::span<const char> coded, std::span<char> pixels) {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    gdcm::Fragment fragment;
    fragment.SetByteValue(coded.data(), gdcm::VL(static_cast<std::uint32_t>(coded.size())));
    const gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
    fragments->AddFragment(fragment);
    gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
    element.SetValue(*fragments);
    gdcm::Image image;
    image.SetNumberOfDimensions(2);
    image.SetDimension(0, header.columns);
    image.SetDimension(1, header.rows);
    const auto word = [](std::uint32_t number) { return static_cast<unsigned short>(number); };
    image.SetPixelFormat(gdcm::PixelFormat(word(header.samples), word(header.allocated), word(header.stored),
                                           word(header.highBit), header.isSigned ? 1 : 0));
    const auto photometric = gdcm::PhotometricInterpretation::GetPIType(header.photometric.c_str());
    image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation(photometric));
    image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(header.syntax.c_str()));
    image.SetDataElement(element);
    return image.GetBufferLength() == pixels.size() && image.GetBuffer(pixels.data());
}

}  // namespace

DicomCoding codingOf(std::string_view syntax) {
    const Syntax* const known = find(syntax);
    return known == nullptr ? DicomCoding::other : known->coding;
}

std::string syntaxName(std::string_view syntax) {
    const Syntax* const known = find(syntax);
    return known == nullptr ? fmt::format("transfer syntax {}", syntax.empty() ? "unknown" : syntax)
                            : std::string(known->name);
}

glm::vec3 redOf(const glm::vec3& ybr) {
    const float y = ybr.x, blue = ybr.y - 128.0F, red = ybr.z - 128.0F;
    const glm::vec3 made(y + 1.402F * red, y - 0.344136F * blue - 0.714136F * red, y + 1.772F * blue);
    return glm::clamp(made, 0.0F, 255.0F);
}

Status decodeDicom(const DicomHeader& header, std::span<const char> coded, std::span<char> pixels,
                   const std::string& where) {
    const bool ybr = header.samples == 3 && isYbr(header, coded);
    if (header.syntax == rle) {
        MOTE_RETURN_IF_ERROR(decodeRle(header, coded, pixels, where));
        if (ybr) makeRed(pixels);
        return success();
    }
    MOTE_RETURN_IF_ERROR(checkSize(header, coded, where));
    try {
        if (decodeByGdcm(header, coded, pixels)) {
            if (ybr) makeRed(pixels);
            return success();
        }
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::resourceExhausted, where, "its pixels need more memory than there is"};
    } catch (const std::exception&) {
        // What it says may quote the file.
    }
    return corrupt(where, fmt::format("its pixels ({}) are damaged", syntaxName(header.syntax)));
}

}  // namespace mote::prep
