// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/byte_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

namespace mote::prep {
namespace {

// A bit of deflate data gives at most 258 bytes, two of them being the least for that (RFC 1951).
constexpr std::uint64_t deflateRatio = 1032;
constexpr std::size_t skipBytes = 256 * 1024;

class PlainFile : public ByteStream {
  public:
    explicit PlainFile(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}
    std::string name() const override { return source_->name(); }
    bool sequential() const override { return false; }
    std::optional<std::uint64_t> size() const override { return source_->fileBytes(); }
    std::uint64_t mostBytes() const override { return source_->fileBytes(); }
    Result<std::size_t> read(std::span<char> bytes) override { return source_->read(bytes); }
    Status seek(std::uint64_t offset) override { return source_->seek(offset); }

  private:
    std::unique_ptr<ByteSource> source_;
};

class GzipFile : public ForwardStream {
  public:
    explicit GzipFile(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}
    std::string name() const override { return source_->name(); }
    std::uint64_t mostBytes() const override { return mostInflated(source_->fileBytes()); }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override { return source_->read(bytes); }
    Status restart() override { return source_->seek(0); }

  private:
    std::unique_ptr<ByteSource> source_;
};

class PartStream : public ByteStream {
  public:
    PartStream(ByteStreamPtr whole, std::uint64_t begin, std::uint64_t length)
        : whole_(std::move(whole)), begin_(begin), length_(length) {}
    std::string name() const override { return whole_->name(); }
    bool sequential() const override { return whole_->sequential(); }
    std::optional<std::uint64_t> size() const override {
        if (!whole_->size()) return std::nullopt;
        return mostBytes();
    }
    std::uint64_t mostBytes() const override {
        return std::min(whole_->mostBytes() - std::min(begin_, whole_->mostBytes()), length_);
    }
    Result<std::size_t> read(std::span<char> bytes) override {
        const auto left = static_cast<std::size_t>(std::min<std::uint64_t>(length_ - at_, bytes.size()));
        auto got = whole_->read(bytes.first(left));
        if (got) at_ += *got;
        return got;
    }
    Status seek(std::uint64_t offset) override {
        at_ = std::min(offset, length_);
        return whole_->seek(begin_ + at_);
    }

  private:
    ByteStreamPtr whole_;
    std::uint64_t begin_, length_, at_ = 0;
};

class InflatedStream : public ForwardStream {
  public:
    InflatedStream(ByteStreamPtr compressed, std::unique_ptr<Inflater> inflater)
        : compressed_(std::move(compressed)), inflater_(std::move(inflater)) {}
    std::string name() const override { return compressed_->name(); }
    std::uint64_t mostBytes() const override { return mostInflated(compressed_->mostBytes()); }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        return inflater_->read(bytes, [this](std::span<char> input) { return compressed_->read(input); });
    }
    Status restart() override {
        MOTE_RETURN_IF_ERROR(compressed_->seek(0));
        return inflater_->reset();
    }

  private:
    ByteStreamPtr compressed_;
    std::unique_ptr<Inflater> inflater_;
};

constexpr std::size_t bufferBytes = 256 * 1024;
constexpr int padding = 64, blank = 65, wrong = 66;

constexpr std::array<std::uint8_t, 256> makeTable() {
    std::array<std::uint8_t, 256> table{};
    table.fill(wrong);
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < digits.size(); ++i) {
        table[static_cast<std::uint8_t>(digits[i])] = static_cast<std::uint8_t>(i);
    }
    for (const char c : std::string_view(" \t\r\n")) table[static_cast<std::uint8_t>(c)] = blank;
    table['='] = padding;
    return table;
}
constexpr auto meanings = makeTable();

class Base64Stream : public ForwardStream {
  public:
    explicit Base64Stream(ByteStreamPtr text) : text_(std::move(text)), buffer_(bufferBytes) {}
    std::string name() const override { return text_->name(); }
    std::uint64_t mostBytes() const override { return (text_->mostBytes() / 4 + 1) * 3; }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            if (used_ == ready_) {
                MOTE_ASSIGN_OR_RETURN(const auto more, nextGroup());
                if (!more) break;
                continue;
            }
            bytes[done++] = group_[used_++];
        }
        return done;
    }

    Status restart() override {
        begin_ = end_ = used_ = ready_ = 0;
        return text_->seek(0);
    }

  private:
    /// Decodes four characters to one, two or three bytes. False at the end of the text.
    Result<bool> nextGroup() {
        std::uint32_t bits = 0;
        std::size_t digits = 0, pads = 0;
        while (digits + pads < 4) {
            if (begin_ == end_) {
                MOTE_ASSIGN_OR_RETURN(const auto got, text_->read(buffer_));
                begin_ = 0;
                end_ = got;
            }
            if (begin_ == end_ || buffer_[begin_] == '<') {
                if (digits + pads == 0) return false;
                return corrupt("ends in the middle of its base64 text");
            }
            const std::uint8_t meaning = meanings[static_cast<std::uint8_t>(buffer_[begin_++])];
            if (meaning == blank) continue;
            if (meaning == wrong || (meaning == padding ? digits < 2 : pads > 0)) {
                return corrupt("has a character in its base64 text that means nothing there");
            }
            bits = bits << 6 | (meaning == padding ? 0u : meaning);
            ++(meaning == padding ? pads : digits);
        }
        group_ = {static_cast<char>(bits >> 16), static_cast<char>(bits >> 8), static_cast<char>(bits)};
        used_ = 0;
        ready_ = digits - 1;
        return true;
    }

    Error corrupt(std::string message) const { return {ErrorCode::corrupt, name(), std::move(message)}; }

    ByteStreamPtr text_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;   // of the text that is not yet decoded
    std::array<char, 3> group_{};       // what the last four characters stand for
    std::size_t used_ = 0, ready_ = 0;  // bytes of it: handed out, there in all
};

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
            MOTE_ASSIGN_OR_RETURN(const auto got,
                                  inflate(bytes.subspan(done, static_cast<std::size_t>(left))));
            if (got == 0) {
                return Error{ErrorCode::corrupt, name(),
                             fmt::format("block {} holds less than it should", at_ / blocks_.blockBytes)};
            }
            done += got;
            at_ += got;
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
            MOTE_ASSIGN_OR_RETURN(
                const auto got,
                inflate(std::span(skipped).first(std::min<std::size_t>(skipped.size(), within))));
            if (got == 0) return Error{ErrorCode::corrupt, name(), "a block holds less than it should"};
            within -= got;
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
        MOTE_ASSIGN_OR_RETURN(const auto got, inflate(one));
        if (got == 0) return success();
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

std::uint64_t mostInflated(std::uint64_t bytes) {
    return bytes > std::numeric_limits<std::uint64_t>::max() / deflateRatio
               ? std::numeric_limits<std::uint64_t>::max()
               : bytes * deflateRatio;
}

Result<std::size_t> ForwardStream::read(std::span<char> bytes) {
    auto got = next(bytes);
    if (got) position_ += *got;
    return got;
}

Status ForwardStream::seek(std::uint64_t offset) {
    if (offset < position_) {
        MOTE_RETURN_IF_ERROR(restart());
        position_ = 0;
    }
    std::vector<char> skipped(
        static_cast<std::size_t>(std::min<std::uint64_t>(offset - position_, skipBytes)));
    while (position_ < offset) {
        const auto left = std::min<std::uint64_t>(offset - position_, skipped.size());
        MOTE_ASSIGN_OR_RETURN(const auto got, read(std::span(skipped).first(static_cast<std::size_t>(left))));
        if (got == 0) break;
    }
    return success();
}

Result<ByteStreamPtr> fileStream(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto source, ByteSource::open(path));
    if (source->compressed()) return ByteStreamPtr(new GzipFile(std::move(source)));
    return ByteStreamPtr(new PlainFile(std::move(source)));
}

Result<ByteStreamPtr> partStream(ByteStreamPtr whole, std::uint64_t begin,
                                 std::optional<std::uint64_t> length) {
    const std::uint64_t rest = std::numeric_limits<std::uint64_t>::max() - begin;
    ByteStreamPtr part(new PartStream(std::move(whole), begin, std::min(length.value_or(rest), rest)));
    MOTE_RETURN_IF_ERROR(part->seek(0));
    return part;
}

Result<ByteStreamPtr> inflatedStream(ByteStreamPtr compressed, Inflater::Form form) {
    MOTE_ASSIGN_OR_RETURN(auto inflater, Inflater::make(form, compressed->name()));
    return ByteStreamPtr(new InflatedStream(std::move(compressed), std::move(inflater)));
}

Result<std::string> readHead(ByteStream& stream, std::size_t limit) {
    std::string head(static_cast<std::size_t>(std::min<std::uint64_t>(stream.mostBytes(), limit)), '\0');
    MOTE_RETURN_IF_ERROR(stream.seek(0));
    MOTE_ASSIGN_OR_RETURN(const auto got, stream.read(head));
    head.resize(got);
    return head;
}

ByteStreamPtr base64Stream(ByteStreamPtr text) {
    return std::make_unique<Base64Stream>(std::move(text));
}

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
    MOTE_ASSIGN_OR_RETURN(auto inflater, Inflater::make(Inflater::Form::zlib, data->name()));
    return ByteStreamPtr(new BlockStream(std::move(data), std::move(blocks), std::move(inflater)));
}

}  // namespace mote::prep
