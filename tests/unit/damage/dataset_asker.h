// SPDX-License-Identifier: GPL-3.0-or-later
//
// A DatasetAsker asks of a sample dataset what clients ask the server: small pictures, by the server's own
// way from a view to pixels, and numbers. All is opened anew for each question. One thread.
#pragma once

#include <filesystem>
#include <memory>

#include "tests/support/random.h"
#include "tests/unit/damage/sample_datasets.h"

namespace mote::test {

class DatasetAsker {
  public:
    /// `folder` has "sample.mote" and its companions.
    DatasetAsker(const SampleDataset& sample, const std::filesystem::path& folder);
    ~DatasetAsker();
    DatasetAsker(const DatasetAsker&) = delete;
    DatasetAsker& operator=(const DatasetAsker&) = delete;

    std::size_t questions() const;
    /// How it is asked is left to `random`: with a bound on memory or without, for a view at rest or in
    /// motion. Throws storage::StorageError, as what is damaged does, and nothing else.
    void ask(std::size_t question, Random& random);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::test
