// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/ply_values.h"

#include <fmt/format.h>

namespace mote::prep {

bool PlyValues::mayHold(std::uint64_t count, StoredNumber type) const {
    const bool text = encoding_ == PlyEncoding::ascii;
    const std::size_t left =
        text ? bytes_.size() - text_.offset() + text_.restOfLine().size() : bytes_.size() - at_;
    return count <= left / (text ? 1 : bytesOf(type));
}

Error PlyValues::error(std::string message) const {
    if (encoding_ == PlyEncoding::ascii) return text_.error(std::move(message));
    return {ErrorCode::corrupt, fmt::format("{}: byte {}", name_, at_), std::move(message)};
}

Result<double> PlyValues::nextText() {
    const auto word = text_.wordAcrossLines();
    if (word.empty()) return error("ends before the values that its header says");
    const auto value = MeshText::number(word);
    if (!value) return error(fmt::format("\"{}\" is no number", word.substr(0, 40)));
    return *value;
}

Result<double> PlyValues::nextBinary(StoredNumber type) {
    const auto size = bytesOf(type);
    if (bytes_.size() - at_ < size) return error("ends before the values that its header says");
    at_ += size;
    return loadStored<double>(bytes_.data() + at_ - size, type, encoding_ == PlyEncoding::bigEndian);
}

}  // namespace mote::prep
