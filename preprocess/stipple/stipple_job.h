// SPDX-License-Identifier: GPL-3.0-or-later
//
// The stipple job: a dataset of kind "stipple" from nothing but a number of points and a seed (the plane), or
// from a mesh besides. The plane's points start at random, one in each of as many equal boxes, made even by
// Lloyd's method with over-relaxation. Called from one thread. The same request gives the same bytes on any
// number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/stipple/thinning.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Points on the unit square, neighbours in the list near each other. At least one.
std::vector<glm::dvec2> stratifiedPoints(std::uint32_t points, std::uint64_t seed);

/// Does one step of Lloyd's method on the periodic square, each point going `relaxation` times the way to its
/// cell's centroid. The same on any number of threads.
std::vector<glm::dvec2> relaxOnce(const std::vector<glm::dvec2>& points, double relaxation);

/// stratifiedPoints, relaxed until they are as even as after 50 steps of Lloyd's method or more. Reports
/// progress from 0 to `share`. Errors: cancelled.
Result<std::vector<glm::dvec2>> evenPoints(std::uint32_t points, std::uint64_t seed, double share,
                                           Progress& progress);

/// What can be said of a request before its mesh is looked at. Errors: invalidArgument with the field's
/// path.
Status checkStippleJob(const proto::StippleJob& job);

/// The job's own numbers, or the defaults.
ThinningOptions thinningOptions(const proto::StippleJob& job);

/// Whether a job of this many bytes a point may be done. Errors: resourceExhausted, which says what is
/// missing.
Status checkStippleMemory(const proto::StippleJob& job, std::uint64_t bytesPerPoint,
                          const JobResources& resources);

/// The manifest of what `request` made, but for its files; without a mesh in the request.
proto::Manifest describeHierarchy(const proto::JobRequest& request,
                                  const storage::StippleHierarchy& hierarchy,
                                  proto::StippleManifest::Domain domain, double area,
                                  const std::string& title);

/// A hierarchy on the periodic unit square: makes `output`, which appears by one rename. Returns its
/// manifest. Errors: invalidArgument, alreadyExists, permissionDenied, resourceExhausted (memory, disk),
/// cancelled.
Result<proto::Manifest> runPlaneJob(const proto::JobRequest& request, const std::filesystem::path& output,
                                    const JobResources& resources, Progress& progress);

}  // namespace mote::prep
