// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/packed_stream.h"

#include <bzlib.h>

#include <algorithm>
#include <limits>

namespace mote::prep {
namespace {

constexpr std::size_t packedBuffer = 256 * 1024;
// Blocks of 900,000 bytes, of which runs of 255 are five bytes before they are packed, take 32 bytes at
// least.
constexpr std::uint64_t bzip2Ratio = 900'000 / 5 * 255 / 32;

class Bzip2Stream : public ForwardStream {
  public:
    explicit Bzip2Stream(ByteStreamPtr compressed)
        : compressed_(std::move(compressed)), input_(packedBuffer) {}
    ~Bzip2Stream() override { end(); }
    Bzip2Stream(const Bzip2Stream&) = delete;
    Bzip2Stream& operator=(const Bzip2Stream&) = delete;

    std::string name() const override { return compressed_->name(); }
    std::uint64_t mostBytes() const override {
        const auto bytes = compressed_->mostBytes();
        constexpr auto most = std::numeric_limits<std::uint64_t>::max();
        return bytes > most / bzip2Ratio ? most : bytes * bzip2Ratio;
    }

    Status begin() {
        stream_ = {};
        open_ = BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK;
        return open_ ? success() : Status(Error{ErrorCode::internal, name(), "bzip2 could not be started"});
    }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size() && !finished_) {
            if (left_ == 0) {
                MOTE_ASSIGN_OR_RETURN(left_, compressed_->read(input_));
                at_ = 0;
                if (left_ == 0) {
                    if (betweenMembers_) break;
                    return corrupt("ends in the middle of its bzip2 data");
                }
            }
            if (betweenMembers_ && members_ > 0 && input_[at_] != 'B') break;
            MOTE_RETURN_IF_ERROR(step(bytes, done));
        }
        finished_ = finished_ || done < bytes.size();
        return done;
    }

    Status restart() override {
        MOTE_RETURN_IF_ERROR(compressed_->seek(0));
        left_ = at_ = members_ = 0;
        betweenMembers_ = true;
        finished_ = false;
        end();
        return begin();
    }

  private:
    Status step(std::span<char> bytes, std::size_t& done) {
        const auto piece = std::min<std::size_t>(bytes.size() - done, 1u << 30);
        stream_.next_in = input_.data() + at_;
        stream_.avail_in = static_cast<unsigned>(left_);
        stream_.next_out = bytes.data() + done;
        stream_.avail_out = static_cast<unsigned>(piece);
        const int code = BZ2_bzDecompress(&stream_);
        betweenMembers_ = false;
        at_ += left_ - stream_.avail_in;
        left_ = stream_.avail_in;
        done += piece - stream_.avail_out;
        if (code == BZ_OK) return success();
        if (code != BZ_STREAM_END) return corrupt("has damaged bzip2 data");
        ++members_;
        betweenMembers_ = true;
        end();
        return begin();
    }

    void end() {
        if (open_) BZ2_bzDecompressEnd(&stream_);
        open_ = false;
    }

    Error corrupt(std::string message) const { return {ErrorCode::corrupt, name(), std::move(message)}; }

    ByteStreamPtr compressed_;
    std::vector<char> input_;
    std::size_t at_ = 0, left_ = 0;  // of input_
    bz_stream stream_{};
    bool open_ = false, betweenMembers_ = true, finished_ = false;
    std::size_t members_ = 0;
};

int digitOf(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

class HexStream : public ForwardStream {
  public:
    explicit HexStream(ByteStreamPtr text) : text_(std::move(text)), buffer_(packedBuffer) {}
    std::string name() const override { return text_->name(); }
    std::uint64_t mostBytes() const override { return text_->mostBytes() / 2; }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            MOTE_ASSIGN_OR_RETURN(const int high, nextDigit());
            if (high < 0) break;
            MOTE_ASSIGN_OR_RETURN(const int low, nextDigit());
            if (low < 0) return Error{ErrorCode::corrupt, name(), "ends with half a byte of its hex text"};
            bytes[done++] = static_cast<char>(high * 16 + low);
        }
        return done;
    }

    Status restart() override {
        begin_ = end_ = 0;
        return text_->seek(0);
    }

  private:
    /// -1 at the end of the text.
    Result<int> nextDigit() {
        for (;;) {
            if (begin_ == end_) {
                MOTE_ASSIGN_OR_RETURN(end_, text_->read(buffer_));
                begin_ = 0;
                if (end_ == 0) return -1;
            }
            const char c = buffer_[begin_++];
            if (const int digit = digitOf(c); digit >= 0) return digit;
            if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
            return Error{ErrorCode::corrupt, name(), "has a character in its hex text that is no digit"};
        }
    }

    ByteStreamPtr text_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;
};

}  // namespace

Result<ByteStreamPtr> bzip2Stream(ByteStreamPtr compressed) {
    auto stream = std::make_unique<Bzip2Stream>(std::move(compressed));
    MOTE_RETURN_IF_ERROR(stream->begin());
    return ByteStreamPtr(std::move(stream));
}

ByteStreamPtr hexStream(ByteStreamPtr text) {
    return std::make_unique<HexStream>(std::move(text));
}

}  // namespace mote::prep
