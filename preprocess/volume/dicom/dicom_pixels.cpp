// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_pixels.h"

#include <fmt/format.h>
#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <exception>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <new>
#include <optional>
#include <string_view>
#include <type_traits>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/archive_stream.h"
#include "preprocess/volume/dicom/dicom_stream.h"

namespace mote::prep {
namespace {

// Compressed pictures of DICOM files: RLE by our own code, the family of JPEG by GDCM, which nothing else
// knows of. Pure functions; called from one thread.

/// What is to be done with the pictures of a transfer syntax: nothing, to be decoded, or something that only
/// others can do.
enum class DicomCoding : std::uint8_t { plain, coded, other };

std::string syntaxName(std::string_view syntax);
glm::vec3 redOf(const glm::vec3& ybr);

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

/// Reads the size of JPEG and JPEG-LS: in the one segment that begins a frame. All before the first scan must
/// be segments.
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

/// Reads the size of JPEG 2000: in the segment SIZ, perhaps behind the boxes of a JP2 file.
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

DicomCoding codingOf(std::string_view syntax) {
    const Syntax* const known = find(syntax);
    return known == nullptr ? DicomCoding::other : known->coding;
}

/// "JPEG 2000, lossless"; the UID itself where it is not known.
std::string syntaxName(std::string_view syntax) {
    const Syntax* const known = find(syntax);
    return known == nullptr ? fmt::format("transfer syntax {}", syntax.empty() ? "unknown" : syntax)
                            : std::string(known->name);
}

/// Red, green and blue, 0 to 255, of luminance and differences of blue and red (PS3.3, C.7.6.3.1.2).
glm::vec3 redOf(const glm::vec3& ybr) {
    const float y = ybr.x, blue = ybr.y - 128.0F, red = ybr.z - 128.0F;
    const glm::vec3 made(y + 1.402F * red, y - 0.344136F * blue - 0.714136F * red, y + 1.772F * blue);
    return glm::clamp(made, 0.0F, 255.0F);
}

/// Decodes one frame into `pixels`, whose bytes are those of the header's rows, columns, samples and bits, in
/// the machine's byte order and pixel by pixel; colours are red, green and blue, whatever they were. `where`
/// is for messages. Errors: corrupt (damaged, or of another size than the header says), resourceExhausted.
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
    return corrupt(where, fmt::format("says {} bits of a pixel up to bit {}, within {}", header.stored,
                                      header.highBit, bits));
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
    return corrupt(
        name_,
        fmt::format("has {} fragments of compressed pixels for {} frames, and no table that says which are "
                    "whose",
                    fragments, count));
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
