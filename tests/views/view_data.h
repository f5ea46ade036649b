// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewData: the data of generated views. A dataset's name says all of it, "views/KIND-NUMBER", so a view in a
// file is enough to draw it again: nothing, one particle, beams, constant and random volumes, hybrid volumes
// of every form, dots, meshes. Made at first use and kept; one owner, one thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "server/render/layers/scene.h"
#include "tests/support/memory_run.h"
#include "tests/support/random.h"

namespace mote::test {

enum class DataKind { particles, hybrid, dots, mesh, image };

struct DatasetName {
    DataKind kind = DataKind::particles;
    std::string form;          ///< "beam", "machine", "sphere", ...
    std::uint32_t number = 0;  ///< what else differs

    /// "views/beam-3".
    std::string toString() const;
};

/// What a style and a camera ask of a dataset.
struct DatasetTraits {
    Bounds bounds;                                              ///< layer space
    ValueRange range{0.0, 1.0};                                 ///< of a hybrid volume
    HybridRepresentation parts = HybridRepresentation::volume;  ///< likewise: what sets it right
};

class ViewData {
  public:
    /// Steps of each dataset.
    static constexpr std::uint32_t steps = 3;
    static constexpr std::uint32_t numbers = 12;

    static DatasetName any(Random& random, DataKind kind);
    /// Errors: notFound.
    static Result<DatasetName> find(const std::string& name, DataKind kind);
    static DatasetTraits traits(const DatasetName& name);

    /// Of a view between steps, which is the mean of several scenes, that of the nearer steps. Errors: the
    /// view's own; a dataset or step that is none of these, of another kind than its layer, or without what
    /// is drawn of it.
    Result<render::Scene> scene(const proto::View& message);

  private:
    Status add(const Layer& layer, render::Scene& scene, render::Dots& dots);
    std::shared_ptr<const MemoryStep> particles(const DatasetName& name, std::uint32_t step);
    /// A dataset's steps with their numbers.
    const MemoryRun& run(const DatasetName& name);
    std::shared_ptr<const render::GridField> hybrid(const DatasetName& name, std::uint32_t step);
    std::shared_ptr<const render::MeshSurface> mesh(const DatasetName& name, std::uint32_t step);

    std::map<std::string, std::shared_ptr<const MemoryStep>> particles_;
    std::map<std::string, std::shared_ptr<const MemoryRun>> runs_;
    std::map<std::string, std::shared_ptr<const render::GridField>> hybrids_;
    std::map<std::string, std::shared_ptr<const render::MeshSurface>> meshes_;
};

}  // namespace mote::test
