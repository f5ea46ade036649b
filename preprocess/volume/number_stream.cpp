// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/number_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr std::size_t bufferBytes = 256 * 1024;
constexpr std::size_t longestWord = 128;

bool separates(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',';
}

class NumberStream : public ForwardStream {
  public:
    explicit NumberStream(ByteStreamPtr text) : text_(std::move(text)), buffer_(bufferBytes) {}
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
                const auto more = nextNumber();
                if (!more) return more.error();
                if (!*more) break;
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
    /// Reads on until the buffer's first word is whole. False where there is none.
    Result<bool> nextNumber() {
        while (true) {
            while (begin_ < end_ && separates(buffer_[begin_])) ++begin_;
            std::size_t stop = begin_;
            while (stop < end_ && !separates(buffer_[stop]) && buffer_[stop] != '<') ++stop;
            const bool whole = stop < end_ || atEnd_;
            if (whole && stop == begin_) return false;
            if (whole || stop - begin_ > longestWord) return parse(stop);
            const auto filled = fill();
            if (!filled) return filled.error();
        }
    }

    Result<bool> parse(std::size_t stop) {
        const std::string_view word(buffer_.data() + begin_, stop - begin_);
        const auto number = parseNumber(word);
        if (!number) {
            return Error{ErrorCode::corrupt, name(),
                         fmt::format("has \"{}\" where a value should stand", word.substr(0, 20))};
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
        const auto got = text_->read(std::span(buffer_).subspan(end_));
        if (!got) return got.error();
        end_ += *got;
        atEnd_ = *got == 0;
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

ByteStreamPtr numberStream(ByteStreamPtr text) {
    return std::make_unique<NumberStream>(std::move(text));
}

}  // namespace mote::prep
