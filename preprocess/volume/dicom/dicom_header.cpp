// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/dicom/dicom_stream.h"
#include "preprocess/volume/volume_shape.h"

namespace mote::prep {
namespace {

// The data elements that are looked at (PS3.6), all others being nobody's business: which they are, and where
// a header keeps what they hold. Free of threads.

struct DicomTag {
    std::uint32_t tag;
    std::string_view vr;  ///< if the file does not say it
    void (*ofFile)(const DicomValue& value, DicomHeader& header);
    /// Takes one that every frame may have for itself; else null.
    void (*ofFrame)(const DicomValue& value, DicomHeader& header, DicomFrame& frame);
};

std::string wordOf(const DicomValue& value);
std::string uidOf(const DicomValue& value);

using Value = const DicomValue&;
using Header = DicomHeader&;
using Frame = DicomFrame&;

std::optional<double> first(Value value) {
    const auto numbers = value.numbers();
    if (numbers.empty() || !std::isfinite(numbers.front())) return std::nullopt;
    return numbers.front();
}

std::uint32_t whole(Value value) {
    const auto number = first(value);
    return number && *number >= 0 && *number < 0x1p32 ? static_cast<std::uint32_t>(*number) : 0;
}

template <std::size_t count>
std::optional<std::array<double, count>> several(Value value) {
    const auto numbers = value.numbers();
    const bool finite =
        std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (numbers.size() != count || !finite) return std::nullopt;
    std::array<double, count> taken{};
    std::copy(numbers.begin(), numbers.end(), taken.begin());
    return taken;
}

/// Text of which nothing is kept but what the standard has in it.
std::string plain(Value value, std::size_t longest, bool (*known)(char)) {
    std::string text = value.text();
    return text.size() <= longest && std::all_of(text.begin(), text.end(), known) ? text : std::string();
}

/// "142530.25" in seconds of the day.
std::optional<double> clock(Value value) {
    const auto number = first(value);
    if (!number || !(*number >= 0 && *number < 240000)) return std::nullopt;
    const double hours = std::floor(*number / 1e4), minutes = std::floor(std::fmod(*number, 1e4) / 100);
    return hours * 3600 + minutes * 60 + std::fmod(*number, 100.0);
}

/// Pictures of one kind have one number: that of their words.
void takeKind(Value value, Header header) {
    const std::string text = value.text();
    header.mosaic = text.find("MOSAIC") != std::string::npos;
    std::uint32_t number = 2166136261;  // FNV-1a: the same in every run
    for (const char c : text) number = (number ^ static_cast<unsigned char>(c)) * 16777619U;
    header.common.mark(DicomMark::kind) = number;
}

/// Siemens' elements lie where their block is, of which there are few.
void takeMosaic(Value value, Header header) {
    if (const auto mosaic = siemensMosaic(value.bytes)) header.tiles = *mosaic;
}

void takeUnit(Value value, Header header, Frame) {
    header.saysUnit = true;
    header.valueUnit = value.text() == "HU" ? "HU" : "";
}

/// What frames go by: slices of a camera, or places of a dose, and nothing else.
void takeIncrement(Value value, Header header) {
    for (std::size_t at = 0; at + 4 <= value.bytes.size(); at += 4) {
        const auto group = loadNumber<std::uint16_t>(value.bytes.data() + at, value.bigEndian);
        const auto element = loadNumber<std::uint16_t>(value.bytes.data() + at + 2, value.bigEndian);
        const bool slices = (group == 0x0054 && element == 0x0080) || (group == 0x3004 && element == 0x000c);
        header.otherFrames |= !slices;
    }
}

void takePosition(Value value, Header, Frame frame) {
    if (const auto at = several<3>(value)) frame.position = glm::dvec3((*at)[0], (*at)[1], (*at)[2]);
}

void takeSpacing(Value value, Header header, Frame frame) {
    frame.pixelSpacing = several<2>(value);
    header.looseSpacing &= !frame.pixelSpacing.has_value();
}

/// At the detector or as it was asked for, which is not quite that in the patient.
void takeLooseSpacing(Value value, Header header, Frame frame) {
    if (frame.pixelSpacing) return;
    frame.pixelSpacing = several<2>(value);
    header.looseSpacing = frame.pixelSpacing.has_value();
}

constexpr DicomTag tags[] = {
    {0x00080008, "CS", takeKind, nullptr},
    {0x00080018, "UI", [](Value v, Header h) { h.sopInstance = uidOf(v); }, nullptr},
    {0x00080032, "TM", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::clock) = clock(v); }},
    {0x00080060, "CS", [](Value v, Header h) { h.modality = wordOf(v); }, nullptr},
    {0x00180050, "DS", nullptr, [](Value v, Header, Frame f) { f.thickness = first(v); }},
    {0x00180081, "DS", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::echo) = first(v); }},
    {0x00180088, "DS", nullptr, [](Value v, Header, Frame f) { f.between = first(v); }},
    {0x00181060, "DS", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::trigger) = first(v); }},
    {0x00181164, "DS", nullptr, takeLooseSpacing},
    {0x00182010, "DS", nullptr, takeLooseSpacing},
    {0x00189082, "FD", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::echo) = first(v); }},
    {0x00189087, "FD", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::diffusion) = first(v); }},
    {0x0020000e, "UI", [](Value v, Header h) { h.series = uidOf(v); }, nullptr},
    {0x00200011, "IS", [](Value v, Header h) { h.seriesNumber = first(v); }, nullptr},
    {0x00200012, "IS", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::acquisition) = first(v); }},
    {0x00200013, "IS", [](Value v, Header h) { h.instance = first(v); }, nullptr},
    {0x00200032, "DS", nullptr, takePosition},
    {0x00200037, "DS", nullptr, [](Value v, Header, Frame f) { f.orientation = several<6>(v); }},
    {0x00200100, "IS", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::temporal) = first(v); }},
    {0x00201041, "DS", [](Value v, Header h) { h.sliceLocation = first(v); }, nullptr},
    {0x00209128, "UL", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::temporal) = first(v); }},
    {0x00280002, "US", [](Value v, Header h) { h.samples = whole(v); }, nullptr},
    {0x00280004, "CS", [](Value v, Header h) { h.photometric = wordOf(v); }, nullptr},
    {0x00280006, "US", [](Value v, Header h) { h.planar = whole(v) == 1; }, nullptr},
    {0x00280008, "IS", [](Value v, Header h) { h.frameCount = whole(v); }, nullptr},
    {0x00280009, "AT", takeIncrement, nullptr},
    {0x00280010, "US", [](Value v, Header h) { h.rows = whole(v); }, nullptr},
    {0x00280011, "US", [](Value v, Header h) { h.columns = whole(v); }, nullptr},
    {0x00280030, "DS", nullptr, takeSpacing},
    {0x00280100, "US", [](Value v, Header h) { h.allocated = whole(v); }, nullptr},
    {0x00280101, "US", [](Value v, Header h) { h.stored = whole(v); }, nullptr},
    {0x00280102, "US", [](Value v, Header h) { h.highBit = whole(v); }, nullptr},
    {0x00280103, "US", [](Value v, Header h) { h.isSigned = whole(v) == 1; }, nullptr},
    {0x00281052, "DS", nullptr, [](Value v, Header, Frame f) { f.intercept = first(v); }},
    {0x00281053, "DS", nullptr, [](Value v, Header, Frame f) { f.slope = first(v); }},
    {0x00281054, "LO", nullptr, takeUnit},
    {0x00282110, "CS", [](Value v, Header h) { h.lossy = v.text() == "01"; }, nullptr},
    {0x00291010, "OB", takeMosaic, nullptr},
    {0x00291110, "OB", takeMosaic, nullptr},
    {0x00291210, "OB", takeMosaic, nullptr},
    {0x00541001, "CS", [](Value v, Header h) { h.valueUnit = v.text() == "BQML" ? "Bq/ml" : wordOf(v); },
     nullptr},
    {0x00541300, "DS", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::frameTime) = first(v); }},
    {0x0062000b, "US", nullptr, [](Value v, Header, Frame f) { f.mark(DicomMark::segment) = first(v); }},
    {0x30040002, "CS", [](Value v, Header h) { h.valueUnit = v.text() == "GY" ? "Gy" : ""; }, nullptr},
    {0x3004000c, "DS", [](Value v, Header h) { h.frameOffsets = v.numbers(); }, nullptr},
    {0x3004000e, "DS", [](Value v, Header h) { h.common.slope = first(v); }, nullptr}};

/// Null: an element that is stepped over.
const DicomTag* knownTag(std::uint32_t tag) {
    const auto* const found =
        std::lower_bound(std::begin(tags), std::end(tags), tag,
                         [](const DicomTag& each, std::uint32_t wanted) { return each.tag < wanted; });
    return found == std::end(tags) || found->tag != tag ? nullptr : found;
}

/// A word of the standard, or a UID; "" where the value is none.
std::string wordOf(const DicomValue& value) {
    return plain(value, 16, [](char c) {
        return c == '_' || c == ' ' || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    });
}

std::string uidOf(const DicomValue& value) {
    return plain(value, 64, [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

constexpr std::string_view siemensForm = "SV10";
constexpr std::size_t siemensHead = 16, nameBytes = 64, tagBytes = 84, itemHead = 16;

/// Goes through elements, each a name, how many items it has, and the items as texts.
class SiemensElements {
  public:
    explicit SiemensElements(std::string_view bytes) : bytes_(bytes), left_(word(8)) {}

    /// False at the end, or where what follows is none.
    bool next() {
        if (left_ == 0 || bytes_.size() - at_ < tagBytes) return false;
        --left_;
        name = textAt(at_, nameBytes);
        const std::uint32_t items = word(at_ + 76);
        at_ += tagBytes;
        numbers.clear();
        for (std::uint32_t i = 0; i < items; ++i) {
            if (bytes_.size() - at_ < itemHead) return false;
            const std::uint64_t length = word(at_ + 4), padded = (length + 3) / 4 * 4;
            at_ += itemHead;
            if (padded > bytes_.size() - at_) return false;
            if (const auto number = parseNumber(trim(textAt(at_, length))); length > 0 && number)
                numbers.push_back(*number);
            at_ += static_cast<std::size_t>(padded);
        }
        return true;
    }

    std::string_view name;
    std::vector<double> numbers;

  private:
    std::uint32_t word(std::size_t at) const { return loadNumber<std::uint32_t>(bytes_.data() + at, false); }
    /// Up to the first zero.
    std::string_view textAt(std::size_t at, std::uint64_t most) const {
        const auto text = bytes_.substr(at, static_cast<std::size_t>(most));
        return text.substr(0, text.find('\0'));
    }

    std::string_view bytes_;
    std::size_t at_ = siemensHead;
    std::uint32_t left_;
};

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

    /// Reads all up to the pixels.
    Status read() {
        MOTE_RETURN_IF_ERROR(readElements(Place::file, stream_.left(), true));
        if (header_.frames.empty() || header_.frames.size() == header_.frameCount) return success();
        return stream_.corrupt(fmt::format("tells of {} frames, and of places of {}", header_.frameCount,
                                           header_.frames.size()));
    }

  private:
    enum class Place : std::uint8_t { file, shared, frame };

    /// Reads those of a data set or an item of `length` bytes, which may be undefined.
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

std::optional<DicomMosaic> siemensMosaic(std::string_view bytes) {
    if (bytes.size() < siemensHead || !bytes.starts_with(siemensForm)) return std::nullopt;
    DicomMosaic mosaic;
    bool directed = false;
    for (SiemensElements elements(bytes); elements.next();) {
        const auto& numbers = elements.numbers;
        if (elements.name == "NumberOfImagesInMosaic" && !numbers.empty() && numbers[0] >= 1.0 &&
            numbers[0] <= VolumeShape::maxDimension)
            mosaic.tiles = static_cast<std::uint32_t>(numbers[0]);
        if (elements.name == "SliceNormalVector" && numbers.size() == 3) {
            mosaic.normal = {numbers[0], numbers[1], numbers[2]};
            directed = std::abs(glm::length(mosaic.normal) - 1.0) < 1e-2;
        }
    }
    if (mosaic.tiles == 0 || !directed) return std::nullopt;
    mosaic.normal = glm::normalize(mosaic.normal);
    return mosaic;
}

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
