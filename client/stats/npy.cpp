// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/npy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "protocol/base/utf8.h"

namespace mote::client {
namespace {

constexpr std::string_view magic("\x93NUMPY\x01\x00", 8);
constexpr std::size_t alignment = 64;
constexpr std::size_t longestHead = 0xffff;

/// A Python string. Beyond ASCII by its bytes' Latin-1 letters would be wrong: so each letter is escaped.
std::string pythonString(std::string_view text) {
    std::string result = "'";
    while (!text.empty()) {
        const auto length = characterLength(text);
        const auto first = static_cast<unsigned char>(text.front());
        if (length <= 1) {
            const bool plain = length == 1 && first >= 0x20 && first < 0x7f && first != '\'' && first != '\\';
            result += plain ? std::string(1, text.front()) : fmt::format("\\x{:02x}", first);
        } else {
            std::uint32_t letter = first & (0xFFU >> (length + 1));
            for (std::size_t i = 1; i < length; ++i)
                letter = letter << 6U | (static_cast<unsigned char>(text[i]) & 0x3FU);
            result += fmt::format("\\U{:08x}", letter);
        }
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return result + "'";
}

/// Everything before the values; padded to `size` where it is over 0.
std::string headOf(const std::string& type, const std::string& shape, std::size_t size) {
    const auto text = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", type, shape);
    const auto plain = magic.size() + 2 + text.size() + 1;
    if (size == 0) size = (plain + alignment - 1) / alignment * alignment;
    const auto length = static_cast<std::uint16_t>(size - magic.size() - 2);
    std::string head(magic);
    head += static_cast<char>(length & 0xFFU);
    head += static_cast<char>(length >> 8U);
    head += text;
    head.append(size - plain, ' ');
    return head + '\n';
}

std::string typeOf(const std::vector<NpyField>& fields) {
    std::vector<std::string> parts;
    for (const auto& field : fields) {
        const auto name = pythonString(field.name);
        const auto titled = fmt::format("({}, {})", pythonString(field.title), name);
        parts.push_back(fmt::format("({}, '{}')", field.title.empty() ? name : titled, field.type));
    }
    return fmt::format("[{}]", fmt::join(parts, ", "));
}

std::string rowShape(std::uint64_t rows) {
    return fmt::format("({},)", rows);
}

std::string rowsHead(const std::vector<NpyField>& fields, std::uint64_t rows) {
    const auto type = typeOf(fields);
    // As long whatever the number of rows.
    const auto size = headOf(type, rowShape(~std::uint64_t{0}), 0).size();
    return headOf(type, rowShape(rows), size);
}

}  // namespace

std::string npyHead(const std::vector<std::size_t>& shape) {
    return headOf("'<f8'", fmt::format("({},)", fmt::join(shape, ", ")), 0);
}

Result<NpyRows> NpyRows::create(const std::filesystem::path& path, const std::vector<NpyField>& fields) {
    if (typeOf(fields).size() > longestHead - 256) {
        return Error{ErrorCode::resourceExhausted, path.string(),
                     "cannot hold so many columns: choose some with --columns"};
    }
    MOTE_ASSIGN_OR_RETURN(auto part, PartFile::create(path));
    NpyRows rows(std::move(part), fields);
    const auto head = rowsHead(fields, 0);
    MOTE_RETURN_IF_ERROR(rows.file_->append(bytesOf(std::span<const char>(head))));
    return rows;
}

Status NpyRows::append(std::span<const std::uint64_t> words) {
    words_ += words.size();
    return file_->append(bytesOf(words));
}

Status NpyRows::publish() {
    const auto head = rowsHead(fields_, words_ / fields_.size());
    MOTE_RETURN_IF_ERROR(file_->overwrite(0, bytesOf(std::span<const char>(head))));
    return file_->publish();
}

}  // namespace mote::client
