// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmDatasets: what a film must know of the datasets that it shows: which there are, how many steps they
// have and where they lie. A value that who plans a film fills from a catalogue and its manifests. Pure
// functions.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/space/metres.h"
#include "protocol/scene/view.h"

namespace mote {

struct FilmDataset {
    Bounds bounds = plotBounds;           ///< layer space, as datasetBounds() tells
    int steps = 0;                        ///< as stepCount() tells: 0 of a dataset without time
    std::optional<Outlook> outlook = {};  ///< as datasetOutlook() tells
    DatasetPlace place = {};              ///< as datasetPlace() tells
};

/// By "ROOT/NAME". It may hold more than a film shows: an error names what there is. Where a film leaves no
/// camera to be fitted, no bounds are asked for.
using FilmDatasets = std::map<std::string, FilmDataset>;

/// Whether all that a view shows is there. Errors: notFound ("layers[0].dataset", "layers[0].stipple.image"),
/// invalidArgument ("layers[0].step", "layers[0].towards.step").
Status checkDatasets(const proto::View& view, const FilmDatasets& datasets);

/// Whether a dataset has a step. Errors: invalidArgument, named by `field`.
Status checkStep(const std::string& dataset, const FilmDataset& known, std::uint32_t step,
                 std::string_view field);

/// Places the layers of a view in metres, as placeLayers(); of a dataset that is not known as if it lay in
/// metres itself.
Status placeAmong(View& view, const FilmDatasets& datasets);

/// Fits the camera of a view that came without one, whose datasets are all known, to their boxes: of what a
/// server shows it fits it to what is seen in them. Errors: those of placeLayers().
Status fitToDatasets(View& view, const FilmDatasets& datasets);

}  // namespace mote
