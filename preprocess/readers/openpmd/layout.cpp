// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/openpmd/layout.h"

#include <algorithm>
#include <charconv>

#include "preprocess/readers/hdf5/h5_attribute.h"

namespace mote::prep {
namespace {

/// "%T" or "%06T" in a text.
struct Placeholder {
    std::size_t begin = 0, end = 0;
};

std::optional<Placeholder> findPlaceholder(std::string_view text) {
    for (std::size_t at = text.find('%'); at != std::string_view::npos; at = text.find('%', at + 1)) {
        std::size_t end = at + 1;
        while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;
        if (end < text.size() && text[end] == 'T') return Placeholder{at, end + 1};
    }
    return std::nullopt;
}

std::string join(std::string_view folder, std::string_view name) {
    std::string path(folder);
    while (!path.empty() && path.back() == '/') path.pop_back();
    if (name.empty()) return path.empty() ? "/" : path;
    return path + "/" + std::string(name);
}

/// `path` without slashes at its ends and without a leading ".".
std::string_view inner(std::string_view path) {
    while (path.starts_with('/') || path.starts_with("./")) path.remove_prefix(1);
    while (path.ends_with('/')) path.remove_suffix(1);
    return path == "." ? std::string_view() : path;
}

/// The groups that match a basePath with %T: "/data/%T/", "/%T", "/run/step_%06T/state".
Result<std::vector<OpenpmdIteration>> numberedIterations(const H5File& file, std::string_view basePath) {
    const Placeholder place = *findPlaceholder(basePath);
    const std::size_t slash = basePath.rfind('/', place.begin);
    const std::string_view folder = slash == std::string_view::npos ? "" : basePath.substr(0, slash);
    std::string_view component = basePath.substr(slash == std::string_view::npos ? 0 : slash + 1);
    const std::string_view rest = inner(component.substr(std::min(component.find('/'), component.size())));
    component = component.substr(0, component.find('/'));

    std::vector<OpenpmdIteration> iterations;
    MOTE_ASSIGN_OR_RETURN(auto group, file.find(file.root(), join(folder, "")));
    if (!group.has_value()) return iterations;
    MOTE_ASSIGN_OR_RETURN(const auto names, file.children(*group));
    for (const std::string& name : names) {
        const auto number = matchIteration(component, name);
        if (!number) continue;
        std::string path = join(join(folder, name), rest);
        MOTE_ASSIGN_OR_RETURN(const auto found, file.find(file.root(), path));
        if (!found.has_value() || !found->group) continue;
        iterations.push_back({*number, std::move(path), true});
    }
    std::stable_sort(iterations.begin(), iterations.end(),
                     [](const auto& a, const auto& b) { return a.number < b.number; });
    return iterations;
}

/// True for a group that holds particle records.
Result<bool> holdsRecords(const H5File& file, const H5Object& group) {
    for (const char* record : {"position", "momentum"}) {
        MOTE_ASSIGN_OR_RETURN(const auto found, file.find(group, record));
        if (found.has_value() && found->group) return true;
    }
    return false;
}

}  // namespace

std::optional<std::int64_t> matchIteration(std::string_view pattern, std::string_view name) {
    const auto place = findPlaceholder(pattern);
    if (!place) return std::nullopt;
    const std::string_view before = pattern.substr(0, place->begin), after = pattern.substr(place->end);
    if (name.size() <= before.size() + after.size() || !name.starts_with(before) || !name.ends_with(after)) {
        return std::nullopt;
    }
    const std::string_view digits = name.substr(before.size(), name.size() - before.size() - after.size());
    std::int64_t number = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (code != std::errc() || end != digits.data() + digits.size() || number < 0) return std::nullopt;
    return number;
}

bool looksLikeOpenpmd(const H5File& file) {
    for (const char* name : {"openPMD", "basePath"}) {
        const auto text = textAttribute(file.root(), name);
        if (text && text->has_value()) return true;
    }
    return false;
}

Result<OpenpmdLayout> readOpenpmdLayout(const H5File& file) {
    OpenpmdLayout layout;
    MOTE_ASSIGN_OR_RETURN(const auto version, textAttribute(file.root(), "openPMD"));
    layout.version = version.value_or("1.0.0");
    if (!layout.version.starts_with("1.") && !layout.version.starts_with("2.")) {
        return Error{ErrorCode::unsupported, file.name(),
                     "is of openPMD version '" + layout.version + "'; versions 1.0 to 2.0 are read"};
    }
    MOTE_ASSIGN_OR_RETURN(const auto base, textAttribute(file.root(), "basePath"));
    const std::string basePath = base.value_or("/data/%T/");
    MOTE_ASSIGN_OR_RETURN(auto particles, textAttribute(file.root(), "particlesPath"));
    layout.particlesPath = std::move(particles);

    if (findPlaceholder(basePath)) {
        MOTE_ASSIGN_OR_RETURN(auto iterations, numberedIterations(file, basePath));
        layout.iterations = std::move(iterations);
    } else {
        MOTE_ASSIGN_OR_RETURN(const auto group, file.find(file.root(), join("/", inner(basePath))));
        if (group.has_value()) layout.iterations.push_back({0, join("/", inner(basePath)), false});
    }
    if (layout.iterations.empty()) {
        return Error{ErrorCode::notFound, file.name() + ":" + basePath, "the file has no iterations there"};
    }
    return layout;
}

Result<std::vector<OpenpmdSpeciesPath>> listSpecies(const H5File& file, const OpenpmdLayout& layout,
                                                    const OpenpmdIteration& iteration) {
    std::vector<OpenpmdSpeciesPath> species;
    std::string path = join(iteration.path, inner(layout.particlesPath.value_or("particles/")));
    auto group = file.find(file.root(), path);
    if (group && !group->has_value() && !layout.particlesPath) {
        path = iteration.path;
        group = file.find(file.root(), path);
    }
    if (!group) return group.error();
    if (!group->has_value() || !(*group)->group) return species;
    MOTE_ASSIGN_OR_RETURN(const auto direct, holdsRecords(file, **group));
    if (direct) return std::vector<OpenpmdSpeciesPath>{{"", path}};
    MOTE_ASSIGN_OR_RETURN(const auto names, file.children(**group));
    for (const std::string& name : names) {
        MOTE_ASSIGN_OR_RETURN(const auto child, file.find(**group, name));
        if (!child.has_value() || !child->group) continue;
        MOTE_ASSIGN_OR_RETURN(const auto particles, holdsRecords(file, *child));
        if (particles) species.push_back({name, join(path, name)});
    }
    return species;
}

}  // namespace mote::prep
