// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/picture_format.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "protocol/scene/system_error.h"
#include "storage/files/read_file.h"

namespace mote::prep {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t jpegLimit = std::size_t{1} << 30;  // bytes

struct Signature {
    std::string_view bytes;
    const char* format;
};
constexpr std::array<Signature, 7> signatures{{
    {"\x89PNG\r\n\x1a\n"sv, "png"},
    {"\xff\xd8\xff"sv, "jpeg"},
    {"II*\0"sv, "tiff"},
    {"MM\0*"sv, "tiff"},
    {"II+\0"sv, "tiff"},
    {"MM\0+"sv, "tiff"},
    {"\x76\x2f\x31\x01"sv, "openexr"},
}};

/// Whether an end-of-image marker stands where one may: not in a thumbnail within a segment (ITU T.81, B.1).
bool jpegHasEnd(std::string_view bytes) {
    std::size_t at = 2;
    while (at + 1 < bytes.size()) {
        const auto marker = static_cast<unsigned char>(bytes[at + 1]);
        if (bytes[at] != '\xff') {
            at = std::min(bytes.find('\xff', at), bytes.size());  // samples of a scan
        } else if (marker == 0xd9) {
            return true;
        } else if (marker == 0xff) {
            at += 1;  // fill
        } else if (marker == 0x00 || (marker >= 0xd0 && marker <= 0xd8) || marker == 0x01) {
            at += 2;  // without a segment
        } else {
            if (at + 3 >= bytes.size()) return false;
            at += 2 + (static_cast<unsigned char>(bytes[at + 2]) << 8) +
                  static_cast<unsigned char>(bytes[at + 3]);
        }
    }
    return false;
}

Result<std::string> firstBytes(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, storage::openRegular(path));
    std::string head(8, '\0');
    const auto got = ::pread(file.get(), head.data(), head.size(), 0);
    if (got < 0) return systemError(errno, path.string(), "cannot be read");
    head.resize(static_cast<std::size_t>(got));
    return head;
}

}  // namespace

Result<const char*> pictureFormat(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto head, firstBytes(path));
    if (head.empty()) return Error{ErrorCode::corrupt, path.string(), "is empty"};
    const auto found = std::find_if(signatures.begin(), signatures.end(), [&](const Signature& signature) {
        return std::string_view(head).starts_with(signature.bytes);
    });
    if (found == signatures.end()) {
        return Error{ErrorCode::unsupported, path.string(), "is no PNG, JPEG, TIFF or OpenEXR picture"};
    }
    if (found->format != "jpeg"sv) return found->format;
    MOTE_ASSIGN_OR_RETURN(const auto bytes, storage::readWhole(path, jpegLimit));
    if (jpegHasEnd(bytes)) return found->format;
    return Error{ErrorCode::corrupt, path.string(), "ends before its picture does"};
}

}  // namespace mote::prep
