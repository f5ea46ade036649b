// SPDX-License-Identifier: GPL-3.0-or-later
//
// TemporaryFolder: a fresh folder that only this user may enter, removed with all it holds when the object
// goes. Not copied; any thread.
#pragma once

#include <filesystem>
#include <string_view>

namespace mote::client {

class TemporaryFolder {
  public:
    /// Throws std::system_error.
    explicit TemporaryFolder(std::string_view prefix);
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace mote::client
