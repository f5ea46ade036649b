// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/export_vdb.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "preprocess/export_grids.h"
#include "storage/files/write_file.h"
#include "storage/vdb/vdb_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// A file beside its final place, removed unless it got there.
class PartialFile {
  public:
    explicit PartialFile(const fs::path& output) : path_(output) {
        path_ += fmt::format(".partial-{}", ::getpid());
    }
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;
    ~PartialFile() { ::unlink(path_.c_str()); }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

struct GridMaker {
    std::string_view kind;  ///< of the dataset
    std::string_view what;
    Result<VdbGrids> (*make)(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step);
};

constexpr std::array makers{GridMaker{"particles", "density", densityGrids},
                            GridMaker{"hybrid", "volume", hybridGrids}};

}  // namespace

Result<std::string> exportVdb(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step,
                              const fs::path& output) {
    std::error_code code;
    if (fs::exists(fs::symlink_status(output, code))) {
        return Error{ErrorCode::alreadyExists, output.string(), "exists already and is never replaced"};
    }
    const auto* const maker = std::ranges::find(makers, manifest.kind(), &GridMaker::kind);
    if (maker == makers.end()) {
        return Error{ErrorCode::invalidArgument, dataset.string(),
                     fmt::format("is a dataset of kind \"{}\", which holds no volume", manifest.kind())};
    }
    MOTE_ASSIGN_OR_RETURN(const auto grids, maker->make(dataset, manifest, step));
    const PartialFile partial(output);
    MOTE_RETURN_IF_ERROR(storage::writeVdbFile(partial.path(), grids));
    MOTE_RETURN_IF_ERROR(storage::syncPath(partial.path()));
    MOTE_RETURN_IF_ERROR(storage::publishByRename(partial.path(), output));
    return std::string(maker->what);
}

}  // namespace mote::prep
