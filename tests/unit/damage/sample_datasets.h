// SPDX-License-Identifier: GPL-3.0-or-later
//
// A small dataset of each kind. Plain functions.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mote::test {

struct SampleDataset {
    std::string name;
    void (*write)(const std::filesystem::path& output);  ///< publishes "NAME.mote"
};

const std::vector<SampleDataset>& sampleDatasets();

}  // namespace mote::test
