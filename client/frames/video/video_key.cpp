// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/video_key.h"

#include <fmt/format.h>

#include <fstream>

namespace mote::client {
namespace {

constexpr std::size_t keySize = 32;

}  // namespace

std::string videoTail(VideoFormat format, std::string_view key) {
    const auto text = fmt::format("mote-frames {}\n", key);
    switch (format) {
        case VideoFormat::mp4: {
            const std::size_t size = 8 + text.size();  // of the whole box, four bytes, then its kind
            return std::string{'\0', '\0', '\0', static_cast<char>(size)} + "free" + text;
        }
        case VideoFormat::webm:
            // The element's number, then its size in one byte, which is marked by its highest bit.
            return std::string{'\xec', static_cast<char>(0x80 | text.size())} + text;
        case VideoFormat::gif:
            return text;
    }
    return text;
}

std::optional<std::string> readVideoKey(const std::filesystem::path& path, VideoFormat format) {
    const auto size = static_cast<std::streamoff>(videoTail(format, std::string(keySize, '0')).size());
    std::ifstream file(path, std::ios::binary);
    file.seekg(-size, std::ios::end);
    std::string tail(static_cast<std::size_t>(size), '\0');
    file.read(tail.data(), size);
    if (!file.good()) return std::nullopt;
    auto key = tail.substr(tail.size() - 1 - keySize, keySize);
    if (videoTail(format, key) != tail) return std::nullopt;
    return key;
}

}  // namespace mote::client
