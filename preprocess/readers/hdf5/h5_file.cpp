// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_file.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <fstream>
#include <system_error>

#include "preprocess/readers/adios2/bp_tree.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxChildren = 1'000'000;
constexpr std::size_t maxNameBytes = 4096;
constexpr int maxSteps = 512;  // components walked for one path, those of soft links included

void pushFront(std::deque<std::string>& components, std::string_view path) {
    std::vector<std::string> names;
    while (!path.empty()) {
        const std::size_t slash = std::min(path.find('/'), path.size());
        const std::string_view name = path.substr(0, slash);
        if (!name.empty() && name != ".") names.emplace_back(name);
        path.remove_prefix(std::min(slash + 1, path.size()));
    }
    components.insert(components.begin(), names.begin(), names.end());
}

std::string join(const std::string& where, std::string_view name) {
    return where.ends_with('/') ? where + std::string(name) : where + "/" + std::string(name);
}

Result<H5Object> openHard(hid_t parent, const std::string& name, std::string where) {
    H5Handle handle(H5Oopen(parent, name.c_str(), H5P_DEFAULT), H5Oclose);
    const H5I_type_t type = handle.ok() ? H5Iget_type(handle.get()) : H5I_BADID;
    if (!handle.ok()) return corrupt(std::move(where), "HDF5 cannot open this object; the file is damaged");
    if (type != H5I_GROUP && type != H5I_DATASET) {
        return unsupported(std::move(where), "is neither a group nor a dataset");
    }
    return H5Object{std::move(handle), std::move(where), type == H5I_GROUP};
}

Result<std::string> softTarget(hid_t parent, const std::string& name, std::size_t size,
                               const std::string& where) {
    if (size == 0 || size > maxNameBytes) return corrupt(where, "has a soft link of an impossible length");
    std::string target(size + 1, '\0');
    if (H5Lget_val(parent, name.c_str(), target.data(), size, H5P_DEFAULT) < 0) {
        return corrupt(where, "has a soft link that cannot be read");
    }
    target.resize(std::strlen(target.c_str()));
    return target;
}

herr_t collectName(hid_t, const char* name, const H5L_info_t*, void* data) noexcept {
    auto& names = *static_cast<std::vector<std::string>*>(data);
    if (names.size() >= maxChildren) return 1;
    try {
        names.emplace_back(name, strnlen(name, maxNameBytes));
    } catch (...) {
        return -1;
    }
    return 0;
}

}  // namespace

bool H5File::looksLikeHdf5(const std::filesystem::path& path) {
    if (BpTree::reads(path)) return true;
    static constexpr std::array<char, 8> signature = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
    std::ifstream file(path, std::ios::binary);
    for (std::uint64_t at = 0; at <= (1u << 20); at = at == 0 ? 512 : at * 2) {
        std::array<char, 8> bytes{};
        file.seekg(static_cast<std::streamoff>(at));
        if (!file.read(bytes.data(), bytes.size())) return false;
        if (bytes == signature) return true;
    }
    return false;
}

Result<H5File> H5File::open(const std::filesystem::path& path) {
    silenceHdf5();
    H5PLset_loading_state(0);  // no filters from plugins
    H5File result;
    result.name_ = path.filename().string();
    if (BpTree::reads(path)) {
        MOTE_ASSIGN_OR_RETURN(result.bp_, BpTree::open(path));
        result.bytes_ = result.bp_->bytes();
        result.file_ = H5Handle(H5Freopen(result.bp_->file()), H5Fclose);
    } else {
        MOTE_RETURN_IF_ERROR(result.openHdf5(path));
    }
    result.root_ = {H5Handle(H5Gopen2(result.file_.get(), "/", H5P_DEFAULT), H5Gclose), result.name_ + ":/",
                    true};
    if (!result.root_.handle.ok()) return corrupt(result.name_, "the root group is damaged");
    return result;
}

Status H5File::openHdf5(const std::filesystem::path& path) {
    std::error_code code;
    bytes_ = std::filesystem::file_size(path, code);
    if (code) return notFound(name_, "cannot be read: " + code.message());
    if (!looksLikeHdf5(path)) return corrupt(name_, "is not an HDF5 file, or not one that may be read");
    // The driver is named, so that neither the file nor the environment chooses another one.
    const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!access.ok() || H5Pset_fapl_sec2(access.get()) < 0) {
        return Error{ErrorCode::internal, name_, "HDF5 cannot be set up"};
    }
    file_ = H5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
    if (!file_.ok()) return corrupt(name_, "HDF5 cannot open the file: it is damaged or cut short");
    // HDF5's own descriptor: another file may have the name by now.
    void* handle = nullptr;
    if (H5Fget_vfd_handle(file_.get(), access.get(), &handle) < 0 || handle == nullptr) return success();
    storage::FileDescriptor own(::fcntl(*static_cast<const int*>(handle), F_DUPFD_CLOEXEC, 0));
    if (own.valid()) descriptor_ = std::make_shared<const storage::FileDescriptor>(std::move(own));
    return success();
}

Status H5File::enter(const std::string& path) {
    MOTE_ASSIGN_OR_RETURN(auto group, require(root_, path));
    if (!group.group) return corrupt(group.where, "is a dataset where a group was expected");
    root_ = std::move(group);
    return success();
}

Result<std::optional<H5Object>> H5File::find(const H5Object& from, std::string_view path) const {
    std::deque<std::string> components;
    pushFront(components, path);
    const bool absolute = path.starts_with('/');
    const H5Object& start = absolute ? root_ : from;
    std::optional<H5Object> found =
        H5Object{H5Handle(H5Oopen(start.handle.get(), ".", H5P_DEFAULT), H5Oclose), start.where, start.group};
    if (!found->handle.ok()) return corrupt(start.where, "HDF5 cannot open this group; the file is damaged");
    for (int step = 0; !components.empty(); ++step) {
        const std::string name = std::move(components.front());
        components.pop_front();
        const std::string where = join(found->where, name);
        if (step >= maxSteps)
            return unsupported(where, "its links go round in a circle, or the path is too long");
        if (!found->group || name.size() > maxNameBytes) return std::optional<H5Object>();
        const hid_t parent = found->handle.get();
        const htri_t exists = H5Lexists(parent, name.c_str(), H5P_DEFAULT);
        if (exists < 0) return corrupt(where, "the group that should hold this is damaged");
        if (exists == 0) return std::optional<H5Object>();
        H5L_info_t info{};
        if (H5Lget_info(parent, name.c_str(), &info, H5P_DEFAULT) < 0) {
            return corrupt(where, "the link cannot be read; the file is damaged");
        }
        if (info.type == H5L_TYPE_SOFT) {
            MOTE_ASSIGN_OR_RETURN(auto target, softTarget(parent, name, info.u.val_size, where));
            pushFront(components, target);
            if (target.starts_with('/')) {
                found =
                    H5Object{H5Handle(H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose), name_ + ":/", true};
            }
        } else if (info.type == H5L_TYPE_HARD) {
            MOTE_ASSIGN_OR_RETURN(auto next, openHard(parent, name, where));
            found = std::move(next);
        } else {
            return unsupported(where,
                               "is a link that leads out of the file, and such links are not followed");
        }
    }
    return found;
}

Result<H5Object> H5File::require(const H5Object& from, std::string_view path) const {
    MOTE_ASSIGN_OR_RETURN(auto found, find(from, path));
    if (!found.has_value()) {
        const std::string where =
            path.starts_with('/') ? name_ + ":" + std::string(path) : join(from.where, path);
        return notFound(where, "is missing");
    }
    return std::move(*found);
}

Result<std::vector<std::string>> H5File::children(const H5Object& group) const {
    std::vector<std::string> names;
    if (!group.group) return corrupt(group.where, "is a dataset where a group was expected");
    hsize_t position = 0;
    const herr_t status =
        H5Literate(group.handle.get(), H5_INDEX_NAME, H5_ITER_NATIVE, &position, collectName, &names);
    if (status < 0) return corrupt(group.where, "the group's contents cannot be listed; the file is damaged");
    if (status > 0)
        return Error{ErrorCode::resourceExhausted, group.where, "holds more than a million objects"};
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace mote::prep
