// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets of each kind, and what they are drawn as. Plain functions.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mote::test {

struct SampleDataset {
    std::string name;
    void (*write)(const std::filesystem::path& output);  ///< publishes "NAME.mote"
    /// Layers that it is drawn as, each alone, as a user writes them (tests/support/view_text.h). They call
    /// it "sample"; a photograph is stippled with "picture" or "plane" (writeCompanions()).
    std::vector<std::string> layers;
    bool large = false;    ///< so that not every byte of it can be changed
    bool counted = false;  ///< numbers are asked of it, too
};

/// One of each kind, some KiB each.
const std::vector<SampleDataset>& sampleDatasets();
/// Up to some MiB; one array spans blocks of its digest.
const std::vector<SampleDataset>& largeDatasets();

/// Publishes "picture.mote" and "plane.mote" in the folder.
void writeCompanions(const std::filesystem::path& folder);

}  // namespace mote::test
