// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/zlib_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "preprocess/readers/text/inflater.h"

namespace mote::prep {
namespace {

constexpr std::size_t skipBytes = 64 * 1024;

class BlockStream : public ByteStream {
  public:
    BlockStream(ByteStreamPtr data, ZlibBlocks blocks, std::unique_ptr<Inflater> inflater)
        : data_(std::move(data)), blocks_(std::move(blocks)), inflater_(std::move(inflater)) {
        begins_.reserve(blocks_.compressed.size());
        std::uint64_t begin = 0;
        for (const std::uint64_t size : blocks_.compressed) {
            begins_.push_back(begin);
            begin += size;
        }
    }

    std::string name() const override { return data_->name(); }
    bool sequential() const override { return data_->sequential(); }
    std::optional<std::uint64_t> size() const override { return blocks_.bytes; }
    std::uint64_t mostBytes() const override { return blocks_.bytes; }

    Result<std::size_t> read(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size() && at_ < blocks_.bytes) {
            const std::uint64_t within = at_ % blocks_.blockBytes;
            if (within == 0) MOTE_RETURN_IF_ERROR(enter(at_ / blocks_.blockBytes));
            const auto left = std::min(
                {std::uint64_t{bytes.size() - done}, blocks_.blockBytes - within, blocks_.bytes - at_});
            const auto got = inflate(bytes.subspan(done, static_cast<std::size_t>(left)));
            if (!got) return got.error();
            if (*got == 0) {
                return Error{ErrorCode::corrupt, name(),
                             fmt::format("block {} holds less than it should", at_ / blocks_.blockBytes)};
            }
            done += *got;
            at_ += *got;
            if (at_ % blocks_.blockBytes == 0 || at_ == blocks_.bytes) MOTE_RETURN_IF_ERROR(checkEnd());
        }
        return done;
    }

    Status seek(std::uint64_t offset) override {
        if (offset == at_ && entered_) return success();
        at_ = std::min(offset, blocks_.bytes);
        if (at_ == blocks_.bytes) return success();
        std::uint64_t within = at_ % blocks_.blockBytes;
        MOTE_RETURN_IF_ERROR(enter(at_ / blocks_.blockBytes));
        std::vector<char> skipped(static_cast<std::size_t>(std::min<std::uint64_t>(within, skipBytes)));
        while (within > 0) {
            const auto got = inflate(std::span(skipped).first(std::min<std::size_t>(skipped.size(), within)));
            if (!got) return got.error();
            if (*got == 0) return Error{ErrorCode::corrupt, name(), "a block holds less than it should"};
            within -= *got;
        }
        return success();
    }

  private:
    Status enter(std::uint64_t block) {
        const auto index = static_cast<std::size_t>(block);
        MOTE_RETURN_IF_ERROR(data_->seek(begins_[index]));
        left_ = blocks_.compressed[index];
        entered_ = true;
        return inflater_->reset();
    }

    /// The checksum stands at the block's end.
    Status checkEnd() {
        std::array<char, 1> one{};
        const auto got = inflate(one);
        if (!got) return got.error();
        if (*got == 0) return success();
        return Error{ErrorCode::corrupt, name(), "a block holds more than it should"};
    }

    /// No byte behind the block is taken, so that the next one is not one to go back to.
    Result<std::size_t> inflate(std::span<char> bytes) {
        return inflater_->read(bytes, [this](std::span<char> input) {
            auto got = data_->read(
                input.first(static_cast<std::size_t>(std::min<std::uint64_t>(input.size(), left_))));
            if (got) left_ -= *got;
            return got;
        });
    }

    ByteStreamPtr data_;
    ZlibBlocks blocks_;
    std::unique_ptr<Inflater> inflater_;
    std::vector<std::uint64_t> begins_;  // of the blocks in data_
    std::uint64_t at_ = 0, left_ = 0;    // left_: of the block's compressed bytes
    bool entered_ = false;
};

}  // namespace

Result<ByteStreamPtr> zlibBlockStream(ByteStreamPtr data, ZlibBlocks blocks) {
    std::uint64_t compressed = 0;
    const std::uint64_t most = data->mostBytes();
    for (const std::uint64_t size : blocks.compressed) {
        if (size > most || compressed > most - size) {
            return Error{ErrorCode::corrupt, data->name(), "its compressed blocks do not fit into the file"};
        }
        compressed += size;
    }
    if (blocks.bytes > mostInflated(compressed)) {
        return Error{ErrorCode::corrupt, data->name(),
                     fmt::format("{} bytes cannot come out of {} compressed ones", blocks.bytes, compressed)};
    }
    auto inflater = Inflater::make(Inflater::Form::zlib, data->name());
    if (!inflater) return inflater.error();
    return ByteStreamPtr(new BlockStream(std::move(data), std::move(blocks), std::move(inflater).value()));
}

}  // namespace mote::prep
