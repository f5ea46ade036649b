// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/openpmd/layout.h"

#include <algorithm>
#include <charconv>
#include <deque>
#include <set>
#include <utility>

#include "preprocess/readers/hdf5/h5_attribute.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxVisited = 10'000;  // groups looked at for particles below the root
constexpr std::size_t maxDepth = 8;

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

bool saysOpenpmd(const H5Object& group) {
    for (const char* name : {"openPMD", "basePath"}) {
        const auto text = textAttribute(group, name);
        if (text && text->has_value()) return true;
    }
    return false;
}

/// A group of records that say their units as openPMD's do: without a root, nothing else tells them from
/// other people's.
Result<bool> isBare(const H5File& file, const H5Object& group) {
    for (const char* name : {"position/x", "momentum/x", "position", "momentum"}) {
        MOTE_ASSIGN_OR_RETURN(const auto found, file.find(group, name));
        if (!found.has_value()) continue;
        MOTE_ASSIGN_OR_RETURN(const auto unit, numberAttribute(*found, "unitSI"));
        if (unit.has_value()) return holdsRecords(file, group);
    }
    return false;
}

/// The first `most` groups below the root of which `is` holds, the least deep first; nothing below them.
/// What cannot be opened is stepped over.
template <class Is>
Result<std::vector<std::string>> findGroups(const H5File& file, std::size_t most, Is is) {
    std::vector<std::string> found;
    std::deque<std::pair<std::string, std::size_t>> waiting{{"", 0}};
    for (std::size_t visited = 0; !waiting.empty() && visited < maxVisited; ++visited) {
        const auto [path, depth] = std::move(waiting.front());
        waiting.pop_front();
        const auto group = file.find(file.root(), path.empty() ? "/" : path);
        if (!group || !group->has_value() || !(*group)->group) continue;
        const auto holds = is(**group);
        if (holds && *holds) {
            found.push_back(path.empty() ? "/" : path);
            if (found.size() >= most) break;
            continue;
        }
        const auto names = depth < maxDepth ? file.children(**group)
                                            : Result<std::vector<std::string>>(std::vector<std::string>());
        if (!names) continue;
        for (const std::string& name : *names) {
            if (waiting.size() < maxVisited) waiting.emplace_back(path + "/" + name, depth + 1);
        }
    }
    return found;
}

/// Groups of particles beside each other whose names are numbers are iterations; all others species.
Result<OpenpmdLayout> bareLayout(const H5File& file) {
    OpenpmdLayout layout;
    layout.particlesPath = "";
    MOTE_ASSIGN_OR_RETURN(const auto groups, findGroups(file, maxVisited, [&](const H5Object& group) {
                              return isBare(file, group);
                          }));
    std::set<std::string> folders, names;
    bool numbered = groups.size() > 1;
    for (const std::string& group : groups) {
        folders.insert(group.substr(0, group.rfind('/')));
        const std::string name = group.substr(group.rfind('/') + 1);
        names.insert(name);
        const auto number = matchIteration("%T", name);
        numbered = numbered && number.has_value();
        layout.iterations.push_back({number.value_or(0), group, true});
        layout.bare.push_back({name, group});
    }
    if (groups.empty()) return notFound(file.name(), "holds no openPMD particles");
    std::stable_sort(layout.iterations.begin(), layout.iterations.end(),
                     [](const auto& a, const auto& b) { return a.number < b.number; });
    if (numbered && folders.size() == 1) {
        layout.bare.clear();
        return layout;
    }
    layout.iterations = {{0, "/", false}};
    if (names.size() == groups.size()) return layout;
    for (OpenpmdSpeciesPath& species : layout.bare) species.name = species.path.substr(1);
    return layout;
}

/// The one iteration of a file whose encoding is variableBased, which lies where basePath's %T would begin.
Result<std::vector<OpenpmdIteration>> variableIteration(const H5File& file, std::string_view basePath) {
    std::vector<OpenpmdIteration> iterations;
    const auto place = findPlaceholder(basePath);
    const std::string path = join("/", inner(place ? basePath.substr(0, place->begin) : basePath));
    MOTE_ASSIGN_OR_RETURN(const auto group, file.find(file.root(), path));
    if (!group.has_value() || !(*group).group) return iterations;
    MOTE_ASSIGN_OR_RETURN(const auto number, numberAttribute(*group, "snapshot"));
    const bool numbered = number.has_value() && *number >= 0.0 && *number < 9e18;
    iterations.push_back({numbered ? static_cast<std::int64_t>(*number) : 0, path, numbered});
    return iterations;
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
    return saysOpenpmd(file.root());
}

Result<std::string> findOpenpmdRoot(const H5File& file) {
    if (looksLikeOpenpmd(file)) return std::string();
    MOTE_ASSIGN_OR_RETURN(const auto found, findGroups(file, 1, [](const H5Object& group) -> Result<bool> {
                              return saysOpenpmd(group);
                          }));
    return found.empty() ? std::string() : found.front();
}

bool holdsOpenpmd(const H5File& file) {
    const auto root = findOpenpmdRoot(file);
    if (root && !root->empty()) return true;
    const auto groups = findGroups(file, 1, [&](const H5Object& group) { return isBare(file, group); });
    return groups && !groups->empty();
}

Result<OpenpmdLayout> readOpenpmdLayout(const H5File& file) {
    if (!looksLikeOpenpmd(file)) return bareLayout(file);
    OpenpmdLayout layout;
    MOTE_ASSIGN_OR_RETURN(const auto version, textAttribute(file.root(), "openPMD"));
    layout.version = version.value_or("1.0.0");
    if (!layout.version.starts_with("1.") && !layout.version.starts_with("2.")) {
        return unsupported(file.name(),
                           "is of openPMD version '" + layout.version + "'; versions 1.0 to 2.0 are read");
    }
    MOTE_ASSIGN_OR_RETURN(const auto base, textAttribute(file.root(), "basePath"));
    const std::string basePath = base.value_or("/data/%T/");
    MOTE_ASSIGN_OR_RETURN(auto particles, textAttribute(file.root(), "particlesPath"));
    layout.particlesPath = std::move(particles);

    MOTE_ASSIGN_OR_RETURN(const auto encoding, textAttribute(file.root(), "iterationEncoding"));
    if (encoding.value_or("") == "variableBased") {
        MOTE_ASSIGN_OR_RETURN(layout.iterations, variableIteration(file, basePath));
    } else if (findPlaceholder(basePath)) {
        MOTE_ASSIGN_OR_RETURN(auto iterations, numberedIterations(file, basePath));
        layout.iterations = std::move(iterations);
    } else {
        MOTE_ASSIGN_OR_RETURN(const auto group, file.find(file.root(), join("/", inner(basePath))));
        if (group.has_value()) layout.iterations.push_back({0, join("/", inner(basePath)), false});
    }
    if (layout.iterations.empty()) {
        return notFound(file.name() + ":" + basePath, "the file has no iterations there");
    }
    return layout;
}

Result<std::vector<OpenpmdSpeciesPath>> listSpecies(const H5File& file, const OpenpmdLayout& layout,
                                                    const OpenpmdIteration& iteration) {
    std::vector<OpenpmdSpeciesPath> species = layout.bare;
    if (!species.empty()) return species;
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
