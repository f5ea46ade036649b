// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/zip_directory.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

// Names of the records are those of PKWARE's APPNOTE 6.3, sections 4.3 and 4.5.
constexpr std::uint32_t endSignature = 0x06054b50, end64Signature = 0x06064b50,
                        locator64Signature = 0x07064b50, entrySignature = 0x02014b50,
                        localSignature = 0x04034b50;
constexpr std::size_t endBytes = 22, end64Bytes = 56, locator64Bytes = 20, entryBytes = 46, localBytes = 30;
constexpr std::size_t maxComment = 0xffff;
constexpr std::uint64_t maxDirectoryBytes = 64u << 20;
constexpr std::uint16_t zip64Field = 1, encryptedFlag = 1, stored = 0, deflated = 8;
constexpr std::uint32_t elsewhere32 = 0xffffffff;
constexpr std::uint16_t elsewhere16 = 0xffff;
/// Deflate makes at most so many bytes of one.
constexpr std::uint64_t deflateRatio = 1032;

std::uint16_t load16(std::string_view bytes, std::size_t at) {
    return loadNumber<std::uint16_t>(bytes.data() + at, false);
}
std::uint32_t load32(std::string_view bytes, std::size_t at) {
    return loadNumber<std::uint32_t>(bytes.data() + at, false);
}
std::uint64_t load64(std::string_view bytes, std::size_t at) {
    return loadNumber<std::uint64_t>(bytes.data() + at, false);
}

/// Bytes [offset, offset + count) of the archive, which must lie within it.
Result<std::string> bytesAt(ByteSource& archive, std::uint64_t offset, std::uint64_t count) {
    if (offset > archive.fileBytes() || count > archive.fileBytes() - offset) {
        return corrupt(archive.name(), "is a zip archive that is cut short");
    }
    std::string bytes(static_cast<std::size_t>(count), '\0');
    MOTE_RETURN_IF_ERROR(archive.seek(offset));
    MOTE_ASSIGN_OR_RETURN(const auto got, archive.read(bytes));
    if (got != bytes.size()) return corrupt(archive.name(), "has changed since it was opened");
    return bytes;
}

/// Where the central directory lies.
struct Place {
    std::uint64_t offset = 0, bytes = 0, entries = 0;
    std::uint64_t end = 0;  ///< where the record begins that says so
};

/// The record of zip64 before the end record, where there is one.
Result<std::optional<Place>> zip64Place(ByteSource& archive, std::uint64_t endOffset) {
    if (endOffset < locator64Bytes) return std::optional<Place>();
    MOTE_ASSIGN_OR_RETURN(const auto locator, bytesAt(archive, endOffset - locator64Bytes, locator64Bytes));
    if (load32(locator, 0) != locator64Signature) return std::optional<Place>();
    const std::uint64_t offset = load64(locator, 8);
    MOTE_ASSIGN_OR_RETURN(const auto record, bytesAt(archive, offset, end64Bytes));
    if (load32(record, 0) != end64Signature) {
        return corrupt(archive.name(), "is a zip archive whose zip64 record is damaged");
    }
    if (load32(record, 16) != 0 || load32(record, 20) != 0) {
        return unsupported(archive.name(), "is one part of a split zip archive");
    }
    return std::optional(Place{load64(record, 48), load64(record, 40), load64(record, 32), offset});
}

Result<Place> findDirectory(ByteSource& archive) {
    const std::uint64_t tailBytes = std::min<std::uint64_t>(archive.fileBytes(), endBytes + maxComment);
    const std::uint64_t tailOffset = archive.fileBytes() - tailBytes;
    MOTE_ASSIGN_OR_RETURN(const auto tail, bytesAt(archive, tailOffset, tailBytes));
    for (std::size_t at = tail.size() < endBytes ? 0 : tail.size() - endBytes + 1; at-- > 0;) {
        if (load32(tail, at) != endSignature || load16(tail, at + 20) != tail.size() - at - endBytes)
            continue;
        const std::uint64_t endOffset = tailOffset + at;
        MOTE_ASSIGN_OR_RETURN(const auto wide, zip64Place(archive, endOffset));
        if (wide) return *wide;
        if (load16(tail, at + 4) != 0 || load16(tail, at + 6) != 0) {
            return unsupported(archive.name(), "is one part of a split zip archive");
        }
        return Place{load32(tail, at + 16), load32(tail, at + 12), load16(tail, at + 10), endOffset};
    }
    return corrupt(archive.name(), "is a zip archive that is cut short: its directory is missing");
}

/// The sizes and the offset that did not fit into 32 bits stand in an extra field, in this order.
Status takeZip64(std::string_view extra, ZipEntry& entry, std::uint64_t& localOffset,
                 const std::string& where) {
    const bool needed =
        entry.bytes == elsewhere32 || entry.storedBytes == elsewhere32 || localOffset == elsewhere32;
    if (!needed) return success();
    while (extra.size() >= 4) {
        const std::uint16_t id = load16(extra, 0);
        const std::size_t size = load16(extra, 2);
        if (size > extra.size() - 4) break;
        std::string_view field = extra.substr(4, size);
        extra.remove_prefix(4 + size);
        if (id != zip64Field) continue;
        for (std::uint64_t* value : {&entry.bytes, &entry.storedBytes, &localOffset}) {
            if (*value != elsewhere32) continue;
            if (field.size() < 8) return corrupt(where, "has a zip64 field that is cut short");
            *value = load64(field, 0);
            field.remove_prefix(8);
        }
        return success();
    }
    return corrupt(where, "needs a zip64 field and has none");
}

/// The entry's bytes lie behind its own header, whose length only that header says.
Status placeEntry(ByteSource& archive, ZipEntry& entry, std::uint64_t localOffset, std::uint64_t limit,
                  const std::string& where) {
    if (localOffset > limit || limit - localOffset < localBytes) {
        return corrupt(where, "lies outside the archive");
    }
    MOTE_ASSIGN_OR_RETURN(const auto header, bytesAt(archive, localOffset, localBytes));
    if (load32(header, 0) != localSignature) return corrupt(where, "does not begin where the archive says");
    MOTE_ASSIGN_OR_RETURN(const auto name, bytesAt(archive, localOffset + localBytes, load16(header, 26)));
    if (name != entry.name) return corrupt(where, "has another name in its own header");
    entry.offset = localOffset + localBytes + name.size() + load16(header, 28);
    if (entry.offset > limit || entry.storedBytes > limit - entry.offset) {
        return corrupt(where, "declares " + std::to_string(entry.storedBytes) +
                                  " bytes, which the archive does not hold");
    }
    const std::uint64_t most = entry.deflated ? entry.storedBytes * deflateRatio : entry.storedBytes;
    const bool overflows = entry.storedBytes > std::numeric_limits<std::uint64_t>::max() / deflateRatio;
    if (overflows || entry.bytes > most || (!entry.deflated && entry.bytes != entry.storedBytes)) {
        return corrupt(where, "declares " + std::to_string(entry.bytes) + " bytes, which its " +
                                  std::to_string(entry.storedBytes) + " stored ones cannot hold");
    }
    return success();
}

/// Reads the entry at the beginning of `directory` and steps over it.
Result<ZipEntry> takeEntry(ByteSource& archive, std::string_view& directory, std::uint64_t limit) {
    if (directory.size() < entryBytes || load32(directory, 0) != entrySignature) {
        return corrupt(archive.name(), "is a zip archive whose directory is damaged");
    }
    const std::size_t nameBytes = load16(directory, 28), extraBytes = load16(directory, 30);
    const std::size_t all = entryBytes + nameBytes + extraBytes + load16(directory, 32);
    if (all > directory.size()) {
        return corrupt(archive.name(), "is a zip archive whose directory is damaged");
    }
    ZipEntry entry;
    entry.name = directory.substr(entryBytes, nameBytes);
    const std::string where = archive.name() + ": " + entry.name;
    const std::uint16_t flags = load16(directory, 8), method = load16(directory, 10);
    if ((flags & encryptedFlag) != 0) return unsupported(where, "is encrypted");
    if (method != stored && method != deflated) {
        return unsupported(
            where, "is packed by method " + std::to_string(method) + "; stored and deflated ones are read");
    }
    entry.deflated = method == deflated;
    entry.checksum = load32(directory, 16);
    entry.storedBytes = load32(directory, 20);
    entry.bytes = load32(directory, 24);
    std::uint64_t localOffset = load32(directory, 42);
    MOTE_RETURN_IF_ERROR(
        takeZip64(directory.substr(entryBytes + nameBytes, extraBytes), entry, localOffset, where));
    MOTE_RETURN_IF_ERROR(placeEntry(archive, entry, localOffset, limit, where));
    directory.remove_prefix(all);
    return entry;
}

/// Entries that share bytes or a name make an archive that means different things to different readers.
Status checkDistinct(const std::vector<ZipEntry>& entries, const std::string& archive) {
    std::vector<const ZipEntry*> order;
    for (const ZipEntry& entry : entries) order.push_back(&entry);
    std::sort(order.begin(), order.end(),
              [](const ZipEntry* a, const ZipEntry* b) { return a->offset < b->offset; });
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (order[i]->offset - order[i - 1]->offset < order[i - 1]->storedBytes) {
            return corrupt(archive + ": " + order[i]->name, "overlaps another entry of the archive");
        }
    }
    std::sort(order.begin(), order.end(),
              [](const ZipEntry* a, const ZipEntry* b) { return a->name < b->name; });
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (order[i]->name == order[i - 1]->name) {
            return corrupt(archive + ": " + order[i]->name, "stands twice in the archive");
        }
    }
    return success();
}

}  // namespace

bool looksLikeZip(std::string_view begin) {
    return begin.starts_with("PK\x03\x04") || begin.starts_with("PK\x05\x06");
}

Result<std::vector<ZipEntry>> readZipDirectory(ByteSource& archive, std::uint64_t most) {
    MOTE_ASSIGN_OR_RETURN(const auto place, findDirectory(archive));
    if (place.entries > most || place.bytes > maxDirectoryBytes) {
        return Error{ErrorCode::resourceExhausted, archive.name(),
                     "holds more than " + std::to_string(most) + " files"};
    }
    if (place.offset > place.end || place.bytes > place.end - place.offset) {
        return corrupt(archive.name(), "is a zip archive whose directory lies outside it");
    }
    MOTE_ASSIGN_OR_RETURN(const auto bytes, bytesAt(archive, place.offset, place.bytes));
    std::string_view rest = bytes;
    std::vector<ZipEntry> entries;
    for (std::uint64_t i = 0; i < place.entries; ++i) {
        MOTE_ASSIGN_OR_RETURN(auto entry, takeEntry(archive, rest, place.offset));
        entries.push_back(std::move(entry));
    }
    if (!rest.empty()) {
        return corrupt(archive.name(), "is a zip archive with more in its directory than it counts");
    }
    MOTE_RETURN_IF_ERROR(checkDistinct(entries, archive.name()));
    return entries;
}

}  // namespace mote::prep
