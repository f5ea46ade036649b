// SPDX-License-Identifier: GPL-3.0-or-later
//
// StreamVolume: a VolumeSource whose numbers lie one after the other in a ByteStream, x fastest; and two that
// need no more: numbers as text, and raw volumes, which the job's options describe. One owner, one thread at
// a time.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"

namespace mote::prep {

class StreamVolume : public VolumeSource {
  public:
    /// What may follow the last number in the stream: nothing, a few bytes, or something else of the file.
    enum class Ending : std::uint8_t { exact, end, more };

    /// Holds the shape against the stream's length before anything is read; the stream has all `parts`. Bytes
    /// behind the last value, fewer than a slice has, are a note. Errors: corrupt (the stream is too short,
    /// or too long if it should end).
    static Result<std::unique_ptr<VolumeSource>> make(std::string format, VolumeShape shape,
                                                      const SampleFormat& samples, ByteStreamPtr stream,
                                                      Ending ending = Ending::end,
                                                      const VolumeParts& parts = {});

    std::string format() const override { return format_; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return stream_->sequential(); }
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override;
    std::vector<std::string> takeNotes() override { return std::exchange(notes_, {}); }

  private:
    StreamVolume(std::string format, VolumeShape shape, const SampleFormat& samples, ByteStreamPtr stream,
                 Ending ending, const VolumeParts& parts);
    std::uint64_t bytesOfSlice() const {
        return shape_.voxelsOfSlice() * parts_.components * bytesOf(samples_.type);
    }
    std::uint64_t neededBytes() const { return bytesOfSlice() * shape_.nz * parts_.volumes; }
    Status checkLength();
    Error contradiction(const std::string& held) const;
    Status checkEnd();
    std::string behind(std::uint64_t bytes) const;
    Status decode(std::span<char> bytes, std::span<float> values);

    std::string format_;
    VolumeShape shape_;
    SampleFormat samples_;
    ByteStreamPtr stream_;
    Ending ending_;
    VolumeParts parts_;
    bool endChecked_ = false, rounded_ = false;
    std::vector<char> block_, picked_;
    std::vector<std::string> notes_;
};

/// How many volumes a file has, of a format whose Header, parsed from the file's beginning, says it. Errors:
/// those of fileStream and of Header::parse.
template <class Header>
Result<VolumeParts> partsOfHeader(const std::filesystem::path& path) {
    constexpr std::size_t longest = std::size_t{1} << 20;  // of a header
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(*file, longest));
    MOTE_ASSIGN_OR_RETURN(const auto header, Header::parse(head, file->name()));
    return header.parts;
}

/// Eight bytes, the machine's own double, for each number of `text`; between them stand blanks, line ends or
/// commas. They end with the text or, in XML, at a '<'. Reading: corrupt if a word is no number.
ByteStreamPtr numberStream(ByteStreamPtr text);

/// What the name of a raw file says of it: dimensions and type, as "engine_256x256x128_uint8.raw.gz" does, or
/// "a-3x4x5-f32.bin". None if it leaves either open.
std::optional<proto::VolumeSourceOptions> saidByName(const std::filesystem::path& path);

/// The file may be gzipped. Without dimensions it is as its name says. Errors: invalidArgument (options that
/// are missing or wrong), corrupt (another length than they say), those of fileStream.
Result<std::unique_ptr<VolumeSource>> openRaw(const proto::VolumeSourceOptions& options,
                                              const std::filesystem::path& path);

}  // namespace mote::prep
