// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/dicom/dicom_stream.h"
#include "preprocess/volume/dicom/dicom_tags.h"
#include "preprocess/volume/volume_shape.h"

namespace mote::prep {
namespace {

constexpr std::size_t preambleBytes = 128;
constexpr std::string_view magic = "DICM";
constexpr std::string_view implicitSyntax = "1.2.840.10008.1.2", deflatedSyntax = "1.2.840.10008.1.2.1.99",
                           bigSyntax = "1.2.840.10008.1.2.2", plainSyntax = "1.2.840.10008.1.2.1";
constexpr std::uint32_t headGroup = 2, lengthTag = 0x00020000, syntaxTag = 0x00020010,
                        sharedGroups = 0x52009229, frameGroups = 0x52009230, detectors = 0x00540022,
                        pixelTag = 0x7fe00010, floatTag = 0x7fe00008, doubleTag = 0x7fe00009;
constexpr std::uint16_t pixelGroup = 0x7fe0;

/// Sequences whose items say where frames lie and what their values are.
constexpr std::array<std::uint32_t, 7> macros{0x00209113, 0x00209116, 0x00289110, 0x00289145,
                                              0x00209111, 0x00189114, 0x0062000a};
constexpr std::uint32_t diffusionMacro = 0x00189117;

bool isMacro(std::uint32_t tag) {
    return tag == diffusionMacro || std::find(macros.begin(), macros.end(), tag) != macros.end();
}

constexpr std::uint32_t tableTag = 0x00283000;

class HeaderReader {
  public:
    HeaderReader(DicomStream& stream, DicomHeader& header) : stream_(stream), header_(header) {}

    /// All up to the pixels.
    Status read() {
        MOTE_RETURN_IF_ERROR(readElements(Place::file, stream_.left(), true));
        if (header_.frames.empty() || header_.frames.size() == header_.frameCount) return success();
        return stream_.corrupt(fmt::format("tells of {} frames, and of places of {}", header_.frameCount,
                                           header_.frames.size()));
    }

  private:
    enum class Place : std::uint8_t { file, shared, frame };

    /// Those of a data set or an item of `length` bytes, which may be undefined.
    Status readElements(Place place, std::uint64_t length, bool outermost) {
        const bool open = !outermost && length == DicomElement::undefined;
        const std::uint64_t begin = stream_.position();
        while (open || outermost || stream_.position() - begin < length) {
            MOTE_ASSIGN_OR_RETURN(const auto element, stream_.next());
            if (!element && outermost) return success();
            if (!element) return stream_.corrupt("ends within an item");
            if (element->tag == DicomElement::itemEnd) return success();
            if (outermost && element->group() == pixelGroup && isPixels(element->tag)) {
                return takePixels(*element);
            }
            MOTE_RETURN_IF_ERROR(readElement(place, *element));
        }
        return success();
    }

    Status readElement(Place place, const DicomElement& element) {
        const std::uint32_t tag = element.tag;
        if (place == Place::file) {
            if (tag == sharedGroups || tag == detectors) return readItems(Place::shared, element);
            if (tag == frameGroups) return readItems(Place::frame, element);
            header_.hasTable |= tag == tableTag;
        } else if (isMacro(tag)) {
            if (inMacro_) return stream_.skip(element);
            inMacro_ = true;
            auto status = readItems(place, element);
            inMacro_ = false;
            return status;
        }
        const DicomTag* const known = knownTag(tag);
        const bool wanted = known != nullptr && (place == Place::file || known->ofFrame != nullptr);
        if (!wanted || element.length == DicomElement::undefined) return stream_.skip(element);
        MOTE_ASSIGN_OR_RETURN(const auto value, stream_.value(element, known->vr));
        if (known->ofFrame == nullptr) {
            known->ofFile(value, header_);
        } else {
            known->ofFrame(value, header_, place == Place::frame ? header_.frames.back() : header_.common);
        }
        return success();
    }

    /// The items of a sequence. Those of the groups of frames are a frame each.
    Status readItems(Place place, const DicomElement& sequence) {
        const bool open = sequence.length == DicomElement::undefined;
        if (!open && sequence.length > stream_.left()) return stream_.corrupt("ends within a sequence");
        const std::uint64_t begin = stream_.position();
        for (bool once = true; open || stream_.position() - begin < sequence.length; once = false) {
            MOTE_ASSIGN_OR_RETURN(const auto item, stream_.next());
            if (!item) return stream_.corrupt("ends within a sequence");
            if (item->tag == DicomElement::sequenceEnd) return success();
            if (item->tag != DicomElement::item) return stream_.corrupt("has no item where one should be");
            if (sequence.tag == frameGroups) {
                MOTE_RETURN_IF_ERROR(addFrame());
            } else if (sequence.tag == detectors && !once) {
                MOTE_RETURN_IF_ERROR(stream_.skip(*item));  // another head of the camera
                continue;
            }
            MOTE_RETURN_IF_ERROR(readElements(place, item->length, false));
        }
        return success();
    }

    Status addFrame() {
        if (header_.frames.size() == VolumeShape::maxDimension) {
            return Error{ErrorCode::resourceExhausted, stream_.corrupt("").where,
                         fmt::format("tells of more than {} frames", VolumeShape::maxDimension)};
        }
        header_.frames.emplace_back();
        return success();
    }

    static bool isPixels(std::uint32_t tag) { return tag == pixelTag || tag == floatTag || tag == doubleTag; }

    /// What follows the pixels is padding and signatures.
    Status takePixels(const DicomElement& element) {
        header_.pixels = element.tag == pixelTag   ? DicomHeader::Pixels::integers
                         : element.tag == floatTag ? DicomHeader::Pixels::floats
                                                   : DicomHeader::Pixels::doubles;
        header_.pixelsAt = stream_.position();
        header_.encapsulated = element.length == DicomElement::undefined;
        header_.pixelBytes = header_.encapsulated ? 0 : element.length;
        if (header_.pixelBytes <= stream_.left()) return success();
        return stream_.corrupt(
            fmt::format("says {} bytes of pixels, and {} are there", element.length, stream_.left()));
    }

    DicomStream& stream_;
    DicomHeader& header_;
    bool inMacro_ = false;  // they hold no others
};

/// A data set without the preamble of PS3.10: its first element is of group 2 or 8, in either form.
bool beginsBare(std::string_view bytes) {
    if (bytes.size() < 8) return false;
    const auto group = loadNumber<std::uint16_t>(bytes.data(), false);
    const auto element = loadNumber<std::uint16_t>(bytes.data() + 2, false);
    const bool kinds = bytes[4] >= 'A' && bytes[4] <= 'Z' && bytes[5] >= 'A' && bytes[5] <= 'Z';
    const auto length = loadNumber<std::uint32_t>(bytes.data() + 4, false);
    if (group == 2) return kinds && element <= 0x0102;
    return group == 8 && element <= 0x0018 && (kinds || (length <= 64 && length % 2 == 0));
}

/// The head of a file, which always has kinds; the stream then stands behind it. Its first element says how
/// long it is; where that is missing, the first one of another group ends it.
Status readFileHead(DicomStream& stream, DicomHeader& header) {
    stream.setForm(true, false);
    std::optional<std::uint64_t> end;
    while (!end || stream.position() < *end) {
        const std::uint64_t begin = stream.position();
        MOTE_ASSIGN_OR_RETURN(const auto element, stream.next());
        if (!element) return stream.corrupt("has nothing but its head");
        if (element->group() != headGroup) {
            stream.seek(begin);
            if (header.syntax.empty()) header.syntax = element->vr.empty() ? implicitSyntax : plainSyntax;
            return success();
        }
        if (element->tag != lengthTag && element->tag != syntaxTag) {
            MOTE_RETURN_IF_ERROR(stream.skip(*element));
            continue;
        }
        MOTE_ASSIGN_OR_RETURN(const auto value, stream.value(*element, "UI"));
        if (element->tag == syntaxTag) header.syntax = uidOf(value);
        const auto length = value.numbers();
        if (element->tag == lengthTag && length.size() == 1 && length.front() >= 0) {
            end = stream.position() + static_cast<std::uint64_t>(length.front());
        }
    }
    return success();
}

Status readData(DicomStream& stream, DicomHeader& header) {
    header.bigEndian = header.syntax == bigSyntax;
    stream.setForm(header.syntax != implicitSyntax, header.bigEndian);
    MOTE_RETURN_IF_ERROR(HeaderReader(stream, header).read());
    const auto across = header.tilesAcross();
    const auto& place = header.common;
    const bool known = header.mosaic && place.position && place.orientation && place.pixelSpacing &&
                       (place.between || place.thickness) && header.frameCount == 1 &&
                       header.columns % across == 0 && header.rows % across == 0;
    if (!known) header.tiles = {};
    return success();
}

}  // namespace

std::uint32_t DicomHeader::tilesAcross() const {
    const auto least = static_cast<std::uint32_t>(std::ceil(std::sqrt(tiles.tiles)));
    return std::max(least, 1U);
}

bool DicomHeader::begins(std::string_view bytes) {
    return (bytes.size() >= headBytes && bytes.substr(preambleBytes, magic.size()) == magic) ||
           beginsBare(bytes);
}

Result<DicomHeader> DicomHeader::parse(ByteStreamPtr file) {
    std::string head(headBytes, '\0');
    MOTE_ASSIGN_OR_RETURN(const auto got, file->read(head));
    head.resize(got);
    if (!begins(head)) return corrupt(file->name(), "does not begin as a DICOM file");
    DicomHeader header;
    DicomStream stream(*file);
    const bool bare = got < headBytes || std::string_view(head).substr(preambleBytes) != magic;
    stream.seek(bare ? 0 : headBytes);
    MOTE_RETURN_IF_ERROR(readFileHead(stream, header));
    if (header.syntax != deflatedSyntax) {
        MOTE_RETURN_IF_ERROR(readData(stream, header));
        return header;
    }
    header.deflatedAt = stream.position();
    MOTE_ASSIGN_OR_RETURN(const auto data, dicomData(header, std::move(file)));
    DicomStream inflated(*data);
    MOTE_RETURN_IF_ERROR(readData(inflated, header));
    return header;
}

glm::dvec3 normalOf(const std::array<double, 6>& orientation) {
    return glm::cross(glm::dvec3(orientation[0], orientation[1], orientation[2]),
                      glm::dvec3(orientation[3], orientation[4], orientation[5]));
}

Result<ByteStreamPtr> dicomData(const DicomHeader& header, ByteStreamPtr file) {
    if (header.deflatedAt == 0) return file;
    MOTE_ASSIGN_OR_RETURN(auto deflated, partStream(std::move(file), header.deflatedAt));
    return inflatedStream(std::move(deflated), Inflater::Form::raw);
}

}  // namespace mote::prep
