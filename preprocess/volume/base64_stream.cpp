// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/base64_stream.h"

#include <array>
#include <string_view>
#include <vector>

namespace mote::prep {
namespace {

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
                const auto more = nextGroup();
                if (!more) return more.error();
                if (!*more) break;
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
                const auto got = text_->read(buffer_);
                if (!got) return got.error();
                begin_ = 0;
                end_ = *got;
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

}  // namespace

ByteStreamPtr base64Stream(ByteStreamPtr text) {
    return std::make_unique<Base64Stream>(std::move(text));
}

}  // namespace mote::prep
