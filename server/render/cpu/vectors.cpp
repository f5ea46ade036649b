// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/vectors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hwy/targets.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdlib>

#include "server/render/device.h"

namespace mote::render {
namespace {

std::atomic<bool> chosen = false;

/// Highway's own list, as it is before one of them is chosen.
const std::vector<std::int64_t>& targetsHere() {
    static const auto targets = hwy::SupportedAndGeneratedTargets();
    return targets;
}

std::string nameOf(std::int64_t target) {
    const std::string name = hwy::TargetName(target);
    return name.starts_with("AVX3") ? "AVX-512" : name;
}

std::string inLowerCase(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace

std::string vectorName() {
    return nameOf(hwy::SupportedTargets() & -hwy::SupportedTargets());
}

std::vector<std::string> vectorNames() {
    std::vector<std::string> names;
    for (const std::int64_t target : targetsHere()) names.push_back(nameOf(target));
    return names;
}

std::optional<std::int64_t> vectorsNamed(const std::string& name) {
    const auto& targets = targetsHere();
    const auto found = std::find_if(targets.begin(), targets.end(), [&](std::int64_t target) {
        return inLowerCase(nameOf(target)) == inLowerCase(name);
    });
    if (found == targets.end()) return std::nullopt;
    return *found;
}

void useVectors(std::int64_t target) {
    targetsHere();
    chosen = true;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

void useVectorsOfEnvironment() {
    const char* const name = std::getenv("MOTE_VECTORS");
    const auto target = name == nullptr ? std::optional<std::int64_t>(0) : vectorsNamed(name);
    if (!target) {
        throw DeviceError(fmt::format("MOTE_VECTORS is \"{}\", but the vectors that are here are {}", name,
                                      fmt::join(vectorNames(), ", ")));
    }
    useVectors(*target);
}

void chooseVectors() {
    if (!chosen) useVectorsOfEnvironment();
}

}  // namespace mote::render
