// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a live dataset gets further steps: their files are put beside those that are there, which never change,
// and then one rename puts a manifest that tells of them in place of the one before. Whoever reads meanwhile
// has the one or the other, both whole. docs/FORMAT.md, "Live datasets".
//
// GrowthLock: the right to add to a dataset, of one process at a time where the file system has locks; the
// kernel takes it back when the process ends, however it does. Move-only; one owner, one thread.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {

class GrowthLock {
  public:
    /// `dataset` is a real path, or one that is looked up anew. Errors: notFound, permissionDenied,
    /// alreadyExists (another process has it).
    static Result<GrowthLock> take(const std::filesystem::path& dataset);

    const std::filesystem::path& dataset() const { return dataset_; }
    int folder() const { return folder_.get(); }

  private:
    GrowthLock(std::filesystem::path dataset, FileDescriptor folder)
        : dataset_(std::move(dataset)), folder_(std::move(folder)) {}

    std::filesystem::path dataset_;
    FileDescriptor folder_;
};

/// Whether `next` is what `now`, of a live dataset, becomes by further steps, or by none: the same plot of
/// the same run, whose steps and files are those of before and more. Errors: invalidArgument, with the field.
Status checkGrowth(const proto::Manifest& now, const proto::Manifest& next);

/// Whether a folder's manifest names no other files than its own, so that it can be a dataset by itself.
/// Errors: notFound (a file), corrupt (the manifest).
Status checkBegins(const std::filesystem::path& draft);

/// Whether a file of this name may be left of a step that was not put in.
bool isOfSomeStep(const std::string& name);

/// Gives the files of the folder `draft`, which are on the disk, their place in the live dataset, and then
/// its manifest. A file that stands in no manifest, from somebody who was killed on the way, is replaced;
/// when the dataset is no more live, those that are left go. Errors: as checkGrowth, notFound, corrupt (a
/// manifest), permissionDenied, resourceExhausted, internal; the dataset is what it was then.
Status growDataset(const std::filesystem::path& draft, const GrowthLock& lock);

}  // namespace mote::storage
