// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/picture_description.h"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

using Words = std::map<std::string, std::string, std::less<>>;

std::string_view wordOf(const Words& words, std::string_view name) {
    const auto found = words.find(name);
    return found == words.end() ? std::string_view() : std::string_view(found->second);
}

std::uint64_t countOf(const Words& words, std::string_view name, std::uint64_t otherwise) {
    const auto number = parseId(wordOf(words, name));
    return number && *number > 0 ? *number : otherwise;
}

/// Over 0 and finite; else 0.
double lengthOf(const Words& words, std::string_view name) {
    const double number = parseNumber(wordOf(words, name)).value_or(0.0);
    return number > 0.0 && std::isfinite(number) ? number : 0.0;
}

struct Unit {
    std::string_view name;
    double mm;  ///< 0: no length
};
constexpr std::array<Unit, 26> units{{{"um", 1e-3},         {"micron", 1e-3},
                                      {"microns", 1e-3},    {"micrometer", 1e-3},
                                      {"\\u00B5m", 1e-3},   {"\\u03BCm", 1e-3},
                                      {"\xc2\xb5m", 1e-3},  {"\xce\xbcm", 1e-3},
                                      {"\xb5m", 1e-3},      {"nm", 1e-6},
                                      {"nanometer", 1e-6},  {"mm", 1.0},
                                      {"millimeter", 1.0},  {"cm", 10.0},
                                      {"centimeter", 10.0}, {"m", 1e3},
                                      {"meter", 1e3},       {"inch", 25.4},
                                      {"in", 25.4},         {"pixel", 0.0},
                                      {"pixels", 0.0},      {"reference frame", 0.0},
                                      {"\xc3\x85", 1e-7},   {"pm", 1e-9},
                                      {"km", 1e6},          {"dm", 100.0}}};

double inMm(std::string_view unit) {
    const auto* const found =
        std::find_if(units.begin(), units.end(), [&](const Unit& one) { return one.name == unit; });
    return found == units.end() ? 0.0 : found->mm;
}

/// Under the name that is not one of many: "um".
std::string plainUnit(std::string_view unit) {
    const double mm = inMm(unit);
    for (const Unit& one : units) {
        if (mm > 0.0 && one.mm == mm) return std::string(one.name);
    }
    return mm == 0.0 && std::any_of(units.begin(), units.end(), [&](const Unit& u) { return u.name == unit; })
               ? std::string()
               : unitText(unit);
}

bool isDefaultResolution(const PictureSpec& first) {
    const auto dpi = [&](double pixel) { return std::abs(pixel * 72.0 - 1.0) < 1e-6; };
    return first.unitLength == 25.4 && dpi(first.pixelWidth) && dpi(first.pixelHeight);
}

/// Voxel sizes by resolution alone; pages lie as far apart as pixels are wide.
void sizeByResolution(const PictureSpec& first, const std::string& where, StackDescription& stack) {
    if (!(first.pixelWidth > 0.0 && first.pixelHeight > 0.0)) return;
    if (isDefaultResolution(first)) {
        stack.notes.push_back(
            where +
            ": 72 pixels an inch were taken for what programs write by themselves, and not for a size");
        return;
    }
    const bool lengths = first.unitLength > 0.0;
    const double unit = lengths ? first.unitLength : 1.0 / first.pixelWidth;
    stack.size[0] = first.pixelWidth * unit;
    stack.size[1] = first.pixelHeight * unit;
    if (!lengths && stack.size[0] == stack.size[1]) return;
    stack.size[2] = stack.size[0];
    stack.unit = lengths ? "mm" : "";
    stack.notes.push_back(
        fmt::format("{}: says how wide its pixels are ({:.6g} x {:.6g}{}) and not how far apart its slices: "
                    "as far as pixels in x",
                    where, stack.size[0], stack.size[1], lengths ? " mm" : ""));
}

// ----------------------------------------------------------------------------------------------- ImageJ

Words linesOf(std::string_view text) {
    Words words;
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        const auto line = trim(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        const auto equals = line.find('=');
        if (equals != std::string_view::npos) words.emplace(line.substr(0, equals), line.substr(equals + 1));
    }
    return words;
}

/// Pages go by channel, then slice, then frame.
Status readImageJ(const PictureSpec& first, std::size_t pages, const std::string& where,
                  StackDescription& stack) {
    const auto words = linesOf(first.description);
    const auto images = countOf(words, "images", pages);
    stack.channels = countOf(words, "channels", 1);
    stack.frames = countOf(words, "frames", 1);
    stack.slices = countOf(words, "slices", 1);
    const double told = static_cast<double>(stack.channels) * static_cast<double>(stack.slices) *
                        static_cast<double>(stack.frames);
    if (told == 1.0) stack.slices = images;
    const bool fits = told == 1.0 || told == static_cast<double>(images);
    if (!fits || (images != pages && pages != 1)) {
        return Error{
            ErrorCode::corrupt, where,
            fmt::format("ImageJ says {} channels, {} slices, {} frames and {} images, and there are {} pages",
                        stack.channels, stack.slices, stack.frames, images, pages)};
    }
    if (pages == 1 && images > 1) stack.contiguous = images;
    const std::string_view unit = wordOf(words, "unit");
    const bool named = !unit.empty();
    const double factor = !named && first.unitLength > 0.0 ? first.unitLength : 1.0;
    const bool sized =
        first.pixelWidth > 0.0 && first.pixelHeight > 0.0 && (named || !isDefaultResolution(first));
    const double spacing = lengthOf(words, "spacing");
    if (!sized && spacing == 0.0) return success();
    stack.size[0] = sized ? first.pixelWidth * factor : 1.0;
    stack.size[1] = sized ? first.pixelHeight * factor : 1.0;
    stack.size[2] = (spacing > 0.0 ? spacing : 1.0) * factor;
    stack.unit = named ? plainUnit(unit) : factor != 1.0 ? "mm" : "";
    if (spacing == 0.0) {
        stack.notes.push_back(fmt::format("{}: says no spacing of slices, which was taken as {:.6g} {}",
                                          where, stack.size[2], stack.unit));
    }
    stack.frameTime = lengthOf(words, "finterval");
    return success();
}

// -------------------------------------------------------------------------------------------------- OME

struct OmeText {
    Words pixels;  ///< attributes of the first Pixels
    std::vector<Words> tiffData, channels;
    std::uint64_t images = 0;  ///< Pixels elements
    bool elsewhere = false;    ///< planes lie in other files
    std::string fileName;
    XML_Parser parser = nullptr;
};

void startElement(void* data, const char* name, const char** attributes) {
    auto& ome = *static_cast<OmeText*>(data);
    const std::string_view full(name);
    const auto element = full.substr(full.rfind(':') == std::string_view::npos ? 0 : full.rfind(':') + 1);
    Words words;
    for (; attributes[0] != nullptr; attributes += 2) words.emplace(attributes[0], attributes[1]);
    if (element == "Pixels" && ++ome.images == 1) ome.pixels = std::move(words);
    if (ome.images != 1 || ome.tiffData.size() + ome.channels.size() > VolumeShape::maxDimension) return;
    if (element == "TiffData") ome.tiffData.push_back(std::move(words));
    if (element == "Channel") ome.channels.push_back(std::move(words));
    if (element != "UUID") return;
    const auto file = wordOf(words, "FileName");
    if (ome.fileName.empty()) ome.fileName = file;
    ome.elsewhere = ome.elsewhere || file != ome.fileName;
}

bool parseOme(const std::string& text, OmeText& ome) {
    const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                              &XML_ParserFree);
    if (!parser) return false;
    ome.parser = parser.get();
    XML_SetUserData(parser.get(), &ome);
    XML_SetStartElementHandler(parser.get(), startElement);
    // Entities are a way to make much out of little.
    XML_SetStartDoctypeDeclHandler(parser.get(), [](void* data, const char*, const char*, const char*, int) {
        XML_StopParser(static_cast<OmeText*>(data)->parser, XML_FALSE);
    });
    return XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK &&
           ome.images > 0;
}

/// Where planes in the order of the file go, `order` being "CZT" or another of these letters.
class PlaneOrder {
  public:
    PlaneOrder(std::string_view order, const StackDescription& stack) : order_(order), stack_(stack) {}

    std::size_t places() const {
        return static_cast<std::size_t>(stack_.channels * stack_.slices * stack_.frames);
    }
    /// Of the plane behind so many others.
    std::size_t place(std::uint64_t plane) const {
        std::uint64_t at[3] = {0, 0, 0};  // c, z, t
        for (const char axis : order_) {
            const auto i = index(axis);
            at[i] = plane % size(i);
            plane /= size(i);
        }
        return static_cast<std::size_t>(at[0] + stack_.channels * (at[1] + stack_.slices * at[2]));
    }
    /// How many planes are before one.
    std::uint64_t before(std::uint64_t c, std::uint64_t z, std::uint64_t t) const {
        const std::uint64_t at[3] = {c, z, t};
        std::uint64_t planes = 0, stride = 1;
        for (const char axis : order_) {
            planes += stride * at[index(axis)];
            stride *= size(index(axis));
        }
        return planes;
    }

  private:
    static std::size_t index(char axis) { return axis == 'C' ? 0 : axis == 'Z' ? 1 : 2; }
    std::uint64_t size(std::size_t i) const {
        return i == 0 ? stack_.channels : i == 1 ? stack_.slices : stack_.frames;
    }
    std::string order_;
    const StackDescription& stack_;
};

constexpr std::uint32_t noPage = UINT32_MAX;

/// The pages as TiffData elements tell them, or by the order alone.
Status placePages(const OmeText& ome, std::size_t pages, const std::string& where, StackDescription& stack) {
    std::string order(wordOf(ome.pixels, "DimensionOrder").substr(0, 5));
    order = order.starts_with("XY") ? order.substr(2) : "";
    std::string letters = order;
    std::sort(letters.begin(), letters.end());
    if (letters != "CTZ") return corrupt(where, "its OME text says no order of dimensions");
    const PlaneOrder planes(order, stack);
    stack.pages.assign(planes.places(), noPage);
    std::uint64_t next = 0;
    for (const Words& data : ome.tiffData) {
        const auto first = planes.before(parseId(wordOf(data, "FirstC")).value_or(0),
                                         parseId(wordOf(data, "FirstZ")).value_or(0),
                                         parseId(wordOf(data, "FirstT")).value_or(0));
        const auto page = parseId(wordOf(data, "IFD")).value_or(next);
        const bool one = !wordOf(data, "IFD").empty();
        const auto count = countOf(
            data, "PlaneCount", one ? 1 : planes.places() - std::min<std::uint64_t>(first, planes.places()));
        for (std::uint64_t i = 0; i < count && first + i < planes.places() && page + i < pages; ++i) {
            stack.pages[planes.place(first + i)] = static_cast<std::uint32_t>(page + i);
        }
        next = page + count;
    }
    if (ome.tiffData.empty()) {
        for (std::uint64_t i = 0; i < planes.places() && i < pages; ++i) {
            stack.pages[planes.place(i)] = static_cast<std::uint32_t>(i);
        }
    }
    const auto missing = std::count(stack.pages.begin(), stack.pages.end(), noPage);
    if (missing == 0) return success();
    return Error{ome.elsewhere ? ErrorCode::unsupported : ErrorCode::corrupt, where,
                 ome.elsewhere
                     ? "says in its OME text that some of its planes lie in other files"
                     : fmt::format("says {} planes in its OME text, and {} of them are not in its {} pages",
                                   planes.places(), missing, pages)};
}

Status readOme(const PictureSpec& first, std::size_t pages, const std::string& where,
               StackDescription& stack) {
    OmeText ome;
    if (!parseOme(first.description, ome)) {
        return corrupt(where, "its OME text is no XML that tells of pixels");
    }
    stack.channels = std::max<std::uint64_t>(countOf(ome.pixels, "SizeC", 1) / first.samples, 1);
    stack.slices = countOf(ome.pixels, "SizeZ", 1);
    stack.frames = countOf(ome.pixels, "SizeT", 1);
    const double told = static_cast<double>(stack.channels) * static_cast<double>(stack.slices) *
                        static_cast<double>(stack.frames);
    if (told > static_cast<double>(pages)) {
        return Error{
            ErrorCode::corrupt, where,
            fmt::format("its OME text says {} channels, {} slices and {} frames, and there are {} pages",
                        stack.channels, stack.slices, stack.frames, pages)};
    }
    MOTE_RETURN_IF_ERROR(placePages(ome, pages, where, stack));
    if (ome.images > 1) {
        stack.notes.push_back(fmt::format(
            "{}: its OME text tells of {} images, of which the first one is read", where, ome.images));
    }
    for (const Words& channel : ome.channels) stack.channelNames.emplace_back(wordOf(channel, "Name"));
    constexpr std::array<std::string_view, 3> names{"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    std::string unit;
    for (std::size_t i = 0; i < names.size(); ++i) {
        auto said = wordOf(ome.pixels, std::string(names[i]) + "Unit");
        if (said.empty()) said = "um";
        stack.size[i] = lengthOf(ome.pixels, names[i]);
        if (i == 0) unit = said;
        if (said != unit && inMm(said) > 0.0 && inMm(unit) > 0.0) stack.size[i] *= inMm(said) / inMm(unit);
    }
    stack.unit = stack.size[0] > 0.0 ? plainUnit(unit) : "";
    stack.frameTime = lengthOf(ome.pixels, "TimeIncrement");
    if (stack.size[0] > 0.0 && stack.size[2] == 0.0 && stack.slices > 1) {
        stack.notes.push_back(where +
                              ": its OME text says no PhysicalSizeZ; slices lie as far apart as pixels in x");
    }
    return success();
}

// --------------------------------------------------------------------------------------------- tifffile

/// {"shape": [2, 16, 20, 24], ...}: the last two, or three of colours, are of a page.
Status readShape(const PictureSpec& first, std::size_t pages, const std::string& where,
                 StackDescription& stack) {
    std::string_view text = first.description;
    text.remove_prefix(std::min(text.find('[') + 1, text.size()));
    text = text.substr(0, text.find(']'));
    std::array<std::string_view, 16> words;
    const auto count = splitFields(text, ',', words);
    std::vector<std::uint64_t> sizes;
    for (std::size_t i = 0; i < std::min(count, words.size()); ++i) {
        sizes.push_back(parseId(trim(words[i])).value_or(0));
    }
    std::uint64_t left = pages;
    for (const auto size : sizes) {
        if (left <= 1 || size == 0 || left % size != 0) break;
        if (size == left) {
            stack.slices = size;
            left = 1;
        } else if (size > 1) {
            stack.frames *= size;
            left /= size;
        }
    }
    if (left == 1 && stack.slices * stack.frames == pages) return success();
    stack.slices = pages;
    stack.frames = 1;
    stack.notes.push_back(where +
                          ": its description tells of another shape than its pages have, and was left aside");
    return success();
}

}  // namespace

Result<StackDescription> describeStack(const PictureSpec& first, std::size_t pages,
                                       const std::string& where) {
    StackDescription stack;
    const std::string_view text = first.description;
    const bool ome =
        text.find("<OME") != std::string_view::npos || text.find(":OME ") != std::string_view::npos;
    if (text.starts_with("ImageJ=")) {
        MOTE_RETURN_IF_ERROR(readImageJ(first, pages, where, stack));
    } else if (ome) {
        MOTE_RETURN_IF_ERROR(readOme(first, pages, where, stack));
    } else if (text.starts_with("{\"shape\":") && pages > 1) {
        MOTE_RETURN_IF_ERROR(readShape(first, pages, where, stack));
    } else {
        stack.slices = pages;
    }
    if (stack.size[0] == 0.0) sizeByResolution(first, where, stack);
    if (stack.slices == 1 && stack.frames > 1) {
        std::swap(stack.slices, stack.frames);
        stack.notes.push_back(
            fmt::format("{}: its {} frames of one slice were taken as slices", where, stack.slices));
    }
    if (stack.pages.empty()) {
        stack.pages.resize(static_cast<std::size_t>(
            stack.contiguous > 0 ? 1 : stack.channels * stack.slices * stack.frames));
        std::iota(stack.pages.begin(), stack.pages.end(), 0U);
    }
    return stack;
}

}  // namespace mote::prep
