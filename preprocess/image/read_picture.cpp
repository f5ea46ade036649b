// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/read_picture.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdarg>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "preprocess/image/openimageio/picture_input.h"
#include "preprocess/load_module.h"
#include "protocol/base/system_error.h"
#include "protocol/scene/srgb.h"
#include "storage/files/dataset_file.h"

namespace mote::prep {
namespace {

// TIFF pictures that do not say how many bits a sample has: one, by the format (TIFF 6.0, section 3), where
// OpenImageIO takes eight. Called from one thread.

struct Closer {
    void operator()(TIFF* file) const { TIFFClose(file); }
};
using TiffPtr = std::unique_ptr<TIFF, Closer>;

int dropMessage(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

TiffPtr openFile(const std::filesystem::path& path) {
    TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
    if (options == nullptr) return nullptr;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, tmsize_t{1} << 30);
    TIFFOpenOptionsSetErrorHandlerExtR(options, dropMessage, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options, dropMessage, nullptr);
    TiffPtr file(TIFFOpenExt(path.c_str(), "rm", options));
    TIFFOpenOptionsFree(options);
    return file;
}

/// The luminance, 0 and 1, of such a picture; nothing where `path`, a TIFF file, is none. `mostPixels`: what
/// may be taken. Errors: corrupt, unsupported (several samples a pixel, tiles), resourceExhausted.
Result<std::optional<storage::Luminance>> readBilevelTiff(const std::filesystem::path& path,
                                                          std::uint64_t mostPixels) {
    const TiffPtr file = openFile(path);
    std::uint16_t bits = 0, samples = 1, meaning = PHOTOMETRIC_MINISBLACK;
    // What cannot be opened is OpenImageIO's to say.
    if (!file || TIFFGetField(file.get(), TIFFTAG_BITSPERSAMPLE, &bits) != 0)
        return std::optional<storage::Luminance>();
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetField(file.get(), TIFFTAG_PHOTOMETRIC, &meaning);
    const std::string where = path.string();
    if (samples != 1 || meaning > PHOTOMETRIC_MINISBLACK || TIFFIsTiled(file.get()) != 0) {
        return unsupported(where,
                           "does not say how many bits a sample has, and is no picture in black and white");
    }
    storage::Luminance picture;
    TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &picture.width);
    TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &picture.height);
    const std::uint64_t pixels = std::uint64_t{picture.width} * picture.height;
    if (pixels == 0) return corrupt(where, "has no pixels");
    if (pixels > mostPixels || picture.width > storage::maxImageSide ||
        picture.height > storage::maxImageSide) {
        return Error{
            ErrorCode::resourceExhausted, where,
            fmt::format("has {} x {} pixels, more than the job may take", picture.width, picture.height)};
    }
    std::vector<unsigned char> row(static_cast<std::size_t>(TIFFScanlineSize64(file.get())));
    if (row.size() * 8 < picture.width) return corrupt(where, "has rows that are too short");
    picture.values.reserve(static_cast<std::size_t>(pixels));
    for (std::uint32_t y = 0; y < picture.height; ++y) {
        if (TIFFReadScanline(file.get(), row.data(), y) < 0) {
            return corrupt(where, fmt::format("its row {} cannot be read", y));
        }
        for (std::uint32_t x = 0; x < picture.width; ++x) {
            const bool bit = (row[x / 8] >> (7 - x % 8) & 1U) != 0;
            picture.values.push_back(bit == (meaning == PHOTOMETRIC_MINISBLACK) ? 1.0F : 0.0F);
        }
    }
    return std::optional(std::move(picture));
}

using namespace std::string_view_literals;

constexpr std::size_t jpegLimit = std::size_t{1} << 30;  // bytes

struct Signature {
    std::string_view bytes;
    const char* format;
};
constexpr std::array<Signature, 7> signatures{{
    {"\x89PNG\r\n\x1a\n"sv, "png"},
    {"\xff\xd8\xff"sv, "jpeg"},
    {"II*\0"sv, "tiff"},
    {"MM\0*"sv, "tiff"},
    {"II+\0"sv, "tiff"},
    {"MM\0+"sv, "tiff"},
    {"\x76\x2f\x31\x01"sv, "openexr"},
}};

/// Whether an end-of-image marker stands where one may: not in a thumbnail within a segment (ITU T.81, B.1).
bool jpegHasEnd(std::string_view bytes) {
    std::size_t at = 2;
    while (at + 1 < bytes.size()) {
        const auto marker = static_cast<unsigned char>(bytes[at + 1]);
        if (bytes[at] != '\xff') {
            at = std::min(bytes.find('\xff', at), bytes.size());  // samples of a scan
        } else if (marker == 0xd9) {
            return true;
        } else if (marker == 0xff) {
            at += 1;  // fill
        } else if (marker == 0x00 || (marker >= 0xd0 && marker <= 0xd8) || marker == 0x01) {
            at += 2;  // without a segment
        } else {
            if (at + 3 >= bytes.size()) return false;
            at += 2 + (static_cast<unsigned char>(bytes[at + 2]) << 8) +
                  static_cast<unsigned char>(bytes[at + 3]);
        }
    }
    return false;
}

Result<std::string> firstBytes(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, storage::openRegular(path));
    std::string head(8, '\0');
    const auto got = ::pread(file.get(), head.data(), head.size(), 0);
    if (got < 0) return systemError(errno, path.string(), "cannot be read");
    head.resize(static_cast<std::size_t>(got));
    return head;
}

namespace fs = std::filesystem;

/// Encoded intensity, 0 to 1 and beyond, to linear.
class Decoder {
  public:
    Decoder(bool srgb, double gamma) : gamma_(gamma) {
        for (std::size_t i = 0; srgb && i < table_.size(); ++i) {
            table_[i] = static_cast<float>(srgbToLinear(static_cast<double>(i) / (table_.size() - 1.0)));
        }
        srgb_ = srgb;
    }

    float operator()(float encoded) const {
        if (!std::isfinite(encoded)) return encoded;
        if (srgb_ && encoded >= 0.0F && encoded <= 1.0F) {
            // 8 and 16 bits fall on entries; floats that say they are sRGB are off by 1/131070 at most.
            // Never negative, and std::lround would be a call for each sample:
            // NOLINTNEXTLINE(bugprone-incorrect-roundings)
            return table_[static_cast<std::size_t>(encoded * 65535.0F + 0.5F)];
        }
        if (srgb_) return static_cast<float>(srgbToLinear(encoded));
        return gamma_ == 1.0 ? encoded : std::pow(std::max(encoded, 0.0F), static_cast<float>(gamma_));
    }

  private:
    std::vector<float> table_ = std::vector<float>(65536);
    bool srgb_ = false;
    double gamma_ = 1.0;
};

/// Values of a picture, as many to each pixel, in the order in which they lie when it stands upright.
template <class T>
std::vector<T> turned(std::vector<T> values, std::size_t width, std::size_t height, int orientation) {
    if (orientation < 2 || orientation > 8) return values;
    // Exif 2.3, table of orientations: which sides of the stored picture are the top and the left one.
    const bool transposed = orientation >= 5;
    const bool fromRight = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool fromBottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    const std::size_t each = values.size() / (width * height);
    std::vector<T> result;
    result.reserve(values.size());
    for (std::size_t y = 0; y < (transposed ? width : height); ++y) {
        for (std::size_t x = 0; x < (transposed ? height : width); ++x) {
            const std::size_t alongX = transposed ? y : x, alongY = transposed ? x : y;
            const std::size_t column = fromRight ? width - 1 - alongX : alongX;
            const std::size_t row = fromBottom ? height - 1 - alongY : alongY;
            const auto from = values.begin() + static_cast<std::ptrdiff_t>(each * (row * width + column));
            result.insert(result.end(), from, from + static_cast<std::ptrdiff_t>(each));
        }
    }
    return result;
}

class PictureReader {
  public:
    PictureReader(fs::path path, Progress& progress) : path_(std::move(path)), progress_(progress) {}

    Result<Picture> read(std::uint64_t memory) {
        MOTE_RETURN_IF_ERROR(open());
        if (spec_.format == "tiff") {
            const auto most = memory > 0 ? memory / (2 * sizeof(float)) : storage::maxImagePixels;
            MOTE_ASSIGN_OR_RETURN(auto bilevel,
                                  readBilevelTiff(path_, std::min(most, storage::maxImagePixels)));
            if (bilevel) {
                picture_.colorSpace = "linear";
                picture_.luminance = upright(*std::move(bilevel), spec_.orientation);
                return std::move(picture_);
            }
        }
        MOTE_RETURN_IF_ERROR(checkSize(memory));
        MOTE_RETURN_IF_ERROR(findColorSpace());
        MOTE_RETURN_IF_ERROR(readPixels());
        MOTE_RETURN_IF_ERROR(applyDisplayWindow());
        const int orientation = spec_.orientation;
        const auto& [width, height, values] = picture_.luminance;
        if (picture_.color) picture_.colors = turned(std::move(picture_.colors), width, height, orientation);
        picture_.luminance = upright(std::move(picture_.luminance), orientation);
        return std::move(picture_);
    }

  private:
    Error corrupt(std::string message) const {
        std::replace(message.begin(), message.end(), '\n', ' ');
        return {ErrorCode::corrupt, path_.string(), std::move(message)};
    }

    Status open() {
        static const auto openPicture =
            reinterpret_cast<OpenPicture>(moduleFunction(pictureModule, openPictureName));
        MOTE_ASSIGN_OR_RETURN(const auto format, pictureFormat(path_));
        if (openPicture == nullptr)
            return Error{ErrorCode::internal, path_.string(),
                         fmt::format("cannot be read: {}.so is not with mote-prep, or lacks a library",
                                     pictureModule)};
        std::string why;
        input_.reset(openPicture(format, path_.c_str(), why));
        if (!input_) return corrupt(std::move(why));
        spec_ = input_->spec();
        return success();
    }

    Status checkSize(std::uint64_t memory) {
        if (spec_.deep || spec_.depth > 1) {
            return unsupported(path_.string(), "is no flat picture, but a deep or solid one");
        }
        if (spec_.width < 1 || spec_.height < 1 || spec_.channels < 1) {
            return corrupt(fmt::format("has no pixels ({} x {}, {} channels)", spec_.width, spec_.height,
                                       spec_.channels));
        }
        const auto pixels =
            static_cast<std::uint64_t>(spec_.width) * static_cast<std::uint64_t>(spec_.height);
        const auto side = static_cast<std::uint32_t>(std::max(spec_.width, spec_.height));
        if (side > storage::maxImageSide || pixels > storage::maxImagePixels) {
            return Error{
                ErrorCode::resourceExhausted, path_.string(),
                fmt::format("has {} x {} pixels; a picture may have {} a side and {} in all", spec_.width,
                            spec_.height, storage::maxImageSide, storage::maxImagePixels)};
        }
        stripRows_ = std::max(1, spec_.tileWidth > 0 ? spec_.tileHeight : 64);
        const auto strip = static_cast<std::uint64_t>(spec_.width) * spec_.channels * sizeof(float) *
                           static_cast<std::uint64_t>(std::min(stripRows_, spec_.height));
        // Twice, while it is turned upright.
        const std::uint64_t ofPixel = sizeof(float) + (isColor() ? 3 * sizeof(std::uint16_t) : 0);
        const std::uint64_t needed = 2 * pixels * ofPixel + strip;
        const std::uint64_t limit = memory > 0 ? memory : 8 * storage::maxImagePixels * sizeof(float);
        if (needed <= limit) return success();
        return Error{ErrorCode::resourceExhausted, path_.string(),
                     fmt::format("takes {} MiB of memory to read; the limit is {} MiB", (needed >> 20) + 1,
                                 limit >> 20)};
    }

    /// Takes what the file says; integers are sRGB and floats linear where it says nothing.
    Status findColorSpace() {
        const std::string& said = spec_.colorSpace;
        const float gamma = spec_.gamma;
        const auto begins = [&](std::string_view name) {
            const auto alike = [](unsigned char a, unsigned char b) {
                return std::tolower(a) == std::tolower(b);
            };
            return said.size() >= name.size() && std::equal(name.begin(), name.end(), said.begin(), alike);
        };
        const auto is = [&](std::string_view name) { return said.size() == name.size() && begins(name); };
        if (is("sRGB") || (said.empty() && !spec_.floats)) {
            picture_.colorSpace = "sRGB";
        } else if (is("Linear") || is("lin_srgb") || said.empty()) {
            picture_.colorSpace = "linear";
        } else if (begins("Gamma") && gamma > 0.1F && gamma < 10.0F) {
            picture_.colorSpace = fmt::format("gamma {:.3g}", gamma);
            gamma_ = gamma;
        } else {
            return unsupported(path_.string(), fmt::format("has the colour space \"{}\", which is not known",
                                                           said.substr(0, 40)));
        }
        return success();
    }

    bool isColor() const { return spec_.channels - (spec_.alphaChannel >= 0 ? 1 : 0) >= 3; }

    Status readPixels() {
        picture_.color = isColor();
        picture_.transparent = spec_.alphaChannel >= 0;
        straight_ = spec_.straightAlpha;
        auto& luminance = picture_.luminance;
        luminance.width = static_cast<std::uint32_t>(spec_.width);
        luminance.height = static_cast<std::uint32_t>(spec_.height);
        luminance.values.resize(static_cast<std::size_t>(spec_.width) * luminance.height);
        if (picture_.color) picture_.colors.resize(3 * luminance.values.size());
        const Decoder decode(picture_.colorSpace == "sRGB", gamma_);
        std::vector<float> strip(static_cast<std::size_t>(spec_.width) * spec_.channels *
                                 static_cast<std::size_t>(std::min(stripRows_, spec_.height)));
        for (int row = 0; row < spec_.height; row += stripRows_) {
            if (progress_.cancelled()) return wasCancelled();
            progress_.report(0.8 * row / spec_.height, "reading the picture");
            const int rows = std::min(stripRows_, spec_.height - row);
            if (auto why = input_->readRows(row, rows, strip.data()); !why.empty())
                return corrupt(std::move(why));
            convert(decode, strip, row, rows);
        }
        return success();
    }

    /// OpenEXR's pixels are a part of the picture, or more than it: what is shown is the display window.
    Status applyDisplayWindow() {
        const bool same = spec_.x == spec_.fullX && spec_.y == spec_.fullY &&
                          spec_.width == spec_.fullWidth && spec_.height == spec_.fullHeight;
        if (spec_.format != "openexr" || same) return success();
        const auto width = static_cast<std::int64_t>(spec_.fullWidth);
        const auto height = static_cast<std::int64_t>(spec_.fullHeight);
        if (width < 1 || height < 1 || std::max(width, height) > storage::maxImageSide ||
            width * height > static_cast<std::int64_t>(storage::maxImagePixels)) {
            return corrupt(fmt::format("has a display window of {} x {} pixels", width, height));
        }
        const float paper = picture_.transparent ? 1.0F : 0.0F;
        picture_.luminance = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                              windowOf(picture_.luminance.values, paper)};
        if (picture_.color) picture_.colors = windowOf(picture_.colors, storage::halfBits(paper));
        progress_.note(fmt::format(
            "its pixels are {} x {} at ({}, {}); the display window of {} x {} is the picture, and is {} "
            "where there are none",
            spec_.width, spec_.height, spec_.x - spec_.fullX, spec_.y - spec_.fullY, width, height,
            picture_.transparent ? "white" : "black"));
        return success();
    }

    /// Of values, as many to each pixel, those in the display window; `paper` where there are none.
    template <class T>
    std::vector<T> windowOf(const std::vector<T>& values, T paper) const {
        const auto width = static_cast<std::size_t>(spec_.width);
        const std::size_t each = values.size() / (width * static_cast<std::size_t>(spec_.height));
        const auto shownWidth = static_cast<std::size_t>(spec_.fullWidth);
        std::vector<T> shown(each * shownWidth * static_cast<std::size_t>(spec_.fullHeight), paper);
        const std::int64_t right = std::int64_t{spec_.x} - spec_.fullX,
                           down = std::int64_t{spec_.y} - spec_.fullY;
        const std::int64_t first = std::max<std::int64_t>(right, 0);
        const std::int64_t last = std::min<std::int64_t>(right + spec_.width, spec_.fullWidth);
        for (std::int64_t row = 0; row < spec_.height && first < last; ++row) {
            if (row + down < 0 || row + down >= spec_.fullHeight) continue;
            const auto from =
                values.begin() + static_cast<std::ptrdiff_t>(each) * (row * spec_.width + first - right);
            const auto to =
                shown.begin() + static_cast<std::ptrdiff_t>(each) * ((row + down) * spec_.fullWidth + first);
            std::copy_n(from, static_cast<std::ptrdiff_t>(each) * (last - first), to);
        }
        return shown;
    }

    void convert(const Decoder& decode, const std::vector<float>& strip, int row, int rows) {
        const auto count = static_cast<std::size_t>(spec_.width) * static_cast<std::size_t>(rows);
        const auto first = static_cast<std::size_t>(spec_.width) * static_cast<std::size_t>(row);
        for (std::size_t i = 0; i < count; ++i) {
            const auto [light, color] = onWhite(decode, &strip[i * static_cast<std::size_t>(spec_.channels)]);
            const bool finite = std::isfinite(light);
            picture_.invalid += finite ? 0 : 1;
            picture_.luminance.values[first + i] = finite ? std::max(light, 0.0F) : 1.0F;
            for (std::size_t c = 0; picture_.color && c < 3; ++c)
                picture_.colors[3 * (first + i) + c] = storage::halfBits(finite ? color[c] : 1.0F);
        }
    }

    /// Luminance, and of a picture in colour its components.
    struct PixelLight {
        float luminance;
        std::array<float, 3> color;
    };

    /// Light that a pixel on white paper sends back. Colours are multiplied by alpha where the format says
    /// so.
    PixelLight onWhite(const Decoder& decode, const float* pixel) const {
        const float alpha = picture_.transparent ? std::clamp(pixel[spec_.alphaChannel], 0.0F, 1.0F) : 1.0F;
        const bool divide = !straight_ && alpha > 0.0F && alpha < 1.0F;
        const auto channel = [&](int c) { return decode(divide ? pixel[c] / alpha : pixel[c]); };
        const auto laid = [&](float light) {
            return picture_.transparent ? light * (straight_ || alpha > 0.0F ? alpha : 1.0F) + 1.0F - alpha
                                        : light;
        };
        if (!picture_.color) {
            const int grey = spec_.alphaChannel == 0 && spec_.channels > 1 ? 1 : 0;
            return {laid(channel(grey)), {}};
        }
        const float red = channel(0), green = channel(1), blue = channel(2);
        return {laid(0.2126F * red + 0.7152F * green + 0.0722F * blue), {laid(red), laid(green), laid(blue)}};
    }

    fs::path path_;
    Progress& progress_;
    std::unique_ptr<PictureInput> input_;
    PictureSpec spec_;
    int stripRows_ = 1;
    double gamma_ = 1.0;
    bool straight_ = false;  ///< colours are not multiplied by alpha
    Picture picture_;
};

}  // namespace

storage::Luminance upright(storage::Luminance picture, int orientation) {
    picture.values = turned(std::move(picture.values), picture.width, picture.height, orientation);
    if (orientation >= 5 && orientation <= 8) std::swap(picture.width, picture.height);
    return picture;
}

Result<const char*> pictureFormat(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto head, firstBytes(path));
    if (head.empty()) return Error{ErrorCode::corrupt, path.string(), "is empty"};
    const auto found = std::find_if(signatures.begin(), signatures.end(), [&](const Signature& signature) {
        return std::string_view(head).starts_with(signature.bytes);
    });
    if (found == signatures.end()) {
        return unsupported(path.string(), "is no PNG, JPEG, TIFF or OpenEXR picture");
    }
    if (found->format != "jpeg"sv) return found->format;
    MOTE_ASSIGN_OR_RETURN(const auto bytes, storage::readWhole(path, jpegLimit));
    if (jpegHasEnd(bytes)) return found->format;
    return Error{ErrorCode::corrupt, path.string(), "ends before its picture does"};
}

Result<Picture> readPicture(const fs::path& path, std::uint64_t memory, Progress& progress) {
    std::error_code code;
    auto canonical = fs::canonical(path, code);
    if (code) canonical = path;
    // Its readers of OpenEXR and TIFF throw here and there at what is broken.
    try {
        return PictureReader(canonical, progress).read(memory);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::resourceExhausted, path.string(), "is too large for the memory there is"};
    } catch (const std::exception& error) {
        return Error{ErrorCode::corrupt, path.string(), std::string("cannot be read: ") + error.what()};
    }
}

}  // namespace mote::prep
