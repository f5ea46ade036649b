// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/dataset_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "preprocess/particles/plot_axis.h"
#include "storage/beam/beam_statistics.h"
#include "storage/manifest.h"
#include "storage/particles/particle_columns.h"
#include "storage/storage_error.h"

namespace mote::prep {
namespace {

class DatasetSource final : public ParticleSource {
  public:
    DatasetSource(std::filesystem::path directory, proto::Manifest manifest)
        : directory_(std::move(directory)), manifest_(std::move(manifest)) {
        for (const auto& step : particles().steps()) {
            steps_.push_back({(directory_.filename() / step.file()).string(), step.iteration(), step.time(),
                              step.particles()});
        }
        for (const auto& column : particles().columns()) {
            const bool own = column.name() != "lost" && findKnownQuantity(column.name()) == nullptr;
            if (own && records_.size() < mostRecords) records_.push_back({column.name(), column.unit()});
        }
    }

    std::string format() const override { return "mote"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    double mass() const override { return particles().mass(); }
    std::string species() const override { return particles().species(); }
    double particleCharge() const override { return particles().particle_charge(); }
    std::string weightUnit() const override { return particles().weight_unit(); }
    std::string lostParticles() const override { return particles().lost_particles(); }

    bool has(Column column) const override {
        return column == Column::id ? particles().ids() : indexOf(column).has_value();
    }

    std::vector<SourceRecord> records() const override { return records_; }

    std::vector<double> statistics(std::size_t step) const override {
        const auto names = mote::statistics();
        const auto same = [](const Statistic& a, const std::string& b) { return a.name == b; };
        if (!std::ranges::equal(names, particles().statistic_names(), same)) return {};
        const auto& values = particles().steps(static_cast<int>(step)).statistics();
        return {values.begin(), values.end()};
    }

    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override {
        if (!open_ || openStep_ != step) {
            MOTE_ASSIGN_OR_RETURN(open_, storage::ParticleColumns::open(directory_, manifest_,
                                                                        static_cast<std::uint32_t>(step)));
            openStep_ = step;
        }
        try {
            readOpen(begin, count, wanted, chunk);
            open_->check();
        } catch (const storage::StorageError& error) {
            return error.error();
        }
        return success();
    }

  private:
    const proto::ParticlesManifest& particles() const { return manifest_.particles(); }

    std::optional<std::size_t> indexOf(Column column) const {
        const auto& all = particles().columns();
        const auto found = std::ranges::find(all, columnName(column, *this), &proto::ColumnEntry::name);
        if (found == all.end()) return std::nullopt;
        return static_cast<std::size_t>(found - all.begin());
    }

    void readOpen(std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                  ParticleChunk& chunk) const {
        chunk.begin = begin;
        chunk.size = count;
        chunk.lost.clear();
        // A dataset of lost particles alone says so of each.
        if (particles().lost_particles() == "only") chunk.lost.assign(count, 1);
        if (particles().lost_particles() == "with") readLost(begin, count, chunk);
        for (const auto column : wanted) {
            if (column == Column::id) {
                const auto ids = open_->ids(begin, count);
                chunk.id.assign(ids.begin(), ids.end());
                continue;
            }
            auto& to = chunk[column];
            const auto index = indexOf(column);
            to.assign(index ? 0 : count, 1.0);  // missing weights
            if (!index) continue;
            to.resize(count);
            open_->read(*index, begin, to);
        }
    }

    void readLost(std::uint64_t begin, std::size_t count, ParticleChunk& chunk) const {
        const auto column = open_->find("lost");
        std::vector<double> marks(column ? count : 0);
        if (column) open_->read(*column, begin, marks);
        for (const double mark : marks) chunk.lost.push_back(mark != 0.0 ? 1 : 0);
    }

    std::filesystem::path directory_;
    proto::Manifest manifest_;
    std::vector<SourceStep> steps_;
    std::vector<SourceRecord> records_;
    std::size_t openStep_ = 0;
    std::shared_ptr<const storage::ParticleColumns> open_;
};

}  // namespace

bool isDataset(const std::vector<std::filesystem::path>& inputs) {
    std::error_code code;
    return inputs.size() == 1 && std::filesystem::is_regular_file(inputs[0] / storage::manifestName, code);
}

Result<std::unique_ptr<ParticleSource>> openDataset(const proto::ParticlesJob& job,
                                                    const std::filesystem::path& directory) {
    const auto name = directory.filename().string();
    if (!job.species().empty()) return invalid("species", "only openPMD files have species");
    if (!job.format().empty() && job.format() != "auto") {
        return invalid("format", fmt::format("{} is a dataset of Mote; leave the format out", name));
    }
    MOTE_ASSIGN_OR_RETURN(auto manifest, storage::readManifest(directory));
    if (!manifest.has_particles()) {
        return Error{ErrorCode::unsupported, name, "is a dataset without particles"};
    }
    const auto& particles = manifest.particles();
    if (particles.columns().empty()) {
        return Error{
            ErrorCode::notFound, name,
            "has no columns to plot again; make it anew with mote-prep particles, from the files that "
            "it was made from, without --columns none"};
    }
    const std::string has = particles.lost_particles().empty() ? "without" : particles.lost_particles();
    if (!job.lost().empty() && job.lost() != has) {
        return invalid("lost", fmt::format("{} was made {} lost particles, which cannot be changed from its "
                                           "columns; name the files that it was made from",
                                           name, has == "only" ? "of only" : has));
    }
    return std::unique_ptr<ParticleSource>(std::make_unique<DatasetSource>(directory, std::move(manifest)));
}

}  // namespace mote::prep
