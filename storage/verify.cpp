// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/verify.h"

#include <fmt/format.h>

#include <optional>

#include "storage/arrays/array_file.h"
#include "storage/files/packed_file.h"
#include "storage/files/read_file.h"
#include "storage/files/system_error.h"
#include "storage/hash.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/particles/mapped_step.h"
#include "storage/stipple/hierarchy_file.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t maxErrors = 1000;

class Verifier {
  public:
    Verifier(fs::path directory, proto::Manifest manifest, std::function<bool()> cancelled,
             std::function<void(double)> progress)
        : directory_(std::move(directory)),
          manifest_(std::move(manifest)),
          cancelled_(std::move(cancelled)),
          progress_(std::move(progress)) {}

    std::vector<Error> run() {
        findExtra();
        const auto& steps = manifest_.particles().steps();
        for (int i = 0; i < steps.size() && errors_.size() < maxErrors; ++i) {
            checkStep(static_cast<std::uint32_t>(i));
            if (wasCancelled()) return {errors_.back()};
            if (progress_) progress_((i + 1.0) / steps.size());
        }
        const auto& hybrid = manifest_.hybrid().steps();
        for (int i = 0; i < hybrid.size() && errors_.size() < maxErrors; ++i) {
            checkHybridStep(static_cast<std::uint32_t>(i));
            if (wasCancelled()) return {errors_.back()};
            if (progress_) progress_((i + 1.0) / hybrid.size());
        }
        if (manifest_.has_mesh()) checkWith(meshName, readMesh);
        if (wasCancelled()) return {errors_.back()};
        if (manifest_.has_stipple()) checkWith(hierarchyName, readHierarchy);
        if (manifest_.has_image())
            checkWith(imageName,
                      [](const auto& folder, const auto& manifest) { return readImage(folder, manifest); });
        if (wasCancelled()) return {errors_.back()};
        if (errors_.size() > maxErrors) errors_.resize(maxErrors);
        return errors_;
    }

  private:
    bool wasCancelled() const { return !errors_.empty() && errors_.back().code == ErrorCode::cancelled; }

    void findExtra() {
        std::error_code code;
        fs::directory_iterator at(directory_, code);
        for (; !code && at != fs::directory_iterator() && errors_.size() < maxErrors; at.increment(code)) {
            const auto name = at->path().filename().string();
            if (name == manifestName || findFile(manifest_, name)) continue;
            errors_.push_back({ErrorCode::corrupt, at->path().string(), "is no part of the dataset"});
        }
        if (code) errors_.push_back(systemError(code.value(), directory_.string(), "cannot be listed"));
    }

    /// A file against the manifest; nothing where it is whole.
    std::optional<Error> checkFile(const std::string& name) const {
        const auto path = directory_ / name;
        const auto regular = openRegular(path);
        if (!regular.ok()) return regular.error();
        const auto hash = hashFile(path, cancelled_);
        if (!hash.ok()) return hash.error();
        const auto& entry = *findFile(manifest_, name);
        if (hash->size == entry.size() && hash->xxh3_128 == entry.xxh3_128()) return std::nullopt;
        return Error{ErrorCode::corrupt, path.string(),
                     hash->size == entry.size()
                         ? "differs from its hash in the manifest"
                         : fmt::format("has {} bytes where the manifest says {}", hash->size, entry.size())};
    }

    /// Files against the manifest; whether all are whole, or nothing after a cancellation.
    std::optional<bool> checkFiles(const std::vector<std::string>& names) {
        bool whole = true;
        for (const auto& name : names) {
            auto error = checkFile(name);
            if (!error) continue;
            whole = false;
            errors_.push_back(*std::move(error));
            if (wasCancelled()) return std::nullopt;
        }
        return whole;
    }

    void add(const std::vector<Error>& more) { errors_.insert(errors_.end(), more.begin(), more.end()); }

    void checkStep(std::uint32_t step) {
        const auto& entry = manifest_.particles().steps(static_cast<int>(step));
        const auto whole = checkFiles({entry.digest(), entry.file()});
        if (!whole) return;
        // The arrays too: they say which block of which array it is, and what no hash can say of the octree.
        const auto opened = MappedStep::open(directory_, manifest_, step);
        // A file that is not there, or not whole, is said once.
        if (!opened.ok() && !*whole) return;
        add(opened.ok() ? (*opened)->verify(cancelled_) : std::vector<Error>{opened.error()});
    }

    void checkHybridStep(std::uint32_t step) {
        const auto& entry = manifest_.hybrid().steps(static_cast<int>(step));
        const fs::path file = entry.file();
        const bool packed = file.extension() == packedSuffix;
        if (packed ? checkFiles({entry.digest(), entry.file()}).value_or(false)
                   : checkArrayFile(file.stem().string())) {
            const auto opened = HybridStep::open(directory_, manifest_, step);
            if (!opened.ok()) add({opened.error()});
        }
        if (wasCancelled() || entry.residual_file().empty()) return;
        const auto read = readResidual(
            directory_, manifest_, step, [](const ResidualBrick&) {}, cancelled_);
        if (!read.ok()) add({read.error()});
    }

    /// A file of arrays: whether its files and all of its blocks are whole.
    bool checkArrayFile(const std::string& name) {
        const auto whole = checkFiles({name + ".digest", name + ".h5"});
        if (!whole) return false;
        const auto opened = ArrayFile::open(directory_, manifest_, name);
        if (!opened.ok() && !*whole) return false;
        const auto found = opened.ok() ? opened->verify(cancelled_) : std::vector<Error>{opened.error()};
        add(found);
        return *whole && found.empty();
    }

    /// A file of arrays, and what only its reader can say of it.
    template <class Read>
    void checkWith(const char* name, const Read& readFile) {
        if (!checkArrayFile(name)) return;
        const auto read = readFile(directory_, manifest_);
        if (!read.ok()) add({read.error()});
        if (progress_) progress_(1.0);
    }

    fs::path directory_;
    proto::Manifest manifest_;
    std::function<bool()> cancelled_;
    std::function<void(double)> progress_;
    std::vector<Error> errors_;
};

}  // namespace

std::vector<Error> verifyDataset(const fs::path& directory, const std::function<bool()>& cancelled,
                                 const std::function<void(double)>& progress) {
    auto manifest = readManifest(directory);
    if (!manifest.ok()) return {manifest.error()};
    return Verifier(directory, *std::move(manifest), cancelled, progress).run();
}

}  // namespace mote::storage
