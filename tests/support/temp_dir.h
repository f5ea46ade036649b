// SPDX-License-Identifier: GPL-3.0-or-later
//
// TempDir: a fresh folder for one test, removed with all that is in it when the object goes. One owner.
#pragma once

#include <filesystem>

namespace mote::test {

class TempDir {
  public:
    /// Throws std::filesystem::filesystem_error where no folder can be made.
    TempDir();
    ~TempDir();
    TempDir(const TempDir&) = delete;
    TempDir& operator=(const TempDir&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
};

}  // namespace mote::test
