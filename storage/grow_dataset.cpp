// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/grow_dataset.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "protocol/base/json.h"
#include "protocol/base/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/real_path.h"
#include "storage/manifest.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

/// What all steps of a plot have in common.
proto::ParticlesManifest plotOf(const proto::Manifest& manifest) {
    proto::ParticlesManifest plot = manifest.particles();
    const bool ofSteps =
        std::ranges::any_of(plot.steps(), [](const auto& step) { return step.axes_size() > 0; });
    for (auto& axis : *plot.mutable_axes()) {
        if (!ofSteps) continue;
        axis.clear_min();
        axis.clear_max();
    }
    for (auto& column : *plot.mutable_columns()) {
        column.clear_min();
        column.clear_max();
        column.clear_type();
    }
    plot.clear_steps();
    plot.clear_notes();
    plot.clear_live();
    plot.clear_density_min();
    plot.clear_density_max();
    return plot;
}

/// Numbers that are not defined are equal to themselves as bytes.
bool same(const google::protobuf::Message& one, const google::protobuf::Message& other) {
    return one.SerializeAsString() == other.SerializeAsString();
}

/// The first field that differs, as JSON has it; "" if none does.
std::string differingField(const google::protobuf::Message& one, const google::protobuf::Message& other) {
    const auto& type = *one.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        auto left = std::unique_ptr<google::protobuf::Message>(one.New());
        auto right = std::unique_ptr<google::protobuf::Message>(one.New());
        left->CopyFrom(one);
        right->CopyFrom(other);
        for (int j = 0; j < type.field_count(); ++j) {
            if (j == i) continue;
            left->GetReflection()->ClearField(left.get(), type.field(j));
            right->GetReflection()->ClearField(right.get(), type.field(j));
        }
        if (!same(*left, *right)) return std::string(type.field(i)->json_name());
    }
    return "";
}

/// A step as it stays: its histogram is over the densities of all steps.
proto::ParticleStepEntry lasting(proto::ParticleStepEntry step) {
    step.clear_density_histogram();
    return step;
}

Result<proto::Manifest> parseManifest(const fs::path& folder) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readWhole(folder / manifestName, manifestLimit));
    proto::Manifest manifest;
    MOTE_RETURN_IF_ERROR(parseJson(text, manifest, (folder / manifestName).string()));
    return manifest;
}

std::set<std::string> namesOf(const proto::Manifest& manifest) {
    std::set<std::string> names;
    for (const auto& file : manifest.files()) names.insert(file.name());
    return names;
}

/// EINVAL: a file system that cannot sync folders has nothing to do.
Status syncFolder(const GrowthLock& lock) {
    if (::fsync(lock.folder()) == 0 || errno == EINVAL) return success();
    return systemError(errno, lock.dataset().string(), "cannot be written to the disk");
}

Status moveInto(const FileDescriptor& from, const std::string& name, const GrowthLock& lock) {
    if (::renameat(from.get(), name.c_str(), lock.folder(), name.c_str()) == 0) return success();
    return systemError(errno, (lock.dataset() / name).string(), "cannot be put in place");
}

/// What nobody has told of, and nobody will.
void removeStrays(const proto::Manifest& manifest, const GrowthLock& lock) {
    const auto names = namesOf(manifest);
    std::error_code code;
    std::vector<std::string> strays;
    for (fs::directory_iterator entry(lock.dataset(), code), end; !code && entry != end;
         entry.increment(code)) {
        auto name = entry->path().filename().string();
        if (isOfSomeStep(name) && !names.contains(name)) strays.push_back(std::move(name));
    }
    for (const auto& name : strays) ::unlinkat(lock.folder(), name.c_str(), 0);
}

}  // namespace

bool isOfSomeStep(const std::string& name) {
    return name.starts_with("step-") || name.starts_with("columns-");
}

Status checkBegins(const fs::path& draft) {
    MOTE_ASSIGN_OR_RETURN(const auto manifest, parseManifest(draft));
    for (const auto& name : namesOf(manifest)) {
        std::error_code code;
        if (!isPlainName(name) || !fs::is_regular_file(draft / name, code))
            return notFound(draft.filename().string(), "continues a live dataset that is there no more");
    }
    return success();
}

Result<GrowthLock> GrowthLock::take(const fs::path& dataset) {
    std::error_code code;
    const auto real = fs::canonical(dataset.parent_path().empty() ? "." : dataset.parent_path(), code);
    if (code) return systemError(code.value(), dataset.string(), "cannot be opened");
    MOTE_ASSIGN_OR_RETURN(auto folder, openReal(real / dataset.filename(), O_RDONLY | O_DIRECTORY));
    // A network file system may have no locks of folders: a manifest that does not continue the one that is
    // there is refused there too.
    if (::flock(folder.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return Error{ErrorCode::alreadyExists, dataset.string(), "gets its steps from another program now"};
    return GrowthLock(real / dataset.filename(), std::move(folder));
}

Status checkGrowth(const proto::Manifest& now, const proto::Manifest& next) {
    if (!now.has_particles() || !now.particles().live())
        return invalid("", "is no live dataset: nothing is added to it any more");
    if (now.kind() != next.kind() || now.format() != next.format() || !next.has_particles())
        return invalid("kind", "is not that of the dataset");
    const auto field = differingField(plotOf(now), plotOf(next));
    if (!field.empty()) {
        return invalid(fmt::format("particles.{}", field),
                       "is not that of the dataset: its further steps are of the same run and the same plot");
    }
    const auto& before = now.particles().steps();
    const auto& after = next.particles().steps();
    const bool longer = after.size() >= before.size() && next.files_size() >= now.files_size();
    for (int i = 0; longer && i < before.size(); ++i) {
        if (!same(lasting(before[i]), lasting(after[i])))
            return invalid(fmt::format("particles.steps[{}]", i), "is another step than the dataset's");
    }
    for (int i = 0; longer && i < now.files_size(); ++i) {
        if (!same(now.files(i), next.files(i)))
            return invalid(fmt::format("files[{}]", i), "is another file than the dataset's");
    }
    return longer ? success() : Status(invalid("particles.steps", "are fewer than the dataset has"));
}

Status growDataset(const fs::path& draft, const GrowthLock& lock) {
    MOTE_ASSIGN_OR_RETURN(const auto now, parseManifest(lock.dataset()));
    MOTE_ASSIGN_OR_RETURN(const auto next, parseManifest(draft));
    const auto fits = checkGrowth(now, next);
    if (!fits.ok()) {
        const auto& where = fits.error().where;
        return Error{fits.error().code,
                     lock.dataset().filename().string() + (where.empty() ? "" : ": " + where),
                     fits.error().message};
    }
    const FileDescriptor from(::open(draft.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!from.valid()) return systemError(errno, draft.string(), "cannot be opened");
    const auto there = namesOf(now);
    for (int i = now.files_size(); i < next.files_size(); ++i) {
        const auto& name = next.files(i).name();
        const bool own = isPlainName(name) && name != manifestName && name != manifestDigestName;
        if (!own || there.contains(name))
            return corrupt(draft.string(), "its manifest names a file that is none of its further steps");
        MOTE_RETURN_IF_ERROR(moveInto(from, name, lock));
    }
    MOTE_RETURN_IF_ERROR(syncFolder(lock));
    MOTE_RETURN_IF_ERROR(moveInto(from, manifestName, lock));
    MOTE_RETURN_IF_ERROR(syncFolder(lock));
    if (next.particles().live()) return success();
    removeStrays(next, lock);
    MOTE_RETURN_IF_ERROR(moveInto(from, manifestDigestName, lock));
    return syncFolder(lock);
}

}  // namespace mote::storage
