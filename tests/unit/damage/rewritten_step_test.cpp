// SPDX-License-Identifier: GPL-3.0-or-later
//
// A step whose files are rewritten in place while it is drawn, selected from and counted: errors are right,
// and so are pictures of nobody's points; a death is not, nor is memory that is not the step's.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/layers/particles/point_data.h"
#include "storage/blocks/block_budget.h"
#include "storage/blocks/mapped_file.h"
#include "storage/manifest.h"
#include "storage/numbers/dataset_steps.h"
#include "storage/numbers/histogram.h"
#include "storage/numbers/select_points.h"
#include "storage/particles/selected_step.h"
#include "storage/storage_error.h"
#include "tests/support/any_selection.h"
#include "tests/support/temp_dir.h"
#include "tests/support/view_text.h"
#include "tests/unit/damage/damaged_dataset.h"
#include "tests/unit/damage/rewritten_file.h"
#include "tests/unit/damage/sample_datasets.h"

namespace mote::test {
namespace {

using storage::StorageError;

constexpr std::uint64_t points = 20000;
constexpr std::uint32_t rewrittenLeaf = 16;

class RewrittenStep : public testing::Test {
  protected:
    RewrittenStep() {
        storage::catchMappingFaults();
        run_ = cloudRun(5, points, 2, 4);
        writeRun(*run_, dataset_);
        manifest_ = std::make_shared<const proto::Manifest>(*storage::readManifest(dataset_));
    }

    storage::StepNumbers open(std::shared_ptr<storage::BlockBudget> budget) const {
        const storage::DatasetSteps steps(dataset_, manifest_, std::move(budget));
        return *steps.step(0);
    }
    /// Every byte of octree and leaves in the file becomes one that points beyond everything.
    void overwriteTree() const {
        const RewrittenFile file(dataset_ / "step-000000.h5");
        file.write(0, std::string(file.original().size(), '\xff'));
    }

    TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "cloud.mote";
    std::shared_ptr<const MemoryRun> run_;
    std::shared_ptr<const proto::Manifest> manifest_;
};

/// `more`: fields of the layer.
render::Scene sceneOf(std::shared_ptr<const storage::ParticleStep> step, const std::string& more = "") {
    const std::string shown = "'linked': false, 'curve': [{'density': 0, 'fraction': 1}]";
    return {viewOf("{'width': 96, 'height': 64, 'camera': {'eye': [1, 2, 4], 'target': [0, 0, 0]}, "
                   "'layers': [{'particles': {'points': {" +
                   shown + "}}" + more + "}]}"),
            {{.step = std::move(step)}}};
}

void draw(const render::Scene& scene, render::Device& device) {
    render::SelectionCache selections;
    const auto plan = makeFramePlan(scene, render::Quality::exact(), selections, device.abilities());
    device.render(plan, render::PixelFormat::srgb8, {});
    scene.layers[0].step->check();
}

Selection lasso() {
    Selection selection;
    selection.lasso = Selection::Lasso{
        sceneOf(nullptr).view.camera, 1.5, glm::dmat4(1.0), {{0.2, 0.2}, {0.8, 0.3}, {0.5, 0.9}}};
    return selection;
}

/// What is asked of a step; each may end in an error.
class Asker {
  public:
    Asker(const storage::RunSteps& run, storage::StepNumbers step) : run_(run), step_(std::move(step)) {}

    void ask(std::uint64_t what, Random& random) {
        switch (what % 7) {
            case 0:
                return draw(sceneOf(step_.points), device_);
            case 1:
                return select(lasso());
            case 2:
                return select(anySelection(
                    random,
                    {.columns = {{"x", 0.0, 1.0}, {"px", -1.0, 1.0}}, .ids = 3 * points, .steps = 2}));
            case 3:
                return told(
                    storage::countHistogram({{"x", 50, 0.0, 1.0}}, random.chance(0.5), step_, nullptr, {}));
            case 4:
                return told(storage::countHistogram({{"x", 20, 0.0, 1.0}, {"px", 30, -1.0, 1.0}}, true, step_,
                                                    nullptr, {}));
            case 5:
                return drawByColumn();
            default: {
                const std::uint64_t ids[] = {3, 300, 3000};
                return told(render::pointPaths(run_, ids, {}));
            }
        }
    }
    std::uint64_t errors() const { return errors_; }
    void count() { ++errors_; }

  private:
    template <class T>
    void told(const Result<T>& result) {
        if (!result.ok()) ++errors_;
    }

    void select(const Selection& selection) {
        const auto mask = storage::selectPoints(selection, run_, 0, {});
        told(mask);
        if (!mask.ok()) return;
        const auto some = storage::SelectedStep::make(*step_.points, *mask, rewrittenLeaf, {});
        told(some);
        if (some.ok()) draw(sceneOf(*some), device_);
    }

    void drawByColumn() {
        auto scene = sceneOf(step_.points, ", 'colorBy': {'column': 'px', 'range': [-1, 1]}");
        auto values = render::pointValues(step_, "px", {-1.0, 1.0}, {}, {});
        told(values);
        if (!values.ok()) return;
        scene.layers[0].values = *values;
        draw(scene, device_);
    }

    const storage::RunSteps& run_;
    const storage::StepNumbers step_;
    render::CpuDevice device_{{2}};
    std::uint64_t errors_ = 0;
};

TEST_F(RewrittenStep, TheOctreeStaysWhatItWasWhenItWasChecked) {
    const auto step = open(nullptr);
    step.points->leaves();
    overwriteTree();
    const auto& expected = *run_->at(0).points;
    const auto nodes = step.points->nodes();
    const auto leaves = step.points->leaves();
    EXPECT_TRUE(std::ranges::equal(nodes.firstChild, expected.nodes().firstChild));
    EXPECT_TRUE(std::ranges::equal(nodes.childCount, expected.nodes().childCount));
    EXPECT_TRUE(std::ranges::equal(nodes.morton, expected.nodes().morton));
    EXPECT_TRUE(std::ranges::equal(leaves.node, expected.leaves().node));
    EXPECT_TRUE(std::ranges::equal(leaves.pointBegin, expected.leaves().pointBegin));
    EXPECT_TRUE(std::ranges::equal(leaves.pointCount, expected.leaves().pointCount));
}

TEST_F(RewrittenStep, ASelectionOfAnOverwrittenStepIsBuiltOfItsOwnTree) {
    const auto step = open(nullptr);
    step.points->leaves();
    overwriteTree();
    storage::PointMask all(points);
    for (std::uint64_t i = 0; i < points; ++i) all.choose(i);
    try {
        const auto some = storage::SelectedStep::make(*step.points, all, rewrittenLeaf, {});
        ASSERT_TRUE(some.ok());
        EXPECT_TRUE(
            std::ranges::equal((*some)->leaves().pointCount, run_->at(0).points->leaves().pointCount));
    } catch (const StorageError& error) {
        EXPECT_EQ(error.error().code, ErrorCode::corrupt);
    }
    EXPECT_THROW(step.points->check(), StorageError);
}

TEST_F(RewrittenStep, AnIdThatNamesNoPointIsAnError) {
    const auto step = open(nullptr);
    step.columns->pointsById(0, points);
    const RewrittenFile file(dataset_ / "columns-000000.h5");
    file.write(0, std::string(file.original().size(), '\xff'));
    EXPECT_THROW(step.columns->pointOfRank(7), StorageError);
}

TEST_F(RewrittenStep, WhatIsDrawnAndCountedMeanwhileEndsInErrors) {
    constexpr std::uint64_t rounds = 14, asked = 7, written = 400, room = 400 << 10;
    const RewrittenFile step(dataset_ / "step-000000.h5"), columns(dataset_ / "columns-000000.h5");
    const auto otherStep = bytesOfFile(dataset_ / "step-000001.h5");
    const auto otherColumns = bytesOfFile(dataset_ / "columns-000001.h5");
    std::uint64_t errors = 0, writes = 0;
    for (std::uint64_t round = 0; round < rounds; ++round) {
        step.restore();
        columns.restore();
        // With room for little more than the octree, blocks come and go; the octree too.
        const auto budget = round % 2 == 0 ? nullptr : std::make_shared<storage::BlockBudget>(room);
        const storage::DatasetSteps run(dataset_, manifest_, budget);
        const auto opened = run.step(0);
        ASSERT_TRUE(opened.ok()) << opened.error().toString();
        Random random(round, 7);
        Asker asker(run, *opened);
        try {
            opened->points->leaves();  // checked before the writer begins
        } catch (const StorageError& error) {
            FAIL() << error.what();
        }
        std::atomic<bool> done{false};
        std::thread writer([&, random = Random(round, 8)]() mutable {
            for (std::uint64_t i = 0; i < written && !done; ++i, ++writes) {
                if (random.chance(0.7)) {
                    disturb(step, otherStep, random);
                } else {
                    disturb(columns, otherColumns, random);
                }
            }
        });
        for (std::uint64_t i = 0; i < asked; ++i) {
            if (budget) budget->beginGeneration();
            try {
                asker.ask(round + i, random);
            } catch (const StorageError&) {
                asker.count();
            }
        }
        done = true;
        writer.join();
        errors += asker.errors();
    }
    fmt::print("{} questions, {} writes in place, {} errors, 0 deaths\n", rounds * asked, writes, errors);
}

}  // namespace
}  // namespace mote::test
