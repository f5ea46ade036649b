// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/look/look_at.h"

#include <algorithm>
#include <array>
#include <system_error>

#include "preprocess/mesh/read_mesh.h"

namespace mote::prep {
namespace {

// A file of another ending is read as a mesh only where that takes no time to speak of.
constexpr std::uintmax_t unnamedMesh = std::uintmax_t{1} << 28;  // bytes

constexpr std::array<std::string_view, 4> meshEndings{".obj", ".ply", ".stl", ".off"};

using Looked = Result<std::vector<Found>> (*)(const std::filesystem::path&, const LookOptions&, Progress&);

/// What one kind's readers say of a file that is none of their formats: nothing of the file.
bool saysNothing(const Error& error) {
    const bool otherFormat = error.code == ErrorCode::invalidArgument && error.where == "format";
    return otherFormat ||
           (error.code == ErrorCode::unsupported &&
            (error.message.starts_with("is no ") || error.message.starts_with("is of no known format")));
}

/// Particles' readers know many formats by sight that they do not read.
bool saysOfOthers(const Error& error) {
    return error.message.find("which is not read as particles") != std::string::npos;
}

bool isNamedMesh(const std::filesystem::path& path) {
    return std::find(meshEndings.begin(), meshEndings.end(), meshEnding(path)) != meshEndings.end();
}

/// Gathers what is found, and why it is nothing else.
class Looking {
  public:
    Looking(const std::filesystem::path& input, const LookOptions& options, Progress& progress)
        : input_(input), options_(options), progress_(progress) {
        look_.input = input.string();
    }

    Status as(Looked kind) {
        auto found = kind(input_, options_, progress_);
        if (!found.ok() && found.error().code == ErrorCode::cancelled) return found.error();
        if (!found.ok()) {
            errors_.push_back(found.error());
            return success();
        }
        for (Found& each : *found) look_.found.push_back(std::move(each));
        return success();
    }
    bool found() const { return !look_.found.empty(); }

    /// What the file is read as needs no word of what it is not, unless it is damaged there.
    Look finish() {
        std::vector<const Error*> telling;
        for (const Error& error : errors_) {
            const bool told =
                found() ? error.code == ErrorCode::corrupt : !saysNothing(error) && !saysOfOthers(error);
            if (told) telling.push_back(&error);
        }
        if (telling.empty() && !found() && !errors_.empty()) {
            telling.push_back(&errors_.front());
            // Nobody knows it: what would make particles of it, and what a volume.
            if (errors_.size() > 1 && saysNothing(errors_.front())) telling.push_back(&errors_[1]);
        }
        for (const Error* error : telling) {
            const std::string sentence = error->toString();
            if (std::find(look_.refused.begin(), look_.refused.end(), sentence) == look_.refused.end())
                look_.refused.push_back(sentence);
        }
        return std::move(look_);
    }

  private:
    const std::filesystem::path& input_;
    const LookOptions& options_;
    Progress& progress_;
    Look look_;
    std::vector<Error> errors_;
};

}  // namespace

Result<Look> lookAt(const std::filesystem::path& input, const LookOptions& options, Progress& progress) {
    std::error_code code;
    const bool there = std::filesystem::exists(input, code);
    const bool pattern = input.filename().string().find_first_of("%*?") != std::string::npos;
    if (!there && !pattern) return notFound(input.string(), "there is no file or folder of this name");
    if (std::filesystem::exists(input / "manifest.json", code)) {
        Look look;
        look.input = input.string();
        look.refused.emplace_back("is a dataset: mote-prep info says what it holds");
        return look;
    }
    Looking looking(input, options, progress);
    // What is asked for by name is of one kind, and said to be missing where it is.
    if (!options.volume.field().empty() || !options.volume.series().empty()) {
        MOTE_RETURN_IF_ERROR(looking.as(lookAtVolume));
        return looking.finish();
    }
    if (!options.particles.species().empty() || !options.particles.map().empty()) {
        MOTE_RETURN_IF_ERROR(looking.as(lookAtParticles));
        return looking.finish();
    }
    const bool file = std::filesystem::is_regular_file(input, code);
    const bool mesh = file && isNamedMesh(input);
    if (mesh) MOTE_RETURN_IF_ERROR(looking.as(lookAtMesh));
    if (!looking.found()) MOTE_RETURN_IF_ERROR(looking.as(lookAtParticles));
    if (!mesh || !looking.found()) MOTE_RETURN_IF_ERROR(looking.as(lookAtVolume));
    if (file && !mesh) MOTE_RETURN_IF_ERROR(looking.as(lookAtImage));
    if (file && !mesh && !looking.found() && std::filesystem::file_size(input, code) <= unnamedMesh)
        MOTE_RETURN_IF_ERROR(looking.as(lookAtMesh));
    return looking.finish();
}

std::string toldBy(const std::string& wantedFormat, std::string_view told) {
    return wantedFormat.empty() || wantedFormat == "auto" ? std::string(told) : "--format";
}

Result<std::vector<Found>> lookAtEach(const std::vector<std::string>& names, const Found& whole,
                                      const std::function<Result<Found>(const std::string& name)>& look) {
    std::vector<Found> all;
    for (const std::string& name : names) {
        auto found = look(name);
        if (found.ok()) {
            all.push_back(std::move(*found));
            continue;
        }
        if (names.size() == 1 || found.error().code == ErrorCode::cancelled) return found.error();
        all.push_back(whole);
        all.back().name = name;
        all.back().refused.push_back(found.error().toString());
    }
    return all;
}

}  // namespace mote::prep
