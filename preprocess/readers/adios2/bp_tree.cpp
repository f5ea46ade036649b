// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/adios2/bp_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <optional>
#include <set>
#include <system_error>
#include <type_traits>

namespace mote::prep {
namespace {

constexpr std::size_t mostPathBytes = 4096, mostDepth = 32, mostTextBytes = 65536;
constexpr std::uint64_t bpRatio = 65536;  // bzip2 makes some 20,000 zeros a byte
constexpr std::uint64_t windowValues = 1 << 20;

Error bpError(const std::string& where, const std::string& why) {
    // ADIOS2 is packaged with some of its compressors alone.
    if (why.find("didn't compile with") != std::string::npos)
        return unsupported(where, why + "; convert it with openpmd-pipe where that ADIOS2 is");
    return corrupt(where, why);
}

Error refusedBpTree(const std::string& where) {
    return corrupt(where,
                   "is a name that stands below a variable, or of no possible size; the file is damaged");
}

/// "/data/100/time" of "data//100/time"; nothing of what is ADIOS2's or openPMD-api's own, and of what is no
/// path.
std::optional<std::string> cleanBpPath(std::string_view name) {
    if (name.size() > mostPathBytes || name.find('\0') != std::string_view::npos) return std::nullopt;
    std::string path;
    std::size_t depth = 0;
    while (!name.empty()) {
        const auto slash = std::min(name.find('/'), name.size());
        const auto part = name.substr(0, slash);
        name.remove_prefix(std::min(slash + 1, name.size()));
        if (part.empty()) continue;
        if (part == "." || part == ".." || ++depth > mostDepth) return std::nullopt;
        if (depth == 1 && part.starts_with("__")) return std::nullopt;
        path += "/";
        path += part;
    }
    return path.empty() ? std::nullopt : std::optional(path);
}

/// The same below `to` of what is below `from`; of an empty `from`, as it is.
std::optional<std::string> movedBpPath(std::string_view name, const std::string& from,
                                       const std::string& to) {
    auto path = cleanBpPath(name);
    if (!path || from.empty()) return path;
    if (!path->starts_with(from + "/")) return std::nullopt;
    return to + path->substr(from.size());
}

const BpAttribute* attributeOf(const BpContents& contents, std::string_view path) {
    for (const auto& attribute : contents.attributes) {
        if (cleanBpPath(attribute.name) == path) return &attribute;
    }
    return nullptr;
}

std::string textOf(const BpContents& contents, std::string_view path) {
    const auto* const attribute = attributeOf(contents, path);
    const auto* const texts =
        attribute != nullptr ? std::get_if<std::vector<std::string>>(&attribute->values) : nullptr;
    return texts != nullptr && !texts->empty() ? texts->front() : std::string();
}

/// openPMD's number of the iteration that a step is; without it the step's own.
std::uint64_t iterationOf(const BpContents& step, const std::string& base, std::uint64_t place) {
    const auto* const attribute = attributeOf(step, base + "/snapshot");
    if (attribute == nullptr) return place;
    return std::visit(
        [&](const auto& values) -> std::uint64_t {
            if constexpr (!std::is_same_v<typename std::decay_t<decltype(values)>::value_type, std::string>) {
                if (!values.empty() && values.front() >= 0 && values.front() < 9e18)
                    return static_cast<std::uint64_t>(values.front());
            }
            return place;
        },
        attribute->values);
}

hid_t nativeTypeOf(const BpVariable& variable) {
    switch (variable.kind) {
        case BpVariable::Kind::integer:
            return variable.valueBytes == 1   ? H5T_NATIVE_INT8
                   : variable.valueBytes == 2 ? H5T_NATIVE_INT16
                   : variable.valueBytes == 4 ? H5T_NATIVE_INT32
                                              : H5T_NATIVE_INT64;
        case BpVariable::Kind::natural:
            return variable.valueBytes == 1   ? H5T_NATIVE_UINT8
                   : variable.valueBytes == 2 ? H5T_NATIVE_UINT16
                   : variable.valueBytes == 4 ? H5T_NATIVE_UINT32
                                              : H5T_NATIVE_UINT64;
        case BpVariable::Kind::real:
            break;
    }
    return variable.valueBytes == sizeof(float) ? H5T_NATIVE_FLOAT
           : variable.valueBytes == 8           ? H5T_NATIVE_DOUBLE
                                                : H5T_NATIVE_LDOUBLE;
}

std::uint64_t bytesInFolder(const std::filesystem::path& folder) {
    std::error_code code;
    std::uint64_t bytes = 0;
    for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
         entry.increment(code)) {
        std::error_code size;
        const auto own = entry->is_regular_file(size) ? entry->file_size(size) : 0;
        if (!size) bytes += own;
    }
    return bytes;
}

/// An HDF5 file in memory alone, of a name that no other has.
H5Handle makeBpTree() {
    static std::atomic<std::uint64_t> made = 0;
    const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!access.ok() || H5Pset_fapl_core(access.get(), 1 << 20, false) < 0 ||
        H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST) < 0) {
        return {};
    }
    const auto name = fmt::format("bp {}", made++);
    return {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose};
}

bool writeBpAttribute(hid_t object, const char* name, hid_t type, const void* values, hsize_t count) {
    // One value is a scalar, as most of openPMD's are.
    const H5Handle space(count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
    if (!space.ok()) return false;
    const H5Handle attribute(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    return attribute.ok() && (count == 0 || H5Awrite(attribute.get(), type, values) >= 0);
}

bool writeBpTexts(hid_t object, const char* name, const std::vector<std::string>& texts) {
    std::size_t longest = 1;
    for (const auto& text : texts) longest = std::max(longest, text.size() + 1);
    if (longest * texts.size() > mostTextBytes) return true;  // no text of openPMD's
    std::string bytes(longest * std::max<std::size_t>(texts.size(), 1), '\0');
    for (std::size_t i = 0; i < texts.size(); ++i) texts[i].copy(bytes.data() + i * longest, texts[i].size());
    const H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    return type.ok() && H5Tset_size(type.get(), longest) >= 0 &&
           writeBpAttribute(object, name, type.get(), bytes.data(), texts.size());
}

}  // namespace

bool BpTree::isBp(const std::filesystem::path& folder) {
    std::error_code code;
    return std::filesystem::is_regular_file(folder / "md.idx", code);
}

bool BpTree::reads(const std::filesystem::path& folder) {
    return isBp(folder) && openBp() != nullptr;
}

Result<std::shared_ptr<BpTree>> BpTree::open(const std::filesystem::path& folder) {
    silenceHdf5();
    const auto name = folder.filename().string();
    auto tree = std::make_shared<BpTree>();
    tree->bytes_ = bytesInFolder(folder);
    const OpenBp open = openBp();
    if (open == nullptr) return unsupported(name, "is an ADIOS2 file, and there is no ADIOS2 to read it");
    std::string why;
    std::error_code code;
    tree->values_.reset(open(folder.c_str(), std::filesystem::exists(folder / "mmd.0", code), why));
    if (!tree->values_) return bpError(name, why);
    tree->tree_ = makeBpTree();
    if (!tree->tree_.ok()) return Error{ErrorCode::internal, name, "HDF5 cannot be set up"};
    MOTE_RETURN_IF_ERROR(tree->build(name));
    return tree;
}

Status BpTree::build(const std::string& name) {
    BpContents all;
    if (const auto why = values_->contents(all); !why.empty()) return bpError(name, why);
    if (textOf(all, "/iterationEncoding") != "variableBased") return add(all, "", "", name);
    // "/data" of "/data", "/data/" and "/data/%T/".
    const auto said = textOf(all, "/basePath");
    const auto base = cleanBpPath(std::string_view(said).substr(0, said.find('%')));
    if (!base) return corrupt(name + "@basePath", "names no group below the root");
    return addSteps(*base, name);
}

/// Makes the file that has the same iterations as groups.
Status BpTree::addSteps(const std::string& base, const std::string& name) {
    std::vector<BpContents> steps;
    if (const auto why = values_->contentsByStep(steps); !why.empty()) return bpError(name, why);
    std::set<std::uint64_t> numbers;
    // Of an iteration that was written twice, the later one.
    for (std::size_t i = steps.size(); i-- > 0;) {
        const auto number = iterationOf(steps[i], base, i);
        if (!numbers.insert(number).second) continue;
        MOTE_RETURN_IF_ERROR(add(steps[i], base, fmt::format("{}/{}", base, number), name));
    }
    if (steps.empty()) return success();
    BpContents root;
    for (auto& attribute : steps.back().attributes) {
        const auto path = cleanBpPath(attribute.name);
        if (!path || path->rfind('/') != 0 || *path == "/basePath" || *path == "/iterationEncoding") continue;
        root.attributes.push_back(std::move(attribute));
    }
    root.attributes.push_back({"/basePath", std::vector<std::string>{base + "/%T/"}});
    root.attributes.push_back({"/iterationEncoding", std::vector<std::string>{"groupBased"}});
    return add(root, "", "", name);
}

Status BpTree::add(const BpContents& contents, const std::string& from, const std::string& to,
                   const std::string& name) {
    for (const auto& variable : contents.variables) {
        const auto path = movedBpPath(variable.name, from, to);
        if (path) MOTE_RETURN_IF_ERROR(addVariable(*path, variable, name + ":" + *path));
    }
    for (const auto& attribute : contents.attributes) {
        const auto path = movedBpPath(attribute.name, from, to);
        if (path) MOTE_RETURN_IF_ERROR(addAttribute(*path, attribute, name + ":" + *path));
    }
    return success();
}

Status BpTree::addVariable(const std::string& path, const BpVariable& variable, const std::string& where) {
    const auto& extent = variable.extent;
    if (extent.size() > H5S_MAX_RANK) return refusedBpTree(where);
    const std::vector<hsize_t> lengths(extent.begin(), extent.end());
    const H5Handle space(lengths.empty()
                             ? H5Screate(H5S_SCALAR)
                             : H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr),
                         H5Sclose);
    const H5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    if (!space.ok() || !links.ok() || H5Pset_create_intermediate_group(links.get(), 1) < 0)
        return refusedBpTree(where);
    // Never written: it takes no memory.
    const H5Handle dataset(H5Dcreate2(tree_.get(), path.c_str(), nativeTypeOf(variable), space.get(),
                                      links.get(), H5P_DEFAULT, H5P_DEFAULT),
                           H5Dclose);
    if (!dataset.ok()) return refusedBpTree(where);
    variables_.insert_or_assign(path, variable);
    return success();
}

/// The variable, or the group, which is made where it is not there.
H5Handle BpTree::openOrMake(const std::string& path) {
    H5Handle there(H5Oopen(tree_.get(), path.empty() ? "/" : path.c_str(), H5P_DEFAULT), H5Oclose);
    if (there.ok()) return there;
    const H5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    if (!links.ok() || H5Pset_create_intermediate_group(links.get(), 1) < 0) return {};
    return {H5Gcreate2(tree_.get(), path.c_str(), links.get(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
}

Status BpTree::addAttribute(const std::string& path, const BpAttribute& attribute, const std::string& where) {
    const auto slash = path.rfind('/');
    const H5Handle object = openOrMake(path.substr(0, slash));
    if (!object.ok()) return refusedBpTree(where);
    const auto* const name = path.c_str() + slash + 1;
    const bool written = std::visit(
        [&](const auto& values) {
            using Value = typename std::decay_t<decltype(values)>::value_type;
            if constexpr (std::is_same_v<Value, std::string>) {
                return writeBpTexts(object.get(), name, values);
            } else {
                const hid_t type = std::is_same_v<Value, double>         ? H5T_NATIVE_DOUBLE
                                   : std::is_same_v<Value, std::int64_t> ? H5T_NATIVE_INT64
                                                                         : H5T_NATIVE_UINT64;
                return writeBpAttribute(object.get(), name, type, values.data(), values.size());
            }
        },
        attribute.values);
    return written ? success() : Status(refusedBpTree(where));
}

Result<std::unique_ptr<BpValues>> BpValues::open(std::shared_ptr<BpTree> tree, const H5Object& dataset) {
    std::string path(mostPathBytes + 64, '\0');
    const auto length = H5Iget_name(dataset.handle.get(), path.data(), path.size());
    path.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
    const auto found = tree->variables_.find(path);
    if (found == tree->variables_.end()) return corrupt(dataset.where, "is no variable of the file");
    const auto& variable = found->second;
    std::uint64_t wanted = 1;
    constexpr auto most = std::numeric_limits<std::uint64_t>::max();
    for (const auto size : variable.extent) wanted = size != 0 && wanted > most / size ? most : wanted * size;
    const auto bytes = std::min(tree->bytes_, most / bpRatio) * bpRatio;
    if (wanted > bytes / variable.valueBytes) {
        return corrupt(dataset.where,
                       fmt::format("declares {} values, more than {} bytes can hold; the file is "
                                   "cut short or damaged",
                                   wanted, tree->bytes_));
    }
    std::uint64_t there = 0;
    if (const auto why = tree->values_->countValues(variable, there); !why.empty())
        return bpError(dataset.where, why);
    if (there < wanted) {
        return corrupt(dataset.where,
                       fmt::format("declares {} values and holds {}: not all were written, or the "
                                   "file is damaged",
                                   wanted, there));
    }
    return std::unique_ptr<BpValues>(new BpValues(std::move(tree), variable));
}

Status BpValues::readBox(std::span<const hsize_t> first, std::span<const hsize_t> count, void* values,
                         const std::string& where) {
    const std::vector<std::size_t> from(first.begin(), first.end()), size(count.begin(), count.end());
    const auto why = tree_->values_->read(variable_, from, size, values);
    return why.empty() ? success() : Status(bpError(where, why));
}

Status BpValues::read(std::span<const hsize_t> first, std::span<const hsize_t> count, void* values,
                      const std::string& where) {
    if (first.size() != 1 || count[0] >= windowValues) return readBox(first, count, values, where);
    const auto valueBytes = variable_.valueBytes;
    if (first[0] < windowBegin_ || first[0] + count[0] > windowBegin_ + window_.size() / valueBytes) {
        const hsize_t rows = std::min<hsize_t>(windowValues, variable_.extent[0] - first[0]);
        window_.assign(rows * valueBytes, std::byte{0});
        windowBegin_ = first[0];
        const auto filled = readBox(first, std::span(&rows, 1), window_.data(), where);
        if (!filled.ok()) window_.clear();
        MOTE_RETURN_IF_ERROR(filled);
    }
    std::memcpy(values, window_.data() + (first[0] - windowBegin_) * valueBytes, count[0] * valueBytes);
    return success();
}

}  // namespace mote::prep
