// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/stream_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "preprocess/readers/text/number.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

constexpr std::size_t bytesAtOnce = 1u << 20;
constexpr double mostSamples = 0x1p59;          // times 8 bytes is a number of 64 bits
constexpr std::uint64_t mostBehind = 1u << 16;  // bytes behind the last value of a compressed stream

constexpr std::size_t numberBuffer = std::size_t{256} * 1024;
constexpr std::size_t longestWord = 128;

/// The type of "uint8", "float", "f32"; none of other words.
std::optional<ScalarType> typeNamed(std::string_view word) {
    if (word == "float") return ScalarType::f32;
    if (word == "double") return ScalarType::f64;
    for (const auto& [longer, shorter] :
         {std::pair("uint", "u"), std::pair("int", "i"), std::pair("float", "f")}) {
        if (!word.starts_with(longer)) continue;
        return scalarType(shorter + std::string(word.substr(std::string_view(longer).size())));
    }
    return scalarType(word);
}

/// The numbers of "256x256x128"; none of other words.
std::vector<std::uint32_t> sizeNamed(std::string_view word) {
    std::vector<std::uint32_t> size;
    for (std::size_t begin = 0; begin <= word.size();) {
        const auto end = std::min(word.find('x', begin), word.size());
        const auto number = parseId(word.substr(begin, end - begin));
        if (!number || *number > std::numeric_limits<std::uint32_t>::max()) return {};
        size.push_back(static_cast<std::uint32_t>(*number));
        begin = end + 1;
    }
    return size.size() == 3 ? size : std::vector<std::uint32_t>();
}

bool separates(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',';
}

class NumberStream : public ForwardStream {
  public:
    explicit NumberStream(ByteStreamPtr text) : text_(std::move(text)), buffer_(numberBuffer) {}
    std::string name() const override { return text_->name(); }
    /// A number takes two characters at least, but for the last one.
    std::uint64_t mostBytes() const override {
        const std::uint64_t numbers = text_->mostBytes() / 2 + 1;
        return numbers > std::numeric_limits<std::uint64_t>::max() / sizeof(double)
                   ? std::numeric_limits<std::uint64_t>::max()
                   : numbers * sizeof(double);
    }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            if (used_ == sizeof(double)) {
                MOTE_ASSIGN_OR_RETURN(const auto more, nextNumber());
                if (!more) break;
                used_ = 0;
            }
            const std::size_t count = std::min(bytes.size() - done, sizeof(double) - used_);
            std::memcpy(bytes.data() + done, reinterpret_cast<const char*>(&number_) + used_, count);
            used_ += count;
            done += count;
        }
        return done;
    }

    Status restart() override {
        begin_ = end_ = 0;
        used_ = sizeof(double);
        atEnd_ = false;
        return text_->seek(0);
    }

  private:
    /// Reads on until the buffer's first word is whole. False if there is none.
    Result<bool> nextNumber() {
        while (true) {
            while (begin_ < end_ && separates(buffer_[begin_])) ++begin_;
            std::size_t stop = begin_;
            while (stop < end_ && !separates(buffer_[stop]) && buffer_[stop] != '<') ++stop;
            const bool whole = stop < end_ || atEnd_;
            if (whole && stop == begin_) return false;
            if (whole || stop - begin_ > longestWord) return parse(stop);
            MOTE_RETURN_IF_ERROR(fill());
        }
    }

    Result<bool> parse(std::size_t stop) {
        const std::string_view word(buffer_.data() + begin_, stop - begin_);
        const auto number = parseNumber(word);
        if (!number) {
            return corrupt(name(), fmt::format("has \"{}\" where a value should stand", word.substr(0, 20)));
        }
        number_ = *number;
        begin_ = stop;
        return true;
    }

    Status fill() {
        std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
                  buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
        end_ -= begin_;
        begin_ = 0;
        MOTE_ASSIGN_OR_RETURN(const auto got, text_->read(std::span(buffer_).subspan(end_)));
        end_ += got;
        atEnd_ = got == 0;
        return success();
    }

    ByteStreamPtr text_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;  // of the text that is not yet parsed
    bool atEnd_ = false;
    double number_ = 0.0;
    std::size_t used_ = sizeof(double);  // bytes of it that were handed out
};

}  // namespace

StreamVolume::StreamVolume(std::string format, VolumeShape shape, const SampleFormat& samples,
                           ByteStreamPtr stream, Ending ending, const VolumeParts& parts)
    : format_(std::move(format)),
      shape_(std::move(shape)),
      samples_(samples),
      stream_(std::move(stream)),
      ending_(ending),
      parts_(parts) {
    const bool integers =
        samples.type != ScalarType::f32 && samples.type != ScalarType::f64 && samples.type != ScalarType::f16;
    if (integers) shape_.valueStep = std::abs(samples.slope);
}

Result<std::unique_ptr<VolumeSource>> StreamVolume::make(std::string format, VolumeShape shape,
                                                         const SampleFormat& samples, ByteStreamPtr stream,
                                                         Ending ending, const VolumeParts& parts) {
    if (static_cast<double>(shape.voxels()) * static_cast<double>(parts.count()) > mostSamples) {
        return Error{ErrorCode::resourceExhausted, stream->name(), "says more values than can be counted"};
    }
    std::unique_ptr<StreamVolume> volume(
        new StreamVolume(std::move(format), std::move(shape), samples, std::move(stream), ending, parts));
    MOTE_RETURN_IF_ERROR(volume->checkLength());
    return std::unique_ptr<VolumeSource>(std::move(volume));
}

Error StreamVolume::contradiction(const std::string& held) const {
    const auto parts = parts_.count() == 1 ? "" : fmt::format(", {} times", parts_.count());
    return corrupt(stream_->name(),
                   fmt::format("its dimensions {} x {} x {} of {}{} are {} bytes, and it holds {}", shape_.nx,
                               shape_.ny, shape_.nz, name(samples_.type), parts, neededBytes(), held));
}

std::string StreamVolume::behind(std::uint64_t bytes) const {
    return fmt::format("{}: {} behind its last value {} left out", stream_->name(),
                       bytes == 1 ? "a byte" : fmt::format("{} bytes", bytes), bytes == 1 ? "was" : "were");
}

Status StreamVolume::checkLength() {
    const std::uint64_t needed = neededBytes();
    if (const auto size = stream_->size()) {
        if (*size < needed) return contradiction(fmt::format("{}", *size));
        if (*size == needed || ending_ == Ending::more) return success();
        if (ending_ == Ending::exact || *size - needed >= bytesOfSlice()) {
            return contradiction(fmt::format("{}", *size));
        }
        shape_.notes.push_back(behind(*size - needed));
        endChecked_ = true;
        return success();
    }
    if (stream_->mostBytes() < needed) return contradiction(fmt::format("at most {}", stream_->mostBytes()));
    return success();
}

/// What comes out of a compressed stream behind its last number, a slice or more, says that the dimensions
/// are wrong.
Status StreamVolume::checkEnd() {
    if (endChecked_ || ending_ == Ending::more || parts_.volume + 1 < parts_.volumes) return success();
    const std::uint64_t most = ending_ == Ending::exact ? 1 : std::min(bytesOfSlice(), mostBehind);
    std::vector<char> rest(static_cast<std::size_t>(most));
    MOTE_ASSIGN_OR_RETURN(const auto got, stream_->read(rest));
    if (got == most) return contradiction("more");
    if (got > 0) notes_.push_back(behind(got));
    endChecked_ = true;
    return success();
}

/// `bytes` is a value of each component for each of `values`.
Status StreamVolume::decode(std::span<char> bytes, std::span<float> values) {
    const std::size_t width = bytesOf(samples_.type);
    if (parts_.components > 1) {
        picked_.resize(values.size() * width);
        const auto stride = static_cast<std::size_t>(parts_.components) * width;
        const char* from = bytes.data() + parts_.component * width;
        for (std::size_t i = 0; i < values.size(); ++i) {
            std::memcpy(picked_.data() + i * width, from + i * stride, width);
        }
        bytes = picked_;
    }
    const auto number = rounded_ ? std::nullopt : inexactNumber(bytes, samples_);
    if (number && bytesOf(samples_.type) == 8) {
        return unsupported(
            stream_->name(),
            fmt::format("holds the 64-bit integer {}, which has more digits than a float keeps", *number));
    }
    if (number) {
        rounded_ = true;
        notes_.push_back(fmt::format("{}: integers as {} are rounded to floats, which keep 24 bits",
                                     stream_->name(), *number));
    }
    decodeSamples(bytes, samples_, values);
    return success();
}

Status StreamVolume::read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) {
    MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
    const std::size_t width = bytesOf(samples_.type) * static_cast<std::size_t>(parts_.components);
    MOTE_RETURN_IF_ERROR(stream_->seek(bytesOfSlice() * (shape_.nz * parts_.volume + z0)));
    block_.resize(std::max(std::min(values.size() * width, bytesAtOnce / width * width), width));
    while (!values.empty()) {
        const std::size_t count = std::min(values.size(), block_.size() / width);
        const std::span<char> bytes = std::span(block_).first(count * width);
        MOTE_ASSIGN_OR_RETURN(const auto got, stream_->read(bytes));
        if (got < bytes.size()) return contradiction("less");
        MOTE_RETURN_IF_ERROR(decode(bytes, values.first(count)));
        values = values.subspan(count);
    }
    return z1 == shape_.nz ? checkEnd() : success();
}

ByteStreamPtr numberStream(ByteStreamPtr text) {
    return std::make_unique<NumberStream>(std::move(text));
}

std::optional<proto::VolumeSourceOptions> saidByName(const std::filesystem::path& path) {
    const std::string file = lower(path.filename().string());
    proto::VolumeSourceOptions said;
    for (std::string_view rest = file; !rest.empty();) {
        const auto end = std::min(rest.find_first_of("_-. "), rest.size());
        const std::string_view word = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
        const auto size = sizeNamed(word);
        if (said.dimensions_size() == 0) said.mutable_dimensions()->Add(size.begin(), size.end());
        if (const auto type = typeNamed(word); type && said.type().empty())
            said.set_type(std::string(name(*type)));
    }
    if (said.dimensions_size() == 0 || said.type().empty()) return std::nullopt;
    return said;
}

Result<std::unique_ptr<VolumeSource>> openRaw(const proto::VolumeSourceOptions& asked,
                                              const std::filesystem::path& path) {
    proto::VolumeSourceOptions options = asked;
    if (const auto said = saidByName(path); said && asked.dimensions_size() == 0) {
        *options.mutable_dimensions() = said->dimensions();
        if (asked.type().empty()) options.set_type(said->type());
    }
    if (options.dimensions_size() != 3) {
        return invalid("dimensions", "a raw volume needs three of them");
    }
    SampleFormat samples;
    samples.bigEndian = options.big_endian();
    const std::string typeName = options.type().empty() ? "u8" : options.type();
    const auto type = scalarType(typeName);
    if (!type) {
        return invalid(
            "type",
            fmt::format("\"{:.20}\" is none of u8, i8, u16, i16, u32, i32, u64, i64, f16, f32 and f64",
                        typeName));
    }
    samples.type = *type;
    VolumeShape shape;
    // What is not read as it is stored counts as what it becomes.
    shape.type = *type == ScalarType::f16 ? ScalarType::f32 : *type;
    if (const auto status = setDimensions(shape, options.dimensions(0), options.dimensions(1),
                                          options.dimensions(2), "dimensions");
        !status) {
        return invalid(status.error().where, status.error().message);
    }
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(auto data, partStream(std::move(file), options.header_bytes()));
    // Dimensions that somebody typed are held against the file to the byte.
    return StreamVolume::make("raw", std::move(shape), samples, std::move(data), StreamVolume::Ending::exact);
}

}  // namespace mote::prep
