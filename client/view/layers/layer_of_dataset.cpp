// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/layer_of_dataset.h"

namespace mote::client {
namespace {

struct Kind {
    std::string_view dataset;
    proto::Layer::KindCase layer;
};

constexpr Kind kinds[] = {
    {"particles", proto::Layer::kParticles},
    {"hybrid", proto::Layer::kHybrid},
    {"stipple", proto::Layer::kStipple},
};

}  // namespace

proto::Layer::KindCase layerOfDataset(std::string_view kind) {
    for (const auto& each : kinds) {
        if (each.dataset == kind) return each.layer;
    }
    return proto::Layer::kParticles;
}

}  // namespace mote::client
