// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <set>

#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/openpmd/species.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"

namespace mote::prep {
namespace {

/// Where a step's particles lie. An iteration without the species is an empty step.
struct OpenpmdPlace {
    std::filesystem::path file;
    std::string root;  ///< the group in the file that is the root of openPMD
    std::string iteration;
    std::optional<std::string> species;
    bool readsAtOnce = true;  ///< of an empty step nothing is read
    OpenpmdSpecies::Kept kept = {};
};

class OpenpmdSource : public SeriesSource {
  public:
    OpenpmdSource(std::string species, double mass, Progress& progress)
        : SeriesSource("openpmd", progress), wantedSpecies_(std::move(species)), wantedMass_(mass) {}

    double mass() const override { return mass_; }
    std::string species() const override { return species_; }
    double particleCharge() const override { return particleCharge_; }
    std::string weightUnit() const override { return weightUnit_; }
    bool readsAtOnce(std::size_t step) const override { return places_[step].readsAtOnce; }
    std::uint64_t keptBytes(std::size_t step, std::size_t threads) const override {
        return places_[step].kept.first + (threads - 1) * places_[step].kept.more;
    }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    bool anyRead() const override { return anySpecies_; }
    Status finish() override;
    bool hasEverywhere(Column column) const override {
        const auto i = static_cast<std::size_t>(column);
        return found_[i] && !absentSomewhere_[i];
    }
    std::vector<SourceRecord> recordsEverywhere() const override { return records_; }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    Status addIteration(const H5File& file, OpenpmdPlace place, const OpenpmdLayout& layout,
                        const OpenpmdIteration& iteration);
    Result<std::optional<std::string>> choose(const H5File& file, const OpenpmdIteration& iteration,
                                              const std::vector<OpenpmdSpeciesPath>& all);
    void addSpecies(const OpenpmdSpecies& species, SourceStep& step);
    void addWeightUnit(const std::string& unit);
    Status openStep(std::size_t step);

    std::string wantedSpecies_;
    double wantedMass_;
    std::string absentAt_;          ///< the first iteration without the species, where others are
    std::set<std::string> others_;  ///< those that were met there and in later ones
    std::string othersText_;        ///< the same, in their order
    std::vector<OpenpmdPlace> places_;
    bool found_[columnCount] = {}, absentSomewhere_[columnCount] = {};
    bool anyParticles_ = false, anySpecies_ = false;
    bool anyWithout_ = false;            ///< some iteration holds no such particles
    std::vector<SourceRecord> records_;  ///< of all steps with particles
    double mass_ = 0.0, particleCharge_ = 0.0;
    std::string species_;
    std::string weightUnit_;  ///< of all steps with particles; empty where they differ

    // Of the step that was read last.
    std::mutex opening_;  ///< of those below
    std::size_t openStep_ = static_cast<std::size_t>(-1);
    std::optional<H5File> openFile_;
    std::filesystem::path openPath_;
    std::shared_ptr<const OpenpmdSpecies> open_;
};

Status OpenpmdSource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto root, findOpenpmdRoot(file));
    if (!root.empty()) {
        MOTE_RETURN_IF_ERROR(file.enter(root));
        noteOnce("the particles are those of the group " + root + " in the file");
    }
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    for (const OpenpmdIteration& iteration : layout.iterations) {
        if (progress_.cancelled()) return wasCancelled("cancelled while the steps were listed");
        MOTE_RETURN_IF_ERROR(leaveOut(addIteration(file, {path, root, "", {}}, layout, iteration)));
    }
    return success();
}

Status OpenpmdSource::addIteration(const H5File& file, OpenpmdPlace place, const OpenpmdLayout& layout,
                                   const OpenpmdIteration& iteration) {
    MOTE_ASSIGN_OR_RETURN(const auto all, listSpecies(file, layout, iteration));
    MOTE_ASSIGN_OR_RETURN(auto chosen, choose(file, iteration, all));
    SourceStep step;
    step.file = file.name();
    step.iteration = iteration.numbered ? iteration.number : fileNumber(place.file).value_or(0);
    if (chosen) {
        MOTE_ASSIGN_OR_RETURN(auto species, OpenpmdSpecies::open(file, *chosen, iteration.path, wantedMass_));
        addSpecies(species, step);
        place.readsAtOnce = species.readsAtOnce();
        place.kept = species.kept();
    } else {
        anyWithout_ = true;
    }
    steps_.push_back(std::move(step));
    place.iteration = iteration.path;
    place.species = std::move(chosen);
    places_.push_back(std::move(place));
    return success();
}

Result<std::optional<std::string>> OpenpmdSource::choose(const H5File& file,
                                                         const OpenpmdIteration& iteration,
                                                         const std::vector<OpenpmdSpeciesPath>& all) {
    if (all.empty()) return std::optional<std::string>();
    if (all.size() == 1 && (wantedSpecies_.empty() || wantedSpecies_ == all[0].name)) return {all[0].path};
    if (all.size() == 1 && all[0].name.empty()) {
        MOTE_ASSIGN_OR_RETURN(const auto group, file.require(file.root(), all[0].path));
        MOTE_ASSIGN_OR_RETURN(const auto type, textAttribute(group, "speciesType"));
        if (type.value_or("") == wantedSpecies_) return {all[0].path};
        return notFound(group.where, "holds no species '" + wantedSpecies_ + "' but one without a name" +
                                         (type ? " of type '" + *type + "'" : std::string()) +
                                         "; leave --species out");
    }
    std::string names;
    for (const OpenpmdSpeciesPath& species : all) {
        if (!wantedSpecies_.empty() && species.name == wantedSpecies_) return {species.path};
        names += (names.empty() ? "" : ", ") + species.name;
        if (others_.insert(species.name).second)
            othersText_ += (othersText_.empty() ? "" : ", ") + species.name;
    }
    const std::string where = file.name() + ":" + iteration.path;
    if (wantedSpecies_.empty()) {
        return invalid(where, "holds several species; choose one with --species: " + names);
    }
    // It may begin in a later iteration.
    if (absentAt_.empty()) absentAt_ = where;
    return std::optional<std::string>();
}

void OpenpmdSource::addSpecies(const OpenpmdSpecies& species, SourceStep& step) {
    anySpecies_ = true;
    step.particles = species.rows();
    step.time = species.time().value_or(0.0);
    for (const std::string& note : species.notes()) noteOnce(note);
    if (mass_ == 0.0) mass_ = species.mass();
    if (species.mass() > 0.0 && std::abs(species.mass() - mass_) > 1e-5 * mass_) {
        noteOnce("the steps differ in the particles' mass; that of the first is taken for all");
    }
    if (species_.empty()) species_ = species.species();
    if (particleCharge_ == 0.0) particleCharge_ = species.particleCharge();
    if (step.particles > 0 && species.particleCharge() != 0.0 &&
        std::abs(species.particleCharge() - particleCharge_) > 1e-5 * std::abs(particleCharge_)) {
        noteOnce("the steps differ in the particles' charge; that of the first is taken for all");
    }
    // What an empty step lacks is missed by no particle.
    if (step.particles == 0 && anyParticles_) return;
    if (step.particles > 0 && !anyParticles_) {
        std::fill(std::begin(found_), std::end(found_), false);
        std::fill(std::begin(absentSomewhere_), std::end(absentSomewhere_), false);
    }
    addWeightUnit(species.weightUnit());
    // A record that is damaged in some steps is missing there alone: NaN, which is no place in a plot.
    for (std::size_t i = 0; i < columnCount; ++i) {
        const auto column = static_cast<Column>(i);
        found_[i] = found_[i] || species.has(column);
        absentSomewhere_[i] = absentSomewhere_[i] || (!species.has(column) && !species.broken(column));
    }
    if (!anyParticles_) records_ = species.records();
    std::erase_if(records_, [&](const SourceRecord& record) {
        return std::ranges::count(species.records(), record.name, &SourceRecord::name) == 0;
    });
    if (step.particles > 0) anyParticles_ = true;
}

void OpenpmdSource::addWeightUnit(const std::string& unit) {
    if (!anyParticles_) weightUnit_ = unit;
    if (unit == weightUnit_) return;
    if (!unit.empty() && !weightUnit_.empty())
        noteOnce("weights count real particles in some steps and charge in others");
    weightUnit_.clear();
}

Status OpenpmdSource::finish() {
    if (!anySpecies_) {
        if (!absentAt_.empty())
            return notFound(absentAt_, "holds no species '" + wantedSpecies_ + "', but " + othersText_);
        return notFound(steps_.empty() ? "" : steps_.front().file,
                        "no iteration holds particles (a group with the record 'position' or 'momentum')");
    }
    if (anyWithout_) noteOnce("some iterations hold no such particles; they are empty steps");
    sortByIteration(places_);
    for (std::size_t i = 1; i < steps_.size(); ++i) {
        if (steps_[i].iteration != steps_[i - 1].iteration) continue;
        noteOnce("several files hold the same iteration; their steps stand in the order of the files");
    }
    return success();
}

Status OpenpmdSource::openStep(std::size_t step) {
    if (openStep_ == step) return success();
    openStep_ = static_cast<std::size_t>(-1);
    open_.reset();
    const OpenpmdPlace& place = places_[step];
    if (place.species) {
        // All of an ADIOS2 file's names are read when it is opened.
        if (!openFile_ || !openFile_->bp() || openPath_ != place.file) {
            openFile_.reset();
            MOTE_ASSIGN_OR_RETURN(auto file, H5File::open(place.file));
            if (!place.root.empty()) MOTE_RETURN_IF_ERROR(file.enter(place.root));
            openFile_ = std::move(file);
            openPath_ = place.file;
        }
        MOTE_ASSIGN_OR_RETURN(auto species,
                              OpenpmdSpecies::open(*openFile_, *place.species, place.iteration, wantedMass_));
        if (species.rows() != steps_[step].particles) {
            return corrupt(steps_[step].file, "has changed since it was opened");
        }
        open_ = std::make_shared<const OpenpmdSpecies>(std::move(species));
    }
    openStep_ = step;
    return success();
}

Status OpenpmdSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    std::unique_lock lock(opening_);
    MOTE_RETURN_IF_ERROR(openStep(step));
    const auto species = open_;
    if (!species) return success();
    // A file that was made anew may be of another kind.
    if (species->readsAtOnce()) lock.unlock();
    return species->read(wanted, records(), chunk);
}

Result<std::unique_ptr<ParticleSource>> openOpenpmd(const AskedRun& run, Progress& progress) {
    return openSeries(std::make_unique<OpenpmdSource>(run.job.species(), run.mass, progress), run.files);
}

constexpr std::string_view openpmdTold = "HDF5 or ADIOS2 with openPMD's attributes or records";

}  // namespace

extern const ParticleReader openpmdReader;
constinit const ParticleReader openpmdReader{
    "openpmd", openpmdTold, ParticleReader::Kind::hdf5,
    [](const AskedFile& file) -> Result<bool> { return looksLikeOpenpmd(*file.hdf5); }, openOpenpmd};
extern const ParticleReader openpmdBelowReader;
constinit const ParticleReader openpmdBelowReader{
    "openpmd", openpmdTold, ParticleReader::Kind::hdf5,
    [](const AskedFile& file) -> Result<bool> { return holdsOpenpmd(*file.hdf5); }, openOpenpmd};

}  // namespace mote::prep
