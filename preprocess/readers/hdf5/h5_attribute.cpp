// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_attribute.h"

#include <cstring>

#include "preprocess/readers/hdf5/global_heap.h"

namespace mote::prep {
namespace {

constexpr hssize_t maxElements = 4096;
constexpr std::size_t maxTextBytes = 64 * 1024;

struct OpenAttribute {
    H5Handle attribute, type, space;
    hssize_t elements = 0;
    std::string where;
};

Error damaged(const std::string& where) {
    return {ErrorCode::corrupt, where, "the attribute cannot be read; the file is damaged"};
}

Result<std::optional<OpenAttribute>> openAttribute(const H5Object& object, const char* name) {
    const std::string where = object.where + "@" + name;
    const htri_t exists = H5Aexists(object.handle.get(), name);
    if (exists < 0) return damaged(where);
    if (exists == 0) return std::optional<OpenAttribute>();
    OpenAttribute open;
    open.where = where;
    open.attribute = H5Handle(H5Aopen(object.handle.get(), name, H5P_DEFAULT), H5Aclose);
    if (!open.attribute.ok()) return damaged(where);
    open.type = H5Handle(H5Aget_type(open.attribute.get()), H5Tclose);
    open.space = H5Handle(H5Aget_space(open.attribute.get()), H5Sclose);
    if (!open.type.ok() || !open.space.ok()) return damaged(where);
    open.elements = H5Sget_simple_extent_npoints(open.space.get());
    if (open.elements < 0) return damaged(where);
    if (open.elements > maxElements) {
        return Error{ErrorCode::unsupported, where, "has more than 4096 elements"};
    }
    return std::optional<OpenAttribute>(std::move(open));
}

std::string trimmed(const char* text, std::size_t limit) {
    std::string result(text, strnlen(text, limit));
    while (!result.empty() && (result.back() == ' ' || result.back() == '\0')) result.pop_back();
    return result;
}

Result<std::string> readFixedText(const OpenAttribute& open) {
    const std::size_t size = H5Tget_size(open.type.get());
    if (size == 0 || size > maxTextBytes) {
        return Error{ErrorCode::unsupported, open.where, "is a text of more than 64 KiB"};
    }
    std::vector<char> bytes(size * static_cast<std::size_t>(open.elements) + 1, '\0');
    if (H5Aread(open.attribute.get(), open.type.get(), bytes.data()) < 0) return damaged(open.where);
    return trimmed(bytes.data(), size);
}

}  // namespace

Result<std::optional<std::vector<double>>> numbersAttribute(const H5Object& object, const char* name) {
    auto open = openAttribute(object, name);
    if (!open) return open.error();
    if (!open->has_value()) return std::optional<std::vector<double>>();
    const OpenAttribute& attribute = **open;
    const H5T_class_t kind = H5Tget_class(attribute.type.get());
    if (kind != H5T_INTEGER && kind != H5T_FLOAT && kind != H5T_ENUM) {
        return Error{ErrorCode::unsupported, attribute.where, "is no number"};
    }
    std::vector<double> values(static_cast<std::size_t>(attribute.elements));
    if (!values.empty() && H5Aread(attribute.attribute.get(), H5T_NATIVE_DOUBLE, values.data()) < 0) {
        return damaged(attribute.where);
    }
    return std::optional<std::vector<double>>(std::move(values));
}

Result<std::optional<double>> numberAttribute(const H5Object& object, const char* name) {
    auto values = numbersAttribute(object, name);
    if (!values) return values.error();
    if (!values->has_value()) return std::optional<double>();
    if ((*values)->empty()) {
        return Error{ErrorCode::corrupt, object.where + "@" + name, "is empty where a number was expected"};
    }
    return std::optional<double>((**values)[0]);
}

Result<std::optional<std::string>> textAttribute(const H5Object& object, const char* name) {
    auto open = openAttribute(object, name);
    if (!open) return open.error();
    if (!open->has_value()) return std::optional<std::string>();
    const OpenAttribute& attribute = **open;
    if (H5Tget_class(attribute.type.get()) != H5T_STRING) {
        return Error{ErrorCode::unsupported, attribute.where, "is no text"};
    }
    if (attribute.elements == 0) return std::optional<std::string>("");
    auto text = H5Tis_variable_str(attribute.type.get()) > 0
                    ? readVariableText(attribute.attribute.get(),
                                       static_cast<std::size_t>(attribute.elements), attribute.where)
                    : readFixedText(attribute);
    if (!text) return text.error();
    return std::optional<std::string>(std::move(*text));
}

}  // namespace mote::prep
