// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_attribute.h"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// Texts of variable length, read from a file's global heap by our own code. HDF5's own (H5HG) believes the
// heap: in version 1.10 a changed index or size there makes it read anywhere in memory, or loop without end.
// Functions without state; the HDF5 library keeps one registration of theirs.

constexpr std::uint64_t maxTextBytes = std::uint64_t{64} * 1024;
constexpr std::uint64_t maxCollectionBytes = std::uint64_t{16} << 20;
constexpr int maxObjects = 65536;  // an object's index has 16 bits

Error damaged(const std::string& where) {
    return {ErrorCode::corrupt, where, "the text lies in a part of the file that is damaged"};
}

/// "Converts" elements of variable length into the bytes that stand for them in the file, which it has got
/// already.
herr_t keepBytes(hid_t from, hid_t to, H5T_cdata_t* data, size_t, size_t, size_t, void*, void*, hid_t) {
    if (data->command == H5T_CONV_INIT) data->need_bkg = H5T_BKG_NO;
    if (data->command != H5T_CONV_CONV) return 0;
    return H5Tget_size(from) == H5Tget_size(to) ? 0 : -1;
}

/// HDF5 has no other way to the bytes of an attribute than a conversion from its type to one of plain bytes.
bool registerConversion() {
    const H5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
    const H5Handle bytes(H5Tcreate(H5T_OPAQUE, 1), H5Tclose);
    return H5Tset_size(text.get(), H5T_VARIABLE) >= 0 &&
           H5Tregister(H5T_PERS_SOFT, "mote: bytes of variable length", text.get(), bytes.get(), keepBytes) >=
               0;
}

std::uint64_t littleEndian(std::span<const unsigned char> bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | bytes[i];
    return value;
}

/// What is needed to read the file past HDF5.
struct RawFile {
    int descriptor = -1;
    std::size_t addressBytes = 0, lengthBytes = 0;
    hsize_t base = 0;  // of addresses: the size of the user block

    bool read(std::uint64_t address, std::span<unsigned char> bytes) const {
        if (address > (1ull << 62)) return false;
        const ssize_t got = pread(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(address + base));
        return got == static_cast<ssize_t>(bytes.size());
    }
};

bool openRaw(hid_t attribute, RawFile& raw) {
    const H5Handle file(H5Iget_file_id(attribute), H5Fclose);
    const H5Handle creation(file.ok() ? H5Fget_create_plist(file.get()) : -1, H5Pclose);
    void* handle = nullptr;
    if (!creation.ok() || H5Pget_sizes(creation.get(), &raw.addressBytes, &raw.lengthBytes) < 0 ||
        H5Pget_userblock(creation.get(), &raw.base) < 0 ||
        H5Fget_vfd_handle(file.get(), H5P_DEFAULT, &handle) < 0 || handle == nullptr) {
        return false;
    }
    raw.descriptor = *static_cast<int*>(handle);  // the driver is always "sec2"
    return raw.addressBytes >= 2 && raw.addressBytes <= 8 && raw.lengthBytes >= 2 && raw.lengthBytes <= 8;
}

/// A collection: "GCOL", version, 3 bytes, its size; then objects, each with index, reference count, 4 bytes,
/// size and data, all in steps of 8 bytes. Index 0 is the free space at the end.
Result<std::string> readObject(const RawFile& raw, std::uint64_t address, std::uint64_t index,
                               std::uint64_t length, const std::string& where) {
    const std::size_t headerBytes = 8 + raw.lengthBytes;
    std::array<unsigned char, 16> header{};
    if (!raw.read(address, std::span(header).first(headerBytes)) ||
        std::memcmp(header.data(), "GCOL\x01", 5) != 0) {
        return damaged(where);
    }
    const std::uint64_t size = littleEndian(std::span(header).subspan(8, raw.lengthBytes));
    if (size < headerBytes || size > maxCollectionBytes) return damaged(where);
    std::uint64_t at = headerBytes;
    for (int i = 0; i < maxObjects && at + headerBytes <= size; ++i) {
        if (!raw.read(address + at, std::span(header).first(headerBytes))) return damaged(where);
        const std::uint64_t found = littleEndian(std::span(header).first(2));
        const std::uint64_t bytes = littleEndian(std::span(header).subspan(8, raw.lengthBytes));
        if (found == 0 || bytes > size - at - headerBytes) return damaged(where);
        if (found == index) {
            std::vector<unsigned char> text(std::min({length, bytes, maxTextBytes}));
            if (!raw.read(address + at + headerBytes, text)) return damaged(where);
            return std::string(text.begin(), std::find(text.begin(), text.end(), '\0'));
        }
        at += headerBytes + (bytes + 7) / 8 * 8;
    }
    return damaged(where);
}

/// An element of an attribute whose type is text of variable length, at most 64 KiB of it. Errors, at
/// `where`: corrupt.
Result<std::string> readVariableText(hid_t attribute, std::size_t elements, std::size_t index,
                                     const std::string& where) {
    static const bool registered = registerConversion();
    RawFile raw;
    if (!registered || !openRaw(attribute, raw)) return damaged(where);
    // Length, address of the collection, index in it.
    const std::size_t elementBytes = 4 + raw.addressBytes + 4;
    const H5Handle memory(H5Tcreate(H5T_OPAQUE, elementBytes), H5Tclose);
    std::vector<unsigned char> bytes(elementBytes * elements);
    if (elements == 0 || !memory.ok() || H5Aread(attribute, memory.get(), bytes.data()) < 0)
        return damaged(where);
    const std::span<const unsigned char> element =
        std::span(bytes).subspan(index * elementBytes, elementBytes);
    const std::uint64_t length = littleEndian(element.first(4));
    if (length == 0) return std::string();
    return readObject(raw, littleEndian(element.subspan(4, raw.addressBytes)),
                      littleEndian(element.subspan(4 + raw.addressBytes, 4)), length, where);
}

constexpr hssize_t maxElements = 4096, maxTexts = 16;

struct OpenAttribute {
    H5Handle attribute, type, space;
    hssize_t elements = 0;
    std::string where;
};

Error unreadable(const std::string& where) {
    return {ErrorCode::corrupt, where, "the attribute cannot be read; the file is damaged"};
}

Result<std::optional<OpenAttribute>> openAttribute(const H5Object& object, const char* name) {
    const std::string where = object.where + "@" + name;
    const htri_t exists = H5Aexists(object.handle.get(), name);
    if (exists < 0) return unreadable(where);
    if (exists == 0) return std::optional<OpenAttribute>();
    OpenAttribute open;
    open.where = where;
    open.attribute = H5Handle(H5Aopen(object.handle.get(), name, H5P_DEFAULT), H5Aclose);
    if (!open.attribute.ok()) return unreadable(where);
    open.type = H5Handle(H5Aget_type(open.attribute.get()), H5Tclose);
    open.space = H5Handle(H5Aget_space(open.attribute.get()), H5Sclose);
    if (!open.type.ok() || !open.space.ok()) return unreadable(where);
    open.elements = H5Sget_simple_extent_npoints(open.space.get());
    if (open.elements < 0) return unreadable(where);
    if (open.elements > maxElements) {
        return unsupported(where, "has more than 4096 elements");
    }
    return std::optional<OpenAttribute>(std::move(open));
}

std::string trimmed(const char* text, std::size_t limit) {
    std::string result(text, strnlen(text, limit));
    while (!result.empty() && (result.back() == ' ' || result.back() == '\0')) result.pop_back();
    return result;
}

Result<std::string> readFixedText(const OpenAttribute& open, std::size_t index) {
    const std::size_t size = H5Tget_size(open.type.get());
    if (size == 0 || size > maxTextBytes) {
        return unsupported(open.where, "is a text of more than 64 KiB");
    }
    std::vector<char> bytes(size * static_cast<std::size_t>(open.elements) + 1, '\0');
    if (H5Aread(open.attribute.get(), open.type.get(), bytes.data()) < 0) return unreadable(open.where);
    return trimmed(bytes.data() + index * size, size);
}

/// One of its texts, of either kind.
Result<std::string> readText(const OpenAttribute& open, std::size_t index) {
    const auto elements = static_cast<std::size_t>(open.elements);
    if (H5Tis_variable_str(open.type.get()) > 0)
        return readVariableText(open.attribute.get(), elements, index, open.where);
    return readFixedText(open, index);
}

}  // namespace

Result<std::optional<std::vector<double>>> numbersAttribute(const H5Object& object, const char* name) {
    MOTE_ASSIGN_OR_RETURN(auto open, openAttribute(object, name));
    if (!open.has_value()) return std::optional<std::vector<double>>();
    const OpenAttribute& attribute = *open;
    const H5T_class_t kind = H5Tget_class(attribute.type.get());
    if (kind != H5T_INTEGER && kind != H5T_FLOAT && kind != H5T_ENUM) {
        return unsupported(attribute.where, "is no number");
    }
    std::vector<double> values(static_cast<std::size_t>(attribute.elements));
    if (!values.empty() && H5Aread(attribute.attribute.get(), H5T_NATIVE_DOUBLE, values.data()) < 0) {
        return unreadable(attribute.where);
    }
    return std::optional<std::vector<double>>(std::move(values));
}

Result<std::optional<double>> numberAttribute(const H5Object& object, const char* name) {
    MOTE_ASSIGN_OR_RETURN(auto values, numbersAttribute(object, name));
    if (!values.has_value()) return std::optional<double>();
    if (values->empty()) {
        return corrupt(object.where + "@" + name, "is empty where a number was expected");
    }
    return std::optional<double>((*values)[0]);
}

Result<std::optional<std::string>> textAttribute(const H5Object& object, const char* name) {
    MOTE_ASSIGN_OR_RETURN(auto open, openAttribute(object, name));
    if (!open.has_value()) return std::optional<std::string>();
    const OpenAttribute& attribute = *open;
    if (H5Tget_class(attribute.type.get()) != H5T_STRING) {
        return unsupported(attribute.where, "is no text");
    }
    if (attribute.elements == 0) return std::optional<std::string>("");
    MOTE_ASSIGN_OR_RETURN(auto text, readText(attribute, 0));
    return std::optional<std::string>(std::move(text));
}

Result<std::optional<std::vector<std::string>>> textsAttribute(const H5Object& object, const char* name) {
    MOTE_ASSIGN_OR_RETURN(auto open, openAttribute(object, name));
    if (!open.has_value()) return std::optional<std::vector<std::string>>();
    if (H5Tget_class(open->type.get()) != H5T_STRING) {
        return unsupported(open->where, "is no text");
    }
    if (open->elements > maxTexts) return unsupported(open->where, "has more than 16 texts");
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < static_cast<std::size_t>(open->elements); ++i) {
        MOTE_ASSIGN_OR_RETURN(auto text, readText(*open, i));
        texts.push_back(std::move(text));
    }
    return std::optional(std::move(texts));
}

}  // namespace mote::prep
