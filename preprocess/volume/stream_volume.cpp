// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/stream_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace mote::prep {
namespace {

constexpr std::size_t blockBytes = 1u << 20;

}  // namespace

StreamVolume::StreamVolume(std::string format, VolumeShape shape, const SampleFormat& samples,
                           ByteStreamPtr stream, Ending ending)
    : format_(std::move(format)),
      shape_(std::move(shape)),
      samples_(samples),
      stream_(std::move(stream)),
      ending_(ending) {
    const bool integers = samples.type != ScalarType::f32 && samples.type != ScalarType::f64;
    if (integers) shape_.valueStep = std::abs(samples.slope);
}

Result<std::unique_ptr<VolumeSource>> StreamVolume::make(std::string format, VolumeShape shape,
                                                         const SampleFormat& samples, ByteStreamPtr stream,
                                                         Ending ending) {
    std::unique_ptr<StreamVolume> volume(
        new StreamVolume(std::move(format), std::move(shape), samples, std::move(stream), ending));
    MOTE_RETURN_IF_ERROR(volume->checkLength());
    return std::unique_ptr<VolumeSource>(std::move(volume));
}

Error StreamVolume::contradiction(const std::string& held) const {
    return {
        ErrorCode::corrupt, stream_->name(),
        fmt::format("its dimensions {} x {} x {} of {} are {} bytes, and it holds {}", shape_.nx, shape_.ny,
                    shape_.nz, name(samples_.type), shape_.voxels() * bytesOf(samples_.type), held)};
}

Status StreamVolume::checkLength() const {
    const std::uint64_t needed = shape_.voxels() * bytesOf(samples_.type);
    if (const auto size = stream_->size()) {
        const bool fits = ending_ == Ending::end ? *size == needed : *size >= needed;
        return fits ? success() : Status(contradiction(fmt::format("{}", *size)));
    }
    if (stream_->mostBytes() < needed) return contradiction(fmt::format("at most {}", stream_->mostBytes()));
    return success();
}

/// What comes out of a compressed stream behind its last number says that the dimensions are wrong.
Status StreamVolume::checkEnd() {
    std::array<char, 1> one{};
    const auto got = stream_->read(one);
    if (!got) return got.error();
    return *got == 0 ? success() : Status(contradiction("more"));
}

Status StreamVolume::read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) {
    MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
    const std::size_t width = bytesOf(samples_.type);
    MOTE_RETURN_IF_ERROR(stream_->seek(shape_.voxelsOfSlice() * z0 * width));
    block_.resize(std::min(values.size() * width, blockBytes));
    while (!values.empty()) {
        const std::size_t count = std::min(values.size(), block_.size() / width);
        const std::span<char> bytes = std::span(block_).first(count * width);
        const auto got = stream_->read(bytes);
        if (!got) return got.error();
        if (*got < bytes.size()) return contradiction("less");
        decodeSamples(bytes, samples_, values.first(count));
        values = values.subspan(count);
    }
    return z1 == shape_.nz && ending_ == Ending::end ? checkEnd() : success();
}

}  // namespace mote::prep
