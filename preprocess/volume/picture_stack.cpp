// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "preprocess/image/read_picture.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/picture_description.h"
#include "preprocess/volume/picture_file.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

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
        return {
            ErrorCode::unsupported, name(0),
            fmt::format("has {} pictures behind one page, as ImageJ writes large stacks, which is not read: "
                        "save it as pages, or as NRRD",
                        stack_.contiguous)};
    }

  private:
    Status lookAtFiles() {
        const auto told = describeStack(first_, files_.size(), name(0));
        if (told.ok() && told->channels * told->frames == 1) stack_ = *told;
        if (told.ok() && told->channels * told->frames > 1) {
            return Error{
                ErrorCode::unsupported, name(0),
                fmt::format("tells of {} channels and {} frames, and it is not known which of the {} "
                            "files is which: name those of one channel by a pattern",
                            told->channels, told->frames, files_.size())};
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
        return Error{
            ErrorCode::unsupported, path.filename().string(),
            fmt::format("has {} pages and is one of several files: a volume is either pages or files",
                        picture_->pages())};
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
        return Error{
            ErrorCode::corrupt, name(page),
            fmt::format("is {} x {} with {} channels of {}; the first picture is {} x {} with {} of {}",
                        spec.width, spec.height, spec.samples, spec.numbers, first_.width, first_.height,
                        first_.samples, first_.numbers)};
    }

    Status readSlice(std::span<float> values) {
        return picture_->read([&](std::uint32_t row, std::span<const float> pixels) -> Status {
            keepOne(pixels, values.subspan(std::size_t{row} * shape_.nx, shape_.nx));
            return progress_.cancelled() ? Status(wasCancelled("cancelled while pictures were read"))
                                         : success();
        });
    }

    /// One value a pixel: luminance as of ITU-R BT.709, or one of its numbers.
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
