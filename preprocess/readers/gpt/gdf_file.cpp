// SPDX-License-Identifier: GPL-3.0-or-later
//
// GDF, GPT's binary format: a header of 48 bytes, then blocks of a name (16 bytes), a type and a length, each
// with its data; blocks may open and close groups.
#include <algorithm>
#include <cstring>

#include "preprocess/readers/gpt/gdf_file.h"
#include "preprocess/readers/text/stored_number.h"

namespace mote::prep {
namespace {

constexpr std::size_t headerBytes = 48;
constexpr std::size_t nameBytes = 16;
constexpr std::size_t blockBytes = nameBytes + 8;
constexpr std::size_t maxDepth = 64;

constexpr std::uint32_t typeMask = 0xff, opens = 0x100, closes = 0x200, single = 0x400, array = 0x800;

/// A type's code in the file.
struct GdfNumber {
    std::uint32_t code;
    StoredNumber type;
};
constexpr GdfNumber gdfNumbers[] = {{0x20, StoredNumber::uint8},   {0x30, StoredNumber::int8},
                                    {0x40, StoredNumber::uint16},  {0x50, StoredNumber::int16},
                                    {0x02, StoredNumber::int32},   {0x60, StoredNumber::uint32},
                                    {0x70, StoredNumber::uint64},  {0x80, StoredNumber::int64},
                                    {0x90, StoredNumber::float32}, {0x03, StoredNumber::float64}};

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
        const auto* const known =
            std::find_if(std::begin(gdfNumbers), std::end(gdfNumbers),
                         [&](const GdfNumber& number) { return number.code == (type & typeMask); });
        if (known == std::end(gdfNumbers)) return success();  // text and the like
        const std::size_t width = bytesOf(known->type);
        const auto number = [&](std::size_t i) {
            return loadStored<double>(bytes_.data() + data + i * width, known->type, false);
        };
        if ((type & single) != 0 && size >= width) {
            if (name == "time") groups_.back().time = number(0);
            return success();
        }
        if ((type & array) == 0) return success();
        if (size % width != 0) return corrupt(data, "has an array that ends within a number");
        MOTE_RETURN_IF_ERROR(held_.add(size / width, name_));
        std::vector<double> values(size / width);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(i);
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

Result<std::vector<GptBlock>> readGdf(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto bytes, file.text());
    const std::string name = file.name();
    return GdfParser(bytes, name, file.held).run();
}

}  // namespace mote::prep
