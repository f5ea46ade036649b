// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeSource: one volume in a foreign format, read in slabs of z as floats. Owned by the job; used from one
// thread at a time. Untrusted bytes become Errors that name file and field; no size that a file declares is
// believed before it is checked against the file, and none of the volume is held but what is asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/volume/volume_shape.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

class VolumeSource {
  public:
    virtual ~VolumeSource() = default;
    virtual std::string format() const = 0;  ///< as in --format
    virtual const VolumeShape& shape() const = 0;
    /// The time of the volume, s, if the file says it.
    virtual std::optional<double> time() const { return shape().time; }
    /// What was found only while values were read, a sentence each, told once.
    virtual std::vector<std::string> takeNotes() { return {}; }
    /// Whether slabs are best asked for in ascending z: going back decompresses the file from its beginning.
    virtual bool sequential() const = 0;
    /// The values of slices [z0, z1), x fastest, slope and intercept of the file applied. 32-bit integers and
    /// doubles are rounded to float; values that are not finite stay so. `values` holds voxelsOfSlice()
    /// times z1 - z0. Errors: corrupt (the data end early, go on behind the last slice, or are damaged),
    /// internal, resourceExhausted.
    virtual Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) = 0;
};

struct DicomLook;  // dicom/dicom_volume.h

/// A step of a series: what it is made of, and how its volume is opened.
struct VolumeStep {
    std::filesystem::path input;  ///< a path of the file system
    proto::VolumeSourceOptions options;
    std::vector<std::filesystem::path> others;   ///< of DICOM pictures that were given one by one
    std::shared_ptr<const DicomLook> look = {};  ///< of DICOM files that were looked at for all steps
};

/// Opens a volume: format by `options.format()` or by content. Places are in the space that
/// `options.space()` names (volume_shape.h); `options.spacing()` and `origin()` go before what the file says.
/// What was assumed is noted. `progress` must outlive the source. Errors: notFound, permissionDenied,
/// unsupported (an unknown format, vectors, several volumes), corrupt, invalidArgument (an option),
/// resourceExhausted, cancelled.
Result<std::unique_ptr<VolumeSource>> openVolumeSource(const VolumeStep& step, Progress& progress);
/// The same of one input.
Result<std::unique_ptr<VolumeSource>> openVolumeSource(const proto::VolumeSourceOptions& options,
                                                       const std::filesystem::path& input,
                                                       Progress& progress);

/// One of several things in a file that a job may be asked for.
struct VolumeField {
    std::string name;              ///< as in --field
    std::uint64_t components = 1;  ///< values at each place, of which it is one, or which it is made of
    std::string type = {};         ///< of the stored numbers, in the file's own word
};

/// Those of a file of several arrays, grids or records, the one that is read without a name first; none of a
/// file that holds one, or that cannot be read: opening it says why. `format`: as in --format.
struct VolumeFields {
    std::string format;
    std::vector<VolumeField> fields;
};
VolumeFields volumeFields(const proto::VolumeSourceOptions& options, const std::filesystem::path& input,
                          const Progress& progress);

/// What tells a format, as of VolumeSource::format, for people: "its first bytes NRRD".
std::string_view toldOfVolume(std::string_view format);

/// Makes a step of each input, but for files of several volumes and openPMD's of several iterations, which
/// are a step each, and files of one DICOM picture each, which are one together. Errors: as openVolumeSource,
/// of openPMD's.
Result<std::vector<VolumeStep>> volumeSteps(const proto::VolumeSourceOptions& options,
                                            const std::vector<std::filesystem::path>& inputs);

}  // namespace mote::prep
