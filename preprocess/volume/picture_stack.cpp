// SPDX-License-Identifier: GPL-3.0-or-later
#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "preprocess/image/read_picture.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/picture_file.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "protocol/base/error.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/space/length_unit.h"

namespace mote::prep {
namespace {

// What programs write about a stack into a TIFF file's description: ImageJ's lines, OME's XML, tifffile's
// shape: which page is which slice, channel and frame, and how large voxels are. Texts that nobody vouches
// for. Pure functions.

struct StackDescription {
    std::uint64_t channels = 1, slices = 1, frames = 1;
    /// The page of channel c, slice z and frame t is at c + channels (z + slices t); its number in the file.
    std::vector<std::uint32_t> pages;
    std::vector<std::string> channelNames;  ///< none, or of each
    std::uint64_t contiguous = 0;      ///< pictures behind the only page's own, one after the other; 0: none
    double size[3] = {0.0, 0.0, 0.0};  ///< of a voxel along x, y and z; 0: not said
    std::string unit;                  ///< of these
    double frameTime = 0.0;            ///< s; 0: not said
    std::vector<std::string> notes;
};

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

/// What stands where a unit of a length is expected, and is none.
constexpr std::array<std::string_view, 3> noUnits{"pixel", "pixels", "reference frame"};

/// 0 where it is no length.
double inMm(std::string_view unit) {
    return 1e3 * metresOf(unit).value_or(0.0);
}

/// Under the name that is not one of many: "um".
std::string plainUnit(std::string_view unit) {
    if (std::ranges::find(noUnits, unit) != noUnits.end()) return {};
    return metresOf(unit) ? ownName(unit) : unitText(unit);
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
        return corrupt(
            where,
            fmt::format("ImageJ says {} channels, {} slices, {} frames and {} images, and there are {} pages",
                        stack.channels, stack.slices, stack.frames, images, pages));
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
    if (element == "Pixels" && ++ome.images == 1) ome.pixels = words;
    if (ome.images != 1 || ome.tiffData.size() + ome.channels.size() > VolumeShape::maxDimension) return;
    if (element == "TiffData") {
        ome.tiffData.push_back(std::move(words));
    } else if (element == "Channel") {
        ome.channels.push_back(std::move(words));
    } else if (element == "UUID") {
        const auto file = wordOf(words, "FileName");
        if (ome.fileName.empty()) ome.fileName = file;
        ome.elsewhere = ome.elsewhere || file != ome.fileName;
    }
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
    /// The place of the plane behind so many others.
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
        return corrupt(
            where,
            fmt::format("its OME text says {} channels, {} slices and {} frames, and there are {} pages",
                        stack.channels, stack.slices, stack.frames, pages));
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

/// Describes a file of so many pages, of which `first` is the head of the first one. Errors, at `where`:
/// corrupt (it tells of other pages than there are), unsupported (pages in other files).
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

namespace fs = std::filesystem;
using namespace std::string_view_literals;

// A slice's size over its file's: more than LZW in TIFF makes, at most 4096 bytes of 12 bits.
constexpr std::uint64_t greatestRatio = 4096;

/// Which of a pixel's numbers is its value.
struct Pick {
    bool luminance = false;  ///< that of the first three
    std::uint32_t sample = 0;
};

class PictureStack : public VolumeSource {
  public:
    PictureStack(std::vector<fs::path> files, Progress& progress)
        : files_(std::move(files)), progress_(progress) {}

    std::string format() const override { return "pictures"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return false; }

    /// Looks at the first picture, and at what it tells of the others.
    Status look() {
        MOTE_RETURN_IF_ERROR(enter(0));
        first_ = picture_->spec();
        shape_.type = first_.type;
        if (files_.size() > 1) return lookAtFiles();
        MOTE_ASSIGN_OR_RETURN(stack_,
                              describeStack(first_, picture_->pages(), files_.front().filename().string()));
        return success();
    }

    /// What can be asked for.
    VolumeParts parts(const std::string& field) const {
        VolumeParts parts;
        parts.volumes = stack_.frames;
        parts.components = stack_.channels * valuesOfPixel(field);
        return parts;
    }

    /// Chooses the part that `field` names, and looks at the head of every picture of it.
    Status open(const std::string& field) {
        MOTE_RETURN_IF_ERROR(choose(field));
        const std::uint64_t slices = stack_.slices;
        if (slices * stack_.frames * stack_.channels == 1) {
            return unsupported(name(0),
                               "is a single picture; name the folder of a stack, or a pattern of names");
        }
        MOTE_RETURN_IF_ERROR(setDimensions(shape_, first_.width, first_.height, slices, name(0)));
        MOTE_RETURN_IF_ERROR(place());
        noteColours();
        for (std::uint32_t z = 0; z < shape_.nz; ++z) {
            if (progress_.cancelled()) return wasCancelled("cancelled while pictures were read");
            MOTE_RETURN_IF_ERROR(enter(pageOf(z)));
            MOTE_RETURN_IF_ERROR(checkLikeFirst(pageOf(z)));
        }
        return success();
    }

    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
        const auto slice = static_cast<std::size_t>(shape_.voxelsOfSlice());
        for (std::uint32_t z = z0; z < z1; ++z) {
            if (progress_.cancelled()) return wasCancelled("cancelled while pictures were read");
            MOTE_RETURN_IF_ERROR(enter(pageOf(z)));
            MOTE_RETURN_IF_ERROR(checkLikeFirst(pageOf(z)));
            MOTE_RETURN_IF_ERROR(readSlice(values.subspan((z - z0) * slice, slice)));
        }
        return success();
    }

    /// ImageJ writes what is larger than 4 GiB as one page, the others' numbers behind its own.
    bool isContiguous() const { return stack_.contiguous > 0; }
    Error contiguousError() const {
        return unsupported(
            name(0),
            fmt::format("has {} pictures behind one page, as ImageJ writes large stacks, which is not read: "
                        "save it as pages, or as NRRD",
                        stack_.contiguous));
    }

  private:
    Status lookAtFiles() {
        const auto told = describeStack(first_, files_.size(), name(0));
        if (told.ok() && told->channels * told->frames == 1) stack_ = *told;
        if (told.ok() && told->channels * told->frames > 1) {
            return unsupported(
                name(0),
                fmt::format("tells of {} channels and {} frames, and it is not known which of the {} "
                            "files is which: name those of one channel by a pattern",
                            told->channels, told->frames, files_.size()));
        }
        if (!told.ok()) {
            PictureSpec bare = first_;
            bare.description.clear();
            MOTE_ASSIGN_OR_RETURN(stack_, describeStack(bare, files_.size(), name(0)));
            stack_.notes.push_back(name(0) + ": what its description tells of pages was left aside");
        }
        stack_.contiguous = 0;
        stack_.slices = files_.size();
        stack_.pages.resize(files_.size());
        for (std::size_t i = 0; i < files_.size(); ++i) stack_.pages[i] = static_cast<std::uint32_t>(i);
        return success();
    }

    std::string name(std::size_t page) const {
        const std::string file = files_[files_.size() > 1 ? page : 0].filename().string();
        return files_.size() == 1 && picture_ && picture_->pages() > 1
                   ? fmt::format("{}: page {}", file, page + 1)
                   : file;
    }
    std::size_t pageOf(std::uint32_t z) const {
        return stack_.pages[channel_ + stack_.channels * (z + stack_.slices * frame_)];
    }

    /// Makes `picture_` the file of a page, and that its present one.
    Status enter(std::size_t page) {
        if (files_.size() == 1 && picture_) return picture_->enter(page);
        const std::size_t index = files_.size() > 1 ? page : 0;
        const fs::path& path = files_[index];
        MOTE_ASSIGN_OR_RETURN(const auto format, pictureFormat(path));
        if (format != "png"sv && format != "tiff"sv) {
            return unsupported(path.filename().string(), "is no PNG or TIFF picture");
        }
        picture_.reset();
        auto opened =
            format == "png"sv ? openPng(path) : openTiff(path, [this] { return progress_.cancelled(); });
        if (!opened) return opened.error();
        picture_ = std::move(opened).value();
        if (files_.size() == 1 || picture_->pages() == 1) return success();
        return unsupported(
            path.filename().string(),
            fmt::format("has {} pages and is one of several files: a volume is either pages or files",
                        picture_->pages()));
    }

    /// Colours are one value, their luminance, as long as none of them is asked for.
    std::uint64_t valuesOfPixel(const std::string& field) const {
        const bool asked = stack_.frames > 1 ? field.find(':') != std::string::npos : !field.empty();
        if (first_.colour) return asked ? 3 : 1;
        return first_.samples - first_.opacity;
    }

    Status choose(const std::string& field) {
        std::string numbered = field;
        for (std::size_t i = 0; i < stack_.channelNames.size(); ++i) {
            if (!field.empty() && stack_.channelNames[i] == field) numbered = fmt::format(":{}", i);
        }
        const auto parts = this->parts(numbered);
        const auto chosen = chooseParts(numbered, parts, files_.front().filename().string());
        if (!chosen.ok()) return withNames(chosen.error());
        const auto each = valuesOfPixel(numbered);
        frame_ = chosen->volume;
        channel_ = chosen->component / each;
        pick_.sample = static_cast<std::uint32_t>(chosen->component % each);
        pick_.luminance = first_.colour && each == 1;
        if (stack_.frameTime > 0.0) shape_.time = stack_.frameTime * static_cast<double>(frame_);
        return success();
    }

    Error withNames(Error error) const {
        std::string names;
        for (std::size_t i = 0; i < std::min<std::size_t>(stack_.channelNames.size(), 16); ++i) {
            if (stack_.channelNames[i].empty()) continue;
            names += fmt::format("{}{} is {:.20}", names.empty() ? "; " : ", ", i, stack_.channelNames[i]);
        }
        error.message += names;
        return error;
    }

    Status place() {
        shape_.worldUnit = stack_.unit;
        shape_.notes = stack_.notes;
        shape_.notes.insert(shape_.notes.end(), first_.notes.begin(), first_.notes.end());
        if (!(stack_.size[0] > 0.0)) return success();
        const double y = stack_.size[1] > 0.0 ? stack_.size[1] : stack_.size[0];
        const double z = stack_.size[2] > 0.0 ? stack_.size[2] : stack_.size[0];
        const glm::dmat3 steps(stack_.size[0], 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z);
        return setPlacement(shape_, steps, glm::dvec3(0.0), name(0) + ": voxel sizes");
    }

    void noteColours() {
        if (pick_.luminance) {
            shape_.notes.push_back(name(0) + ": the pictures are in colour; their luminance is read");
        }
        if (first_.opacity > 0) shape_.notes.push_back(name(0) + ": their opacity is left out");
    }

    Status checkLikeFirst(std::size_t page) const {
        const PictureSpec& spec = picture_->spec();
        if (spec.isLike(first_)) return success();
        return corrupt(
            name(page),
            fmt::format("is {} x {} with {} channels of {}; the first picture is {} x {} with {} of {}",
                        spec.width, spec.height, spec.samples, spec.numbers, first_.width, first_.height,
                        first_.samples, first_.numbers));
    }

    Status readSlice(std::span<float> values) {
        return picture_->read([&](std::uint32_t row, std::span<const float> pixels) -> Status {
            keepOne(pixels, values.subspan(std::size_t{row} * shape_.nx, shape_.nx));
            return progress_.cancelled() ? Status(wasCancelled("cancelled while pictures were read"))
                                         : success();
        });
    }

    /// Keeps one value a pixel: luminance as of ITU-R BT.709, or one of its numbers.
    void keepOne(std::span<const float> pixels, std::span<float> values) const {
        const std::size_t step = first_.samples;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const float* const pixel = &pixels[i * step];
            values[i] = pick_.luminance ? 0.2126F * pixel[0] + 0.7152F * pixel[1] + 0.0722F * pixel[2]
                                        : pixel[pick_.sample];
        }
    }

    std::vector<fs::path> files_;
    Progress& progress_;
    StackDescription stack_;
    std::uint64_t channel_ = 0, frame_ = 0;
    Pick pick_;
    VolumeShape shape_;
    PictureSpec first_;
    std::unique_ptr<PictureFile> picture_;  ///< of the page that was entered last
};

Result<std::unique_ptr<PictureStack>> lookAt(const fs::path& input, Progress& progress) {
    std::vector<fs::path> files{input};
    if (namesPictures(input)) {
        MOTE_ASSIGN_OR_RETURN(files, pictureFiles(input));
    }
    auto stack = std::make_unique<PictureStack>(std::move(files), progress);
    MOTE_RETURN_IF_ERROR(stack->look());
    if (stack->isContiguous()) return stack->contiguousError();
    return stack;
}

/// Their libraries hold no resources but memory that may be too much.
template <class Work>
auto guarded(const fs::path& input, Work work) -> decltype(work()) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::resourceExhausted, input.filename().string(),
                     "is too large for the memory there is"};
    }
}

}  // namespace

Status checkPictureSize(const PictureSpec& spec, unsigned bits, const fs::path& path,
                        const std::string& where) {
    VolumeShape slice;
    MOTE_RETURN_IF_ERROR(setDimensions(slice, spec.width, spec.height, 1, where));
    std::error_code code;
    const std::uint64_t bytes = fs::file_size(path, code);
    const std::uint64_t stored = slice.voxelsOfSlice() * spec.samples / 8 * bits;
    if (!code && stored / greatestRatio <= bytes) return success();
    return corrupt(where, fmt::format("its size {} x {} is more than {} bytes can hold", spec.width,
                                      spec.height, code ? 0 : bytes));
}

bool beginsAsPicture(std::string_view bytes) {
    return bytes.starts_with("\x89PNG\r\n\x1a\n"sv) || bytes.starts_with("II*\0"sv) ||
           bytes.starts_with("MM\0*"sv) || bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv);
}

Result<VolumeParts> partsOfPictures(const fs::path& input, const std::string& field, Progress& progress) {
    return guarded(input, [&]() -> Result<VolumeParts> {
        MOTE_ASSIGN_OR_RETURN(const auto stack, lookAt(input, progress));
        return stack->parts(field);
    });
}

Result<std::unique_ptr<VolumeSource>> openPictureStack(const fs::path& input, const std::string& field,
                                                       Progress& progress) {
    return guarded(input, [&]() -> Result<std::unique_ptr<VolumeSource>> {
        MOTE_ASSIGN_OR_RETURN(auto stack, lookAt(input, progress));
        MOTE_RETURN_IF_ERROR(stack->open(field));
        return std::unique_ptr<VolumeSource>(std::move(stack));
    });
}

}  // namespace mote::prep
