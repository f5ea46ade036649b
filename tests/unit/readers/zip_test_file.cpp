// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/readers/zip_test_file.h"

#include <zlib.h>

#include "tests/support/deflate.h"

namespace mote::test {
namespace {

template <class Number>
std::string le(Number value) {
    std::string bytes;
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
        bytes += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i));
    }
    return bytes;
}

std::uint32_t u32(std::size_t value) {
    return static_cast<std::uint32_t>(value);
}
std::uint16_t u16(std::size_t value) {
    return static_cast<std::uint16_t>(value);
}

}  // namespace

std::string rawDeflated(const std::string& bytes) {
    const std::string zlib = zlibDeflated(bytes);  // two bytes of header, four of checksum
    return zlib.substr(2, zlib.size() - 6);
}

void ZipTestFile::add(const std::string& name, const std::string& content, const Form& form) {
    const std::string stored = form.deflated ? rawDeflated(content) : content;
    const auto checksum = form.checksum.value_or(
        u32(crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()))));
    const std::uint16_t method = form.method.value_or(form.deflated ? 8 : 0);
    const std::uint16_t flags = form.flags.value_or(0);
    const std::uint32_t storedBytes = form.wide ? 0xffffffff : form.storedBytes.value_or(u32(stored.size()));
    const std::uint32_t bytes = form.wide ? 0xffffffff : form.bytes.value_or(u32(content.size()));
    const std::uint64_t offset = archive_.size();
    const std::string sizes = le<std::uint64_t>(form.bytes.value_or(u32(content.size()))) +
                              le<std::uint64_t>(form.storedBytes.value_or(u32(stored.size())));
    const std::string localExtra = form.wide ? le(u16(1)) + le(u16(16)) + sizes : "";
    // A field of another id before the one of zip64, as other writers have them.
    const std::string extra =
        form.wide ? le(u16(0x5455)) + le(u16(1)) + "t" + le(u16(1)) + le(u16(24)) + sizes + le(offset) : "";
    const std::string localName = form.localName.value_or(name);
    const std::string same = le(u16(20)) + le(flags) + le(method) + le(u16(0)) + le(u16(33)) + le(checksum) +
                             le(storedBytes) + le(bytes);
    archive_ += "PK\x03\x04" + same + le(u16(localName.size())) + le(u16(localExtra.size())) + localName +
                localExtra + stored;
    directory_ += "PK\x01\x02" + le(u16(20)) + same + le(u16(name.size())) + le(u16(extra.size())) +
                  le(u16(0)) + le(u16(0)) + le(u16(0)) + le(u32(0)) +
                  le(form.wide ? 0xffffffffu : form.offset.value_or(u32(offset))) + name + extra;
    ++entries_;
}

std::string ZipTestFile::bytes(bool wide, const std::string& comment) const {
    std::string result = archive_ + directory_;
    if (wide) {
        result += "PK\x06\x06" + le<std::uint64_t>(44) + le(u16(45)) + le(u16(45)) + le(u32(0)) + le(u32(0)) +
                  le<std::uint64_t>(entries_) + le<std::uint64_t>(entries_) +
                  le<std::uint64_t>(directory_.size()) + le<std::uint64_t>(archive_.size());
        result +=
            "PK\x06\x07" + le(u32(0)) + le<std::uint64_t>(archive_.size() + directory_.size()) + le(u32(1));
    }
    return result + "PK\x05\x06" + le(u16(0)) + le(u16(0)) + le(wide ? u16(0xffff) : entries_) +
           le(wide ? u16(0xffff) : entries_) + le(wide ? 0xffffffffu : u32(directory_.size())) +
           le(wide ? 0xffffffffu : u32(archive_.size())) + le(u16(comment.size())) + comment;
}

}  // namespace mote::test
