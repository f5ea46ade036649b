// SPDX-License-Identifier: GPL-3.0-or-later

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

#include "preprocess/image/read_picture.h"
#include "preprocess/volume/volume_formats.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

constexpr std::uint64_t stripBytes = 4u << 20;
// A slice's size over its file's: more than LZW in TIFF makes, at most 4096 bytes of 12 bits.
constexpr std::uint64_t greatestRatio = 4096;
constexpr int pagesPerQuestion = 256;  // is it cancelled?

const std::array<std::pair<OIIO::TypeDesc::BASETYPE, ScalarType>, 8> types{
    {{OIIO::TypeDesc::UINT8, ScalarType::u8},
     {OIIO::TypeDesc::INT8, ScalarType::i8},
     {OIIO::TypeDesc::UINT16, ScalarType::u16},
     {OIIO::TypeDesc::INT16, ScalarType::i16},
     {OIIO::TypeDesc::UINT32, ScalarType::u32},
     {OIIO::TypeDesc::INT32, ScalarType::i32},
     {OIIO::TypeDesc::FLOAT, ScalarType::f32},
     {OIIO::TypeDesc::DOUBLE, ScalarType::f64}}};

/// Sentences of OpenImageIO may have several lines.
Error unreadable(const fs::path& path, std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    return {ErrorCode::corrupt, path.filename().string(), "cannot be read: " + message};
}

Error cancelled() {
    return {ErrorCode::cancelled, "", "cancelled while pictures were read"};
}

/// OpenImageIO's readers throw here and there at what is broken.
template <class Work>
Status guarded(const fs::path& path, Work work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::resourceExhausted, path.filename().string(),
                     "is too large for the memory there is"};
    } catch (const std::exception& error) {
        return unreadable(path, error.what());
    }
}

class PictureStack : public VolumeSource {
  public:
    PictureStack(std::vector<fs::path> files, Progress& progress)
        : files_(std::move(files)), progress_(progress) {}

    std::string format() const override { return "pictures"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return false; }

    /// Looks at the head of every picture.
    Status open() {
        MOTE_RETURN_IF_ERROR(enter(0));
        first_ = input_->spec();
        MOTE_RETURN_IF_ERROR(readType());
        std::uint64_t slices = files_.size();
        if (files_.size() == 1) {
            MOTE_ASSIGN_OR_RETURN(const auto pages, countPages());
            slices = pages;
            paged_ = true;
        }
        if (slices == 1) {
            return Error{ErrorCode::unsupported, name(0),
                         "is a single picture; name the folder of a stack, or a pattern of names"};
        }
        MOTE_RETURN_IF_ERROR(
            setDimensions(shape_, count(first_.width), count(first_.height), slices, name(0)));
        for (std::uint32_t z = 1; z < shape_.nz; ++z) {
            if (progress_.cancelled()) return cancelled();
            MOTE_RETURN_IF_ERROR(enter(z));
            MOTE_RETURN_IF_ERROR(checkLikeFirst(z));
        }
        return success();
    }

    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        return guarded(files_.front(), [&] { return readSlices(z0, z1, values); });
    }

  private:
    Status readSlices(std::uint32_t z0, std::uint32_t z1, std::span<float> values) {
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
        const auto slice = static_cast<std::size_t>(shape_.voxelsOfSlice());
        for (std::uint32_t z = z0; z < z1; ++z) {
            if (progress_.cancelled()) return cancelled();
            MOTE_RETURN_IF_ERROR(enter(z));
            MOTE_RETURN_IF_ERROR(checkLikeFirst(z));
            MOTE_RETURN_IF_ERROR(readSlice(z, values.subspan((z - z0) * slice, slice)));
        }
        return success();
    }

    static std::uint64_t count(int n) { return n > 0 ? static_cast<std::uint64_t>(n) : 0; }
    const fs::path& file(std::uint32_t z) const { return files_[paged_ ? 0 : z]; }
    std::string name(std::uint32_t z) const {
        const std::string file = this->file(z).filename().string();
        return paged_ ? fmt::format("{}: page {}", file, z + 1) : file;
    }

    /// Makes `input_` the picture of slice `z`.
    Status enter(std::uint32_t z) {
        if (paged_ && input_) {
            const auto page = static_cast<int>(z);
            return input_->seek_subimage(page, 0) ? success()
                                                  : Status(unreadable(file(z), input_->geterror()));
        }
        const fs::path& path = file(z);
        MOTE_ASSIGN_OR_RETURN(const auto format, pictureFormat(path));
        if (format != "png"sv && format != "tiff"sv) {
            return Error{ErrorCode::unsupported, name(z), "is no PNG or TIFF picture"};
        }
        input_ = OIIO::ImageInput::create(format);
        if (!input_) return unreadable(path, OIIO::geterror());
        OIIO::ImageSpec spec, wishes;
        wishes.attribute("oiio:UnassociatedAlpha", 1);  // numbers as they are stored
        // Its cache of files is by name: a link's target may have changed.
        if (!input_->open(path.string(), spec, wishes)) return unreadable(path, input_->geterror());
        return checkSize(z);
    }

    /// A small file that says it is huge is refused before a library takes memory for it.
    Status checkSize(std::uint32_t z) const {
        const OIIO::ImageSpec& spec = input_->spec();
        if (spec.deep || spec.depth > 1) {
            return Error{ErrorCode::unsupported, name(z), "is no flat picture, but a deep or solid one"};
        }
        VolumeShape slice;
        MOTE_RETURN_IF_ERROR(setDimensions(slice, count(spec.width), count(spec.height), 1, name(z)));
        std::error_code code;
        const std::uint64_t bytes = fs::file_size(file(z), code);
        const auto width = static_cast<int>(8 * spec.format.size());
        const int bits = std::clamp(spec.get_int_attribute("oiio:BitsPerSample", width), 1, width);
        const std::uint64_t stored =
            spec.image_bytes() / static_cast<unsigned>(width) * static_cast<unsigned>(bits);
        if (!code && stored / greatestRatio <= bytes) return success();
        return Error{ErrorCode::corrupt, name(z),
                     fmt::format("its size {} x {} is more than {} bytes can hold", spec.width, spec.height,
                                 code ? 0 : bytes)};
    }

    Status readType() {
        const auto base = static_cast<OIIO::TypeDesc::BASETYPE>(first_.format.basetype);
        const auto* const found =
            std::find_if(types.begin(), types.end(), [&](const auto& type) { return type.first == base; });
        stored_ = base == OIIO::TypeDesc::HALF ? OIIO::TypeDesc(OIIO::TypeDesc::FLOAT) : first_.format;
        if (found == types.end() && base != OIIO::TypeDesc::HALF) {
            return Error{ErrorCode::unsupported, name(0),
                         fmt::format("holds values of type {}", first_.format.c_str())};
        }
        shape_.type = found == types.end() ? ScalarType::f32 : found->second;
        const int bits = first_.get_int_attribute("oiio:BitsPerSample", 0);
        if (bits > 0 && bits % 8 != 0) {
            progress_.note(fmt::format("{}: values of {} bits are spread over {}", name(0), bits,
                                       8 * bytesOf(shape_.type)));
        }
        if (channels() >= 3)
            progress_.note(name(0) + ": the pictures are in colour; their luminance is read");
        return success();
    }

    Result<std::uint64_t> countPages() {
        std::uint64_t pages = 1;
        while (pages <= VolumeShape::maxDimension && input_->seek_subimage(static_cast<int>(pages), 0)) {
            ++pages;
            if (pages % pagesPerQuestion == 0 && progress_.cancelled()) return cancelled();
        }
        input_->geterror();  // that there is no further page is none
        return pages;
    }

    Status checkLikeFirst(std::uint32_t z) const {
        const OIIO::ImageSpec& spec = input_->spec();
        if (spec.width == first_.width && spec.height == first_.height &&
            spec.nchannels == first_.nchannels && spec.format == first_.format) {
            return checkSize(z);
        }
        return Error{
            ErrorCode::corrupt, name(z),
            fmt::format("is {} x {} with {} channels of {}; the first picture is {} x {} with {} of {}",
                        spec.width, spec.height, spec.nchannels, spec.format.c_str(), first_.width,
                        first_.height, first_.nchannels, first_.format.c_str())};
    }

    int channels() const { return first_.nchannels - (first_.alpha_channel >= 0 ? 1 : 0); }

    Status readSlice(std::uint32_t z, std::span<float> values) {
        const OIIO::ImageSpec& spec = input_->spec();
        const auto width = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
        const auto fitting = static_cast<int>(std::clamp<std::uint64_t>(stripBytes / (width * 4), 1, 65536));
        const int rows = spec.tile_width > 0 ? spec.tile_height : fitting;
        for (int row = 0; row < spec.height; row += rows) {
            const int end = std::min(row + rows, spec.height);
            const std::size_t numbers = width * static_cast<std::size_t>(end - row);
            strip_.resize(numbers * bytesOf(shape_.type));
            // Its reader of TIFF says that all went well where strips are missing, and keeps the error.
            if (!readStrip(spec, row, end) || input_->has_error())
                return unreadable(file(z), input_->geterror());
            decoded_.resize(numbers);
            decodeSamples(strip_, {shape_.type, false, 1.0, 0.0}, decoded_);
            keepOne(values.subspan(static_cast<std::size_t>(row) * shape_.nx));
        }
        return success();
    }

    bool readStrip(const OIIO::ImageSpec& spec, int row, int end) {
        const int y = spec.y + row, yEnd = spec.y + end;
        if (spec.tile_width == 0) {
            return input_->read_scanlines(input_->current_subimage(), 0, y, yEnd, 0, 0, spec.nchannels,
                                          stored_, strip_.data());
        }
        return input_->read_tiles(input_->current_subimage(), 0, spec.x, spec.x + spec.width, y, yEnd, 0, 1,
                                  0, spec.nchannels, stored_, strip_.data());
    }

    /// Turns the decoded channels into one value a pixel: luminance as of ITU-R BT.709, or the first channel.
    void keepOne(std::span<float> values) const {
        const auto step = static_cast<std::size_t>(first_.nchannels);
        for (std::size_t i = 0, at = 0; at < decoded_.size(); ++i, at += step) {
            const float* const pixel = &decoded_[at];
            values[i] =
                channels() >= 3 ? 0.2126F * pixel[0] + 0.7152F * pixel[1] + 0.0722F * pixel[2] : pixel[0];
        }
    }

    std::vector<fs::path> files_;
    Progress& progress_;
    bool paged_ = false;  ///< all slices in one file
    VolumeShape shape_;
    OIIO::TypeDesc stored_;  ///< what is asked for: the file's own type
    OIIO::ImageSpec first_;
    std::unique_ptr<OIIO::ImageInput> input_;
    std::vector<char> strip_;
    std::vector<float> decoded_;
};

}  // namespace

bool beginsAsPicture(std::string_view bytes) {
    return bytes.starts_with("\x89PNG\r\n\x1a\n"sv) || bytes.starts_with("II*\0"sv) ||
           bytes.starts_with("MM\0*"sv) || bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv);
}

Result<std::unique_ptr<VolumeSource>> openPictureStack(const fs::path& input, Progress& progress) {
    std::vector<fs::path> files{input};
    if (namesPictures(input)) {
        MOTE_ASSIGN_OR_RETURN(auto found, pictureFiles(input));
        files = std::move(found);
    }
    auto stack = std::make_unique<PictureStack>(std::move(files), progress);
    MOTE_RETURN_IF_ERROR(guarded(input, [&] { return stack->open(); }));
    return std::unique_ptr<VolumeSource>(std::move(stack));
}

}  // namespace mote::prep
