// SPDX-License-Identifier: GPL-3.0-or-later
//
// The kinds of datasets: what storage, mote-prep and the server's catalogue must know of each, said once in
// the kind's own folder and read here. What clients too must know of a kind stands in
// protocol/scene/dataset.h. Constants; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::storage {

class DatasetVerifier;  // verify.h

/// The files that a manifest names.
using FileNames = std::set<std::string_view>;

/// What a dataset holds, for who made it.
struct DatasetSummary {
    std::string text;  ///< "10 steps, 1000 particles in leaves"
    /// The same and more as numbers, in the order in which they are printed.
    std::vector<std::pair<std::string_view, std::variant<std::uint64_t, double>>> numbers;
};

struct DatasetKind {
    std::string_view name;  ///< as in Manifest.kind
    /// Whether a manifest has what this kind's is to have.
    bool (proto::Manifest::*described)() const;
    /// Whether the fields are in range, agree with each other and name files that there are; no file is
    /// looked at. Errors: corrupt, with the field's path.
    Status (*check)(const proto::Manifest& manifest, const FileNames& files);
    /// Verifies every file of a checked manifest and what only its reader can say of it.
    void (*verify)(DatasetVerifier& verifier);
    /// Lines of `mote-prep info` behind those of every dataset.
    std::string (*describe)(const proto::Manifest& manifest);
    DatasetSummary (*summarize)(const proto::Manifest& manifest);
};

// Each is defined in its kind's folder, KIND_kind.cpp.
extern const DatasetKind particlesKind, hybridKind, stippleKind, meshKind, imageKind;

inline constexpr std::array datasetKinds{&particlesKind, &hybridKind, &stippleKind, &meshKind, &imageKind};

/// nullptr if this version has no such kind, or the manifest lacks what it is to have.
inline const DatasetKind* findKind(const proto::Manifest& manifest) {
    for (const auto* kind : datasetKinds) {
        if (kind->name == manifest.kind() && (manifest.*kind->described)()) return kind;
    }
    return nullptr;
}

/// "1 step", "2 steps".
inline std::string stepsText(int steps) {
    return std::to_string(steps) + (steps == 1 ? " step" : " steps");
}

}  // namespace mote::storage
