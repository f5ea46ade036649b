// SPDX-License-Identifier: GPL-3.0-or-later
//
// GDF, GPT's binary format: a header of 48 bytes, then blocks of a name (16 bytes), a type and a length, each
// with its data; blocks may open and close groups.
#include <algorithm>
#include <bit>
#include <cstring>

#include "preprocess/readers/gpt/gpt_table.h"

namespace mote::prep {
namespace {

constexpr std::size_t headerBytes = 48;
constexpr std::size_t nameBytes = 16;
constexpr std::size_t blockBytes = nameBytes + 8;
constexpr std::size_t maxDepth = 64;

constexpr std::uint32_t typeMask = 0xff, opens = 0x100, closes = 0x200, single = 0x400, array = 0x800;

/// Bytes of a number of a type; 0 for those that are no numbers.
std::size_t widthOf(std::uint32_t type) {
    switch (type & typeMask) {
        case 0x20:  // u8
        case 0x30:
            return 1;
        case 0x40:  // u16
        case 0x50:
            return 2;
        case 0x02:  // s32
        case 0x60:  // u32
        case 0x90:  // f32
            return 4;
        case 0x03:  // f64
        case 0x70:  // u64
        case 0x80:
            return 8;
        default:
            return 0;
    }
}

template <class Number>
double as(const char* at) {
    Number number{};
    std::memcpy(&number, at, sizeof(Number));
    return static_cast<double>(number);
}

double numberAt(std::uint32_t type, const char* at) {
    switch (type & typeMask) {
        case 0x20:
            return as<std::uint8_t>(at);
        case 0x30:
            return as<std::int8_t>(at);
        case 0x40:
            return as<std::uint16_t>(at);
        case 0x50:
            return as<std::int16_t>(at);
        case 0x02:
            return as<std::int32_t>(at);
        case 0x60:
            return as<std::uint32_t>(at);
        case 0x70:
            return as<std::uint64_t>(at);
        case 0x80:
            return as<std::int64_t>(at);
        case 0x90:
            return as<float>(at);
        default:
            return as<double>(at);
    }
}

class GdfParser {
  public:
    GdfParser(std::string_view bytes, const std::string& name, HeldNumbers& held)
        : bytes_(bytes), name_(name), held_(held) {}

    Result<std::vector<GptBlock>> run() {
        if (bytes_.size() < headerBytes) return corrupt(0, "is cut short in its header");
        groups_.push_back({});
        for (std::size_t at = headerBytes; at < bytes_.size();) {
            // GPT ends a file that it was stopped at within a block.
            if (bytes_.size() - at < blockBytes) return corrupt(at, "is cut short in a block");
            const auto type = word(at + nameBytes), size = word(at + nameBytes + 4);
            const std::size_t data = at + blockBytes;
            if (size > bytes_.size() - data)
                return corrupt(at, "has a block of " + std::to_string(size) + " bytes, more than there are");
            const char* name = bytes_.data() + at;
            MOTE_RETURN_IF_ERROR(block(std::string(name, strnlen(name, nameBytes)), type, data, size));
            at = data + size;
        }
        while (!groups_.empty()) leave();
        return std::move(blocks_);
    }

  private:
    Error corrupt(std::size_t at, std::string message) const {
        return {ErrorCode::corrupt, name_ + ": byte " + std::to_string(at), std::move(message)};
    }

    std::uint32_t word(std::size_t at) const {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }

    Status block(const std::string& name, std::uint32_t type, std::size_t data, std::size_t size) {
        if ((type & closes) != 0) {
            if (groups_.size() > 1) leave();
            return success();
        }
        if ((type & opens) != 0) {
            if (groups_.size() > maxDepth) return corrupt(data, "has groups deeper than 64");
            groups_.push_back({});
        }
        const std::size_t width = widthOf(type);
        if (width == 0) return success();
        if ((type & single) != 0 && size >= width) {
            if (name == "time") groups_.back().time = numberAt(type, bytes_.data() + data);
            return success();
        }
        if ((type & array) == 0) return success();
        if (size % width != 0) return corrupt(data, "has an array that ends within a number");
        MOTE_RETURN_IF_ERROR(held_.add(size / width, name_));
        std::vector<double> values(size / width);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = numberAt(type, bytes_.data() + data + i * width);
        groups_.back().names.push_back(name);
        groups_.back().values.push_back(std::move(values));
        return success();
    }

    /// A group becomes a step where it has places.
    void leave() {
        GptBlock group = std::move(groups_.back());
        groups_.pop_back();
        const bool places = std::find(group.names.begin(), group.names.end(), "x") != group.names.end();
        if (places) blocks_.push_back(std::move(group));
    }

    std::string_view bytes_;
    const std::string& name_;
    HeldNumbers& held_;
    std::vector<GptBlock> groups_;  // those that are open, the root first
    std::vector<GptBlock> blocks_;
};

}  // namespace

Result<std::vector<GptBlock>> readGdf(const std::filesystem::path& path, HeldNumbers& held) {
    static_assert(std::endian::native == std::endian::little);
    MOTE_ASSIGN_OR_RETURN(const auto bytes, readText(path));
    const std::string name = path.filename().string();
    return GdfParser(bytes, name, held).run();
}

}  // namespace mote::prep
