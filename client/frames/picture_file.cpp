// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string_view>

#include "client/shared/part_file.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

constexpr std::string_view keyPrefix = "mote-frames ";
constexpr int writtenChannels = 3;  // alpha is always one

struct FormatFacts {
    std::string_view name, extension;
    proto::Page::Format page = proto::Page::FORMAT_UNSPECIFIED;
};

/// In the order of PictureFormat.
constexpr std::array<FormatFacts, 7> formats{{{"png", "png"},
                                              {"png16", "png"},
                                              {"exr", "exr"},
                                              {"jpg", "jpg"},
                                              {"svg", "svg", proto::Page::SVG},
                                              {"eps", "eps", proto::Page::EPS},
                                              {"pdf", "pdf", proto::Page::PDF}}};

const FormatFacts& factsOf(PictureFormat format) {
    return formats.at(static_cast<std::size_t>(format));
}

OIIO::TypeDesc sampleType(PictureFormat format) {
    if (format == PictureFormat::png16) return OIIO::TypeDesc::UINT16;
    return format == PictureFormat::exr ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8;
}

OIIO::ImageSpec describe(const FramePixels& pixels, PictureFormat format, std::string_view key) {
    OIIO::ImageSpec spec(static_cast<int>(pixels.width), static_cast<int>(pixels.height), writtenChannels,
                         sampleType(format));
    spec.attribute("ImageDescription", fmt::format("{}{}", keyPrefix, key));
    spec.attribute("oiio:ColorSpace", format == PictureFormat::exr ? "Linear" : "sRGB");
    switch (format) {
        case PictureFormat::png:
        case PictureFormat::png16:
            // Pictures of points are noise to deflate: 6, the default, is 4 times slower and 1% smaller.
            spec.attribute("png:compressionLevel", 4);
            break;
        case PictureFormat::exr:
            spec.attribute("compression", "zip");
            // The writer puts in the present time if there is none, and bytes would differ.
            spec.attribute("DateTime", "");
            break;
        case PictureFormat::jpg:
            spec.attribute("compression", "jpeg:95");
            // Halved chroma ruins single coloured pixels, and points are such.
            spec.attribute("jpeg:subsampling", "4:4:4");
            break;
        default:
            break;
    }
    return spec;
}

/// A document ends in a comment that says what it shows, after all that its readers look for.
std::string keyLine(PictureFormat format, std::string_view key) {
    if (format == PictureFormat::svg) return fmt::format("<!-- {}{} -->\n", keyPrefix, key);
    return fmt::format("%{}{}\n", keyPrefix, key);
}

std::optional<std::string> readKeyLine(const std::filesystem::path& path, PictureFormat format) {
    constexpr std::size_t keySize = 32;  // hexadecimal digits
    const auto size = static_cast<std::streamoff>(keyLine(format, std::string(keySize, '0')).size());
    std::ifstream file(path, std::ios::binary);
    file.seekg(-size, std::ios::end);
    std::string line(static_cast<std::size_t>(size), '\0');
    file.read(line.data(), size);
    const auto begin = line.find(keyPrefix);
    if (!file.good() || begin == std::string::npos) return std::nullopt;
    auto key = line.substr(begin + keyPrefix.size(), keySize);
    return keyLine(format, key) == line ? std::optional(std::move(key)) : std::nullopt;
}

Error fromOiio(std::string message) {
    if (message.empty()) message = "OpenImageIO gives no reason";
    std::replace(message.begin(), message.end(), '\n', ' ');
    return {ErrorCode::internal, "", "the picture cannot be encoded: " + message};
}

/// Linear halves as sRGB of 16 bits.
std::vector<std::uint16_t> deepSamples(const FramePixels& pixels) {
    std::vector<float> linear(pixels.bytes.size() / sizeof(std::uint16_t));
    OIIO::convert_pixel_values(OIIO::TypeDesc::HALF, pixels.bytes.data(), OIIO::TypeDesc::FLOAT,
                               linear.data(), static_cast<int>(linear.size()));
    std::vector<std::uint16_t> samples(linear.size());
    std::transform(linear.begin(), linear.end(), samples.begin(), [](float value) {
        const double held = std::clamp(std::isfinite(value) ? value : 0.0F, 0.0F, 1.0F);
        return static_cast<std::uint16_t>(std::lround(65535.0 * linearToSrgb(held)));
    });
    return samples;
}

bool writeSamples(OIIO::ImageOutput& output, const FramePixels& pixels, PictureFormat format) {
    if (format == PictureFormat::png16) {
        const auto samples = deepSamples(pixels);
        return output.write_image(sampleType(format), samples.data(), 4 * sizeof(std::uint16_t));
    }
    const auto stride = static_cast<OIIO::stride_t>(bytesPerPixel(pixels.format));
    return output.write_image(sampleType(format), pixels.bytes.data(), stride);
}

/// The last bytes of every file of a format; of an EXR file they are pixels.
std::string_view lastBytes(PictureFormat format) {
    switch (format) {
        case PictureFormat::png:
        case PictureFormat::png16:
            return {"IEND\xae\x42\x60\x82", 8};
        case PictureFormat::jpg:
            return {"\xff\xd9", 2};
        default:
            return {};
    }
}

/// Readers of PNG and JPEG forgive an end that is missing; for JPEG they make up half a picture.
bool hasItsEnd(const std::filesystem::path& path, PictureFormat format) {
    const auto wanted = lastBytes(format);
    std::ifstream file(path, std::ios::binary);
    file.seekg(-static_cast<std::streamoff>(wanted.size()), std::ios::end);
    std::string found(wanted.size(), '\0');
    file.read(found.data(), static_cast<std::streamsize>(found.size()));
    return file.good() && found == wanted;
}

bool readsWhole(OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
    std::vector<std::uint8_t> pixels(spec.image_bytes(true));
    return input.read_image(0, 0, 0, spec.nchannels, spec.format, pixels.data());
}

}  // namespace

std::optional<PictureFormat> pictureFormat(std::string_view text) {
    const auto found =
        std::find_if(formats.begin(), formats.end(), [&](const auto& format) { return format.name == text; });
    if (found == formats.end()) return std::nullopt;
    return static_cast<PictureFormat>(found - formats.begin());
}

std::string_view name(PictureFormat format) {
    return factsOf(format).name;
}

std::string_view extension(PictureFormat format) {
    return factsOf(format).extension;
}

proto::PixelFormat pixelFormat(PictureFormat format) {
    if (pageFormat(format) != proto::Page::FORMAT_UNSPECIFIED) return proto::PIXEL_FORMAT_UNSPECIFIED;
    const bool deep = format == PictureFormat::exr || format == PictureFormat::png16;
    return deep ? proto::LINEAR_HALF : proto::SRGB8;
}

proto::Page::Format pageFormat(PictureFormat format) {
    return factsOf(format).page;
}

Result<std::vector<std::uint8_t>> encodePicture(const FramePixels& pixels, PictureFormat format,
                                                std::string_view key) {
    if (pixels.format != pixelFormat(format)) {
        return Error{ErrorCode::unsupported, "",
                     "the server sent pixels of another format than was asked for"};
    }
    if (pageFormat(format) != proto::Page::FORMAT_UNSPECIFIED) {
        auto document = pixels.bytes;
        const auto line = keyLine(format, key);
        document.insert(document.end(), line.begin(), line.end());
        return document;
    }
    auto output = OIIO::ImageOutput::create(std::string(extension(format)));
    if (!output) return fromOiio(OIIO::geterror());
    auto spec = describe(pixels, format, key);
    std::vector<std::uint8_t> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    void* proxy = &memory;
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    if (!output->open(fmt::format("picture.{}", extension(format)), spec))
        return fromOiio(output->geterror());
    const bool written = writeSamples(*output, pixels, format);
    if (!output->close() || !written) return fromOiio(output->geterror());
    return bytes;
}

std::optional<std::string> readPictureKey(const std::filesystem::path& path, PictureFormat format,
                                          std::uint32_t width, std::uint32_t height) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) return std::nullopt;
    if (pageFormat(format) != proto::Page::FORMAT_UNSPECIFIED) return readKeyLine(path, format);
    if (!hasItsEnd(path, format)) return std::nullopt;
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) {
        OIIO::geterror();  // taken, or the library prints it at exit
        return std::nullopt;
    }
    const auto& spec = input->spec();
    const std::string description = spec.get_string_attribute("ImageDescription");
    const bool ours = description.compare(0, keyPrefix.size(), keyPrefix) == 0;
    const bool size = spec.width == static_cast<int>(width) && spec.height == static_cast<int>(height) &&
                      spec.nchannels == writtenChannels && spec.format == sampleType(format);
    const bool whole = ours && size && readsWhole(*input, spec);
    input->geterror();
    if (!whole) return std::nullopt;
    return description.substr(keyPrefix.size());
}

Status writeFile(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(path));
    MOTE_RETURN_IF_ERROR(part->append(bytes));
    return part->publish();
}

}  // namespace mote::client
