// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/known_datasets.h"

#include "protocol/scene/dataset.h"

namespace mote::client {

FilmDatasets knownDatasets(const proto::Catalogue& catalogue) {
    FilmDatasets datasets;
    for (const auto& entry : catalogue.datasets())
        datasets[entry.name()] = {plotBounds, static_cast<int>(entry.steps())};
    return datasets;
}

FilmDataset knownDataset(const proto::Manifest& manifest) {
    return {datasetBounds(manifest), stepCount(manifest)};
}

}  // namespace mote::client
