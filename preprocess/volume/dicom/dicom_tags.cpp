// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_tags.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

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

}  // namespace

const DicomTag* knownTag(std::uint32_t tag) {
    const auto* const found =
        std::lower_bound(std::begin(tags), std::end(tags), tag,
                         [](const DicomTag& each, std::uint32_t wanted) { return each.tag < wanted; });
    return found == std::end(tags) || found->tag != tag ? nullptr : found;
}

std::string wordOf(const DicomValue& value) {
    return plain(value, 16, [](char c) {
        return c == '_' || c == ' ' || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    });
}

std::string uidOf(const DicomValue& value) {
    return plain(value, 64, [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

}  // namespace mote::prep
