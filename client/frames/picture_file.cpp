// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <fmt/format.h>
#include <half.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <span>
#include <string_view>

#include "client/shared/part_file.h"
#include "client/shared/png_file.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

constexpr std::string_view keyPrefix = "mote-frames ";

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

/// Of R, G, B and alpha.
std::size_t samplesOf(std::uint32_t width, std::uint32_t height) {
    return std::size_t{4} * width * height;
}

/// By the bits of a linear half: sRGB of 16 bits, the high byte first.
const std::vector<std::array<std::uint8_t, 2>>& deepSamples() {
    static const auto table = [] {
        std::vector<std::array<std::uint8_t, 2>> samples(std::size_t{1} << 16);
        for (std::size_t bits = 0; bits < samples.size(); ++bits) {
            half value;
            value.setBits(static_cast<std::uint16_t>(bits));
            const double held = std::clamp(value.isFinite() ? float(value) : 0.0F, 0.0F, 1.0F);
            const auto sample = std::lround(65535.0 * linearToSrgb(held));
            samples[bits] = {static_cast<std::uint8_t>(sample >> 8), static_cast<std::uint8_t>(sample)};
        }
        return samples;
    }();
    return table;
}

std::vector<std::uint8_t> encodeDeepPng(const FramePixels& pixels, std::string_view description) {
    const auto& table = deepSamples();
    std::vector<std::uint8_t> samples(pixels.bytes.size());
    for (std::size_t i = 0; i + 1 < samples.size(); i += 2) {
        const auto& sample = table[pixels.bytes[i] | pixels.bytes[i + 1] << 8];
        samples[i] = sample[0];
        samples[i + 1] = sample[1];
    }
    return encodePng({pixels.width, pixels.height, 16, 4, samples}, description);
}

/// Quality 95; halved chroma would ruin single coloured pixels, and points are such. The description stands
/// in a comment behind the first segment (ITU T.81, B.2.4.5; JFIF's own must come first).
Result<std::vector<std::uint8_t>> encodeJpeg(const FramePixels& pixels, std::string_view description) {
    constexpr std::size_t behindJfif = 20;
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitCompress(), tjDestroy);
    unsigned char* made = nullptr;
    unsigned long size = 0;
    const int failed = !jpeg ? -1
                             : tjCompress2(jpeg.get(), pixels.bytes.data(), static_cast<int>(pixels.width), 0,
                                           static_cast<int>(pixels.height), TJPF_RGBX, &made, &size,
                                           TJSAMP_444, 95, TJFLAG_ACCURATEDCT);
    const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(made, tjFree);
    if (failed != 0) {
        return Error{ErrorCode::internal, "",
                     fmt::format("the picture cannot be encoded: {}", tjGetErrorStr2(jpeg.get()))};
    }
    std::vector<std::uint8_t> file(made, made + behindJfif);
    const std::size_t length = description.size() + 3;  // with itself, and a zero
    file.insert(file.end(),
                {0xff, 0xfe, static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length)});
    file.insert(file.end(), description.begin(), description.end());
    file.push_back(0);
    file.insert(file.end(), made + behindJfif, made + size);
    return file;
}

/// The pixels of a whole JPEG file, and its comment.
struct JpegPicture {
    FramePixels pixels;
    std::string description;
};

Result<JpegPicture> readJpeg(std::span<const std::uint8_t> file) {
    JpegPicture picture;
    proto::Frame message;
    message.set_format(proto::SRGB8);
    message.set_encoding(proto::Frame::JPEG);
    // The segments before the scan (ITU T.81, B.1.1.4): a marker, and a length that counts itself.
    for (std::size_t at = 2; at + 4 <= file.size() && file[at] == 0xff && file[at + 1] != 0xda;) {
        const std::size_t length = file[at + 2] << 8 | file[at + 3];
        if (length < 2 || at + 2 + length > file.size()) break;
        const auto data = file.subspan(at + 4, length - 2);
        if (file[at + 1] == 0xfe)
            picture.description.assign(data.begin(), std::find(data.begin(), data.end(), 0));
        if (file[at + 1] >= 0xc0 && file[at + 1] <= 0xc2 && data.size() >= 5) {
            message.set_height(data[1] << 8 | data[2]);
            message.set_width(data[3] << 8 | data[4]);
        }
        at += 2 + length;
    }
    MOTE_ASSIGN_OR_RETURN(picture.pixels, decodeFrame(message, file));
    return picture;
}

class MemoryOutput final : public Imf::OStream {
  public:
    explicit MemoryOutput(std::vector<std::uint8_t>& bytes) : OStream("picture.exr"), bytes_(bytes) {}
    void write(const char from[], int count) override {
        bytes_.resize(std::max(bytes_.size(), place_ + static_cast<std::size_t>(count)));
        std::memcpy(bytes_.data() + place_, from, static_cast<std::size_t>(count));
        place_ += static_cast<std::size_t>(count);
    }
    std::uint64_t tellp() override { return place_; }
    void seekp(std::uint64_t place) override { place_ = place; }

  private:
    std::vector<std::uint8_t>& bytes_;
    std::size_t place_ = 0;
};

/// R, G and B of linear halves.
Imf::FrameBuffer halvesAt(std::uint8_t* rgba, std::uint32_t width) {
    Imf::FrameBuffer buffer;
    for (std::size_t i = 0; i < 3; ++i) {
        auto* const first = reinterpret_cast<char*>(rgba + 2 * i);
        buffer.insert(std::string(1, "RGB"[i]), Imf::Slice(Imf::HALF, first, 8, std::size_t{8} * width));
    }
    return buffer;
}

Result<std::vector<std::uint8_t>> encodeExr(FramePixels pixels, std::string_view description) {
    try {
        Imf::Header header(static_cast<int>(pixels.width), static_cast<int>(pixels.height));
        header.compression() = Imf::ZIP_COMPRESSION;
        for (const char* channel : {"R", "G", "B"})
            header.channels().insert(channel, Imf::Channel(Imf::HALF));
        Imf::addComments(header, std::string(description));
        std::vector<std::uint8_t> bytes;
        {
            MemoryOutput memory(bytes);
            Imf::OutputFile file(memory, header, 0);
            file.setFrameBuffer(halvesAt(pixels.bytes.data(), pixels.width));
            file.writePixels(static_cast<int>(pixels.height));
        }
        return bytes;
    } catch (const std::exception& failure) {
        return Error{ErrorCode::internal, "",
                     fmt::format("the picture cannot be encoded: {}", failure.what())};
    }
}

/// The description of a whole EXR file of that size; empty if it is none. Throws what OpenEXR throws at
/// damage.
std::optional<std::string> readExr(const std::filesystem::path& path, std::uint32_t width,
                                   std::uint32_t height) {
    Imf::InputFile file(path.c_str(), 0);
    const auto& header = file.header();
    const auto& window = header.dataWindow();
    const bool size = window.min == Imath::V2i(0) &&
                      window.max == Imath::V2i(static_cast<int>(width) - 1, static_cast<int>(height) - 1);
    if (!size || !Imf::hasComments(header)) return std::nullopt;
    std::vector<std::uint8_t> pixels(2 * samplesOf(width, height));
    file.setFrameBuffer(halvesAt(pixels.data(), width));
    file.readPixels(0, static_cast<int>(height) - 1);
    return Imf::comments(header);
}

/// Its bytes; none where it cannot be read, or is larger than any picture of ours.
std::vector<std::uint8_t> fileBytes(const std::filesystem::path& path) {
    constexpr std::uintmax_t most = std::uintmax_t{1} << 30;
    std::error_code code;
    const auto size = std::filesystem::file_size(path, code);
    if (code || size > most) return {};
    std::vector<std::uint8_t> bytes(size);
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    return file.good() ? bytes : std::vector<std::uint8_t>();
}

/// The description of a picture file that is whole, of that size and format.
std::optional<std::string> readDescription(const std::filesystem::path& path, PictureFormat format,
                                           std::uint32_t width, std::uint32_t height) {
    try {
        if (format == PictureFormat::exr) return readExr(path, width, height);
    } catch (const std::exception&) {
        return std::nullopt;  // damaged
    }
    const auto bytes = fileBytes(path);
    if (format == PictureFormat::jpg) {
        auto picture = readJpeg(bytes);
        const bool same = picture.ok() && picture->pixels.width == width && picture->pixels.height == height;
        return same ? std::optional(std::move(picture->description)) : std::nullopt;
    }
    auto picture = readPng(bytes);
    const bool same = picture.ok() && picture->width == width && picture->height == height &&
                      picture->bits == (format == PictureFormat::png16 ? 16 : 8);
    return same ? std::optional(std::move(picture->description)) : std::nullopt;
}

/// R, G and B of 8 or 16 bits as RGBA of 8.
FramePixels framePixels(const PngPicture& picture) {
    const std::size_t sample = picture.bits / 8;
    FramePixels pixels{picture.width, picture.height, proto::SRGB8, {}};
    pixels.bytes.assign(samplesOf(picture.width, picture.height), 255);
    for (std::size_t i = 0; i < picture.bytes.size() / sample; ++i) {
        auto& byte = pixels.bytes[i / 3 * 4 + i % 3];
        byte = picture.bytes[i * sample];
        // 65535 is 257 times 255.
        if (sample == 2)
            byte = static_cast<std::uint8_t>(((byte << 8 | picture.bytes[2 * i + 1]) + 128) / 257);
    }
    return pixels;
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
    const auto description = fmt::format("{}{}", keyPrefix, key);
    switch (format) {
        case PictureFormat::png16:
            return encodeDeepPng(pixels, description);
        case PictureFormat::exr:
            return encodeExr(pixels, description);
        case PictureFormat::jpg:
            return encodeJpeg(pixels, description);
        default:
            return encodePng({pixels.width, pixels.height, 8, 4, pixels.bytes}, description);
    }
}

std::optional<std::string> readPictureKey(const std::filesystem::path& path, PictureFormat format,
                                          std::uint32_t width, std::uint32_t height) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) return std::nullopt;
    if (pageFormat(format) != proto::Page::FORMAT_UNSPECIFIED) return readKeyLine(path, format);
    const auto description = readDescription(path, format, width, height);
    if (!description || !description->starts_with(keyPrefix)) return std::nullopt;
    return description->substr(keyPrefix.size());
}

Result<FramePixels> readPictureFrame(const std::filesystem::path& path) {
    const auto bytes = fileBytes(path);
    const auto begins = [&](std::string_view first) {
        return bytes.size() > first.size() &&
               std::equal(first.begin(), first.end(), bytes.begin(),
                          [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
    };
    if (begins("\x89PNG")) {
        const auto picture = readPng(bytes);
        if (!picture.ok()) return picture.error().within(path.string());
        return framePixels(*picture);
    }
    if (begins("\xff\xd8")) {
        auto picture = readJpeg(bytes);
        if (!picture.ok()) return picture.error().within(path.string());
        return std::move(picture->pixels);
    }
    if (begins("\x76\x2f\x31\x01"))
        return unsupported(path.string(), "a video is made of png or jpg, not of linear pixels");
    return notFound(path.string(), "is no picture of mote-frames");
}

Status writeFile(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(path));
    MOTE_RETURN_IF_ERROR(part->append(bytes));
    return part->publish();
}

}  // namespace mote::client
